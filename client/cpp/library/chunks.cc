// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/chunks.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "client/decoder/chunk_decoder.h"
#include "core/base/status_macros.h"
#include "core/codec/draco_decode.h"
#include "core/codec/octahedral.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

// Chunks that are decoded in one call: enough to be fast, and few enough for the cache.
constexpr size_t kBatch = 16;

Vec3d Origin(const v1::Quantisation& quantisation) {
  return {quantisation.origin().x(), quantisation.origin().y(), quantisation.origin().z()};
}

absl::Status WrongSize(std::string_view encoding, size_t got, size_t expected) {
  return absl::DataLossError(
      fmt::format("a {} chunk holds {} values or bytes instead of {}", encoding, got, expected));
}

bool HasNormals(const v1::ViewOptions& view) { return view.normals() != v1::NORMAL_MODE_NONE; }

absl::Status DecodeRaw(std::string_view data, size_t point_count, const v1::ViewOptions& view,
                       Vec3d origin, DecodedPoints* points) {
  const size_t floats = HasNormals(view) ? 6 : 3;
  if (data.size() != point_count * floats * sizeof(float)) {
    return WrongSize("RAW", data.size(), point_count * floats * sizeof(float));
  }
  for (size_t i = 0; i < point_count; ++i) {
    float value[6];
    std::memcpy(value, data.data() + i * floats * sizeof(float), floats * sizeof(float));
    points->positions.push_back(origin + ToDouble({value[0], value[1], value[2]}));
    if (floats == 6) points->normals.push_back({value[3], value[4], value[5]});
  }
  return absl::OkStatus();
}

// Returns value i of a plane with `width` bytes per value, little endian.
uint32_t PlaneValue(std::string_view plane, size_t width, size_t i) {
  uint32_t value = 0;
  std::memcpy(&value, plane.data() + width * i, width);
  return value;
}

absl::Status DecodeQuantised(std::string_view data, size_t point_count, const v1::ViewOptions& view,
                             Vec3d origin, const v1::Quantisation& quantisation,
                             DecodedPoints* points) {
  const size_t width = !HasNormals(view) ? 0 : quantisation.normal_bits() <= 8 ? 1 : 2;
  if (data.size() != point_count * (6 + 2 * width)) {
    return WrongSize("QUANTISED", data.size(), point_count * (6 + 2 * width));
  }
  const auto plane = [&](size_t begin) { return data.substr(begin * point_count); };
  for (size_t i = 0; i < point_count; ++i) {
    const Vec3d integers{static_cast<double>(PlaneValue(plane(0), 2, i)),
                         static_cast<double>(PlaneValue(plane(2), 2, i)),
                         static_cast<double>(PlaneValue(plane(4), 2, i))};
    points->positions.push_back(origin + integers * quantisation.step());
    if (width == 0) continue;
    points->normals.push_back(
        DequantiseNormal({static_cast<int32_t>(PlaneValue(plane(6), width, i)),
                          static_cast<int32_t>(PlaneValue(plane(6 + width), width, i))},
                         quantisation.normal_bits()));
  }
  return absl::OkStatus();
}

// Appends points x y z 0 s t, of which `integers` has kNumbersPerPoint numbers each.
void AppendIntegers(std::span<const uint16_t> integers, bool has_normals,
                    const v1::Quantisation& quantisation, DecodedPoints* points) {
  const Vec3d origin = Origin(quantisation);
  const double step = quantisation.step();
  for (; !integers.empty(); integers = integers.subspan(decoder::kNumbersPerPoint)) {
    points->positions.push_back(
        origin + Vec3d{double(integers[0]), double(integers[1]), double(integers[2])} * step);
    if (!has_normals) continue;
    points->normals.push_back(
        DequantiseNormal({integers[4], integers[5]}, quantisation.normal_bits()));
  }
}

