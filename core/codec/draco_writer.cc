// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco_writer.h"

#include <algorithm>
#include <cstring>

#include "core/codec/draco_container.h"
#include "core/codec/draco_symbols.h"
#include "core/codec/symbol_stream.h"

namespace latticed {
namespace {

int32_t NormalValue(const uint8_t* plane, size_t point, int bits) {
  uint16_t value = plane[point];
  if (bits > 8) std::memcpy(&value, plane + 2 * point, sizeof(value));
  return std::min(int32_t{value}, OctahedralMax(bits));
}

struct Span { uint32_t least=65535, most=0; };
Span PositionSpan(const QuantisedVertices& vertices) {
  Span span;
  for (const uint16_t* plane : {vertices.x, vertices.y, vertices.z}) {
    for (size_t i = 0; i < vertices.point_count; ++i) {
      span.least = std::min(span.least, uint32_t{plane[i]});
      span.most = std::max(span.most, uint32_t{plane[i]});
    }
  }
  return span;
}

SymbolStream PositionStream(const QuantisedVertices& vertices, Span span) {
  const uint32_t wrap = span.most - span.least + 1;
  SymbolStream stream(vertices.point_count, 3, vertices.position_bits);
  const uint16_t* planes[] = {vertices.x, vertices.y, vertices.z};
  for (size_t c = 0; c < 3; ++c) {
    uint32_t previous = span.least;
    for (size_t i = 0; i < vertices.point_count; ++i) {
      const uint32_t value = planes[c][i];
      stream.plane(c)[i] = static_cast<uint16_t>(PositionSymbol(value, previous, wrap));
      previous = value;
    }
  }
  return stream;
}

SymbolStream NormalStream(const QuantisedVertices& vertices) {
  const int bits = vertices.normal_bits;
  SymbolStream stream(vertices.point_count, 2, bits);
  OctahedralNormal previous{};
  for (size_t i = 0; i < vertices.point_count; ++i) {
    const OctahedralNormal value{NormalValue(vertices.s, i, bits),
                                 NormalValue(vertices.t, i, bits)};
    const OctahedralNormal symbols = NormalSymbols(value, previous, bits);
    stream.plane(0)[i] = static_cast<uint16_t>(symbols.s);
    stream.plane(1)[i] = static_cast<uint16_t>(symbols.t);
    previous = value;
  }
  return stream;
}

}  // namespace

absl::StatusOr<std::vector<uint8_t>> DracoWriter::EncodePoints(const QuantisedVertices& vertices,
                                                               double range) const {
  const Span span = PositionSpan(vertices);
  std::vector<std::pair<DracoAttribute, SymbolStream>> attributes;
  attributes.emplace_back(DracoAttribute::kPosition, PositionStream(vertices, span));
  if (vertices.normal_bits > 0) {
    attributes.emplace_back(DracoAttribute::kNormal, NormalStream(vertices));
  }
  size_t most_bytes = kMostContainerBytes;
  for (auto& [attribute, symbols] : attributes) {
    symbols.Tabulate();
    symbols.Code();
    most_bytes += symbols.MostBytes();
  }

  std::vector<uint8_t> stream(most_bytes);
  ByteWriter out(stream.data());
  WriteCloudHead(vertices.point_count, vertices.normal_bits, out);
  for (const auto& [attribute, symbols] : attributes) {
    WritePrediction(attribute, out);
    symbols.Write(out);
    if (attribute == DracoAttribute::kPosition) WritePositionBounds(span.least, span.most, out);
    else WriteNormalBounds(vertices.normal_bits, out);
  }
  WriteDequantisation(vertices.position_bits, vertices.normal_bits, static_cast<float>(range), out);
  stream.resize(static_cast<size_t>(out.at() - stream.data()));
  return stream;
}

absl::StatusOr<std::vector<uint8_t>> DracoWriter::EncodeMesh(
    const QuantisedVertices&, double, std::span<const std::array<uint32_t, 3>>) const {
  return absl::UnimplementedError("not yet");
}

}  // namespace latticed
