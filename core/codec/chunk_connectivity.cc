// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/chunk_connectivity.h"

#include <algorithm>

#include "core/codec/byte_writer.h"
#include "core/codec/draco_container.h"
#include "core/codec/draco_kernel.h"
#include "core/codec/rans_encoder.h"
#include "core/codec/rans_model.h"
#include "core/codec/rans_table.h"

namespace latticed {
namespace {

// Each index minus the one before it; the sign is in the lowest bit.
std::vector<uint32_t> IndexSymbols(std::span<const std::array<uint32_t, 3>> triangles) {
  std::vector<uint32_t> symbols;
  symbols.reserve(3 * triangles.size());
  uint32_t last = 0;
  for (const auto& triangle : triangles) {
    for (const uint32_t index : triangle) {
      symbols.push_back(index < last ? (last - index) << 1 | 1 : (index - last) << 1);
      last = index;
    }
  }
  return symbols;
}

std::vector<uint8_t> CodeSymbols(std::span<const uint32_t> symbols) {
  const size_t end = *std::max_element(symbols.begin(), symbols.end()) + size_t{1};
  std::vector<uint32_t> counts(end + draco_kernel::kPadding);
  for (const uint32_t symbol : symbols) ++counts[symbol];
  RansTable table;
  table.Reserve(end);
  table.Build(counts, 1, counts.size(), end);

  std::vector<RansEntry> entries(end);
  table.ForEach([&](uint32_t symbol, uint32_t probability, uint32_t cumulative) {
    entries[symbol] = MakeRansEntry(probability, cumulative);
  });
  std::vector<uint8_t> coded(MostRansBytes(symbols.size(), table.precision()));
  RansEncoder encoder(table.precision(), coded.data());
  for (size_t i = symbols.size(); i-- > 0;) encoder.Put(entries[symbols[i]]);
  coded.resize(static_cast<size_t>(encoder.Finish() - coded.data()));

  std::vector<uint8_t> bytes(2 + table.MostBytes() + kMostVarintBytes + coded.size());
  ByteWriter out(bytes.data());
  out.Byte(kSchemeRaw);
  out.Byte(static_cast<uint32_t>(table.bit_length()));
  table.Write(out);
  out.Varint(coded.size());
  out.Bytes(coded);
  bytes.resize(static_cast<size_t>(out.at() - bytes.data()));
  return bytes;
}

}  // namespace

ChunkConnectivity::ChunkConnectivity(size_t point_count,
                                     std::span<const std::array<uint32_t, 3>> triangles)
    : triangles_(triangles.begin(), triangles.end()) {
  std::vector<uint8_t> symbols;
  if (!triangles.empty()) symbols = CodeSymbols(IndexSymbols(triangles));
  bytes_.resize(2 * kMostVarintBytes + 1 + symbols.size());
  ByteWriter out(bytes_.data());
  out.Varint(triangles.size());
  out.Varint(point_count);
  out.Byte(draco_format::kCompressedIndices);
  out.Bytes(symbols);
  bytes_.resize(static_cast<size_t>(out.at() - bytes_.data()));
}

size_t ChunkConnectivity::LeastStreamBytes() const { return LeastMeshBytes(triangles_.size()); }

size_t ChunkConnectivity::MemoryBytes() const {
  return triangles_.capacity() * sizeof(triangles_[0]) + bytes_.capacity();
}

}  // namespace latticed