absl::Status DecodeByLibdraco(const EncodedChunk& chunk, bool has_normals,
                              std::span<uint16_t> integers) {
  const auto decoded = DecodeDracoChunkIntegers(
      {reinterpret_cast<const uint8_t*>(chunk.data.data()), chunk.data.size()});
  if (!decoded.ok()) return absl::DataLossError(std::string(decoded.status().message()));
  const size_t normal_values = has_normals ? 2 * chunk.point_count : 0;
  if (decoded->positions.size() != 3 * chunk.point_count) {
    return WrongSize("DRACO", decoded->positions.size(), 3 * chunk.point_count);
  }
  if (decoded->normals.size() != normal_values) {
    return WrongSize("DRACO", decoded->normals.size(), normal_values);
  }
  for (size_t i = 0; i < chunk.point_count; ++i) {
    uint16_t* const point = &integers[decoder::kNumbersPerPoint * i];
    for (size_t c = 0; c < 3; ++c) point[c] = static_cast<uint16_t>(decoded->positions[3 * i + c]);
    for (size_t c = 0; c < 2 && has_normals; ++c) {
      point[4 + c] = static_cast<uint16_t>(decoded->normals[2 * i + c]);
    }
  }
  return absl::OkStatus();
}

// Decodes the first chunks that have the same bits. Returns how many.
absl::StatusOr<size_t> DecodeDraco(std::span<const EncodedChunk> chunks, bool has_normals,
                                   decoder::ChunkDecoder* decoder, DecodedPoints* points) {
  const v1::Quantisation& first = *chunks.front().quantisation;
  const decoder::ChunkForm form{
      .position_bits = static_cast<int>(first.bits()),
      .normal_bits = has_normals ? static_cast<int>(first.normal_bits()) : 0};
  std::array<decoder::ChunkJob, kBatch> jobs;
  std::array<size_t, kBatch + 1> begins{};
  size_t count = 0;
  for (; count < std::min(chunks.size(), kBatch); ++count) {
    const v1::Quantisation& quantisation = *chunks[count].quantisation;
    if (quantisation.bits() != first.bits() || quantisation.normal_bits() != first.normal_bits()) {
      break;
    }
    begins[count + 1] = begins[count] + decoder::kNumbersPerPoint * chunks[count].point_count;
  }
  std::vector<uint16_t> integers(begins[count]);
  for (size_t i = 0; i < count; ++i) {
    const std::string_view data = chunks[i].data;
    jobs[i] = {.stream = {reinterpret_cast<const uint8_t*>(data.data()), data.size()},
               .points = static_cast<uint32_t>(chunks[i].point_count),
               .out = integers.data() + begins[i]};
  }
  decoder->Decode(form, std::span(jobs).first(count));
  for (size_t i = 0; i < count; ++i) {
    const std::span own = std::span(integers).subspan(begins[i], begins[i + 1] - begins[i]);
    if (!jobs[i].decoded) {
      LATTICED_RETURN_IF_ERROR(DecodeByLibdraco(chunks[i], has_normals, own));
    }
    AppendIntegers(own, has_normals, *chunks[i].quantisation, points);
  }
  return count;
}

absl::Status DecodeDracoChunks(std::span<const EncodedChunk> chunks, const v1::ViewOptions& view,
                               DecodedPoints* points) {
  decoder::ChunkDecoder decoder;
  while (!chunks.empty()) {
    LATTICED_ASSIGN_OR_RETURN(const size_t count,
                              DecodeDraco(chunks, HasNormals(view), &decoder, points));
    chunks = chunks.subspan(count);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DecodeChunks(std::span<const EncodedChunk> chunks, const v1::ViewOptions& view,
                          DecodedPoints* points) {
  switch (view.encoding()) {
    case v1::ENCODING_RAW:
      for (const EncodedChunk& chunk : chunks) {
        LATTICED_RETURN_IF_ERROR(
            DecodeRaw(chunk.data, chunk.point_count, view, Origin(*chunk.quantisation), points));
      }
      return absl::OkStatus();
    case v1::ENCODING_QUANTISED:
      for (const EncodedChunk& chunk : chunks) {
        LATTICED_RETURN_IF_ERROR(DecodeQuantised(chunk.data, chunk.point_count, view,
                                                 Origin(*chunk.quantisation), *chunk.quantisation,
                                                 points));
      }
      return absl::OkStatus();
    case v1::ENCODING_DRACO_POINTS:
    case v1::ENCODING_DRACO_MESH:
      return DecodeDracoChunks(chunks, view, points);
    default:
      return absl::DataLossError(
          fmt::format("the server sent encoding {}, which this client does not know",
                      static_cast<int>(view.encoding())));
  }
}

}  // namespace latticed::client
