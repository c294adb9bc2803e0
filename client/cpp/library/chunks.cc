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

std::span<const uint8_t> Bytes(const EncodedChunk& chunk) {
  return {reinterpret_cast<const uint8_t*>(chunk.data.data()), chunk.data.size()};
}

absl::Status DecodeRaw(const EncodedChunk& chunk, bool has_normals, DecodedPoints* points) {
  const size_t floats = has_normals ? 6 : 3;
  const size_t bytes = chunk.point_count * floats * sizeof(float);
  if (chunk.data.size() != bytes) return WrongSize("RAW", chunk.data.size(), bytes);
  const Vec3d origin = Origin(*chunk.quantisation);
  for (size_t i = 0; i < chunk.point_count; ++i) {
    float value[6];
    std::memcpy(value, chunk.data.data() + i * floats * sizeof(float), floats * sizeof(float));
    points->positions.push_back(origin + ToDouble({value[0], value[1], value[2]}));
    if (has_normals) points->normals.push_back({value[3], value[4], value[5]});
  }
  return absl::OkStatus();
}

// Returns value i of a plane with `width` bytes per value, little endian.
uint32_t PlaneValue(std::string_view plane, size_t width, size_t i) {
  uint32_t value = 0;
  std::memcpy(&value, plane.data() + width * i, width);
  return value;
}

// Appends points of integers.
class GridPoints {
 public:
  GridPoints(const v1::Quantisation& quantisation, bool has_normals, DecodedPoints* points)
      : origin_(Origin(quantisation)),
        step_(quantisation.step()),
        normal_bits_(static_cast<int>(quantisation.normal_bits())),
        has_normals_(has_normals),
        points_(points) {}

  void Append(Vec3d integers, OctahedralNormal normal) {
    points_->positions.push_back(origin_ + integers * step_);
    if (has_normals_) points_->normals.push_back(DequantiseNormal(normal, normal_bits_));
  }

 private:
  const Vec3d origin_;
  const double step_;
  const int normal_bits_;
  const bool has_normals_;
  DecodedPoints* const points_;
};

absl::Status DecodeQuantised(const EncodedChunk& chunk, bool has_normals, DecodedPoints* points) {
  const size_t count = chunk.point_count;
  const size_t width = !has_normals ? 0 : chunk.quantisation->normal_bits() <= 8 ? 1 : 2;
  if (chunk.data.size() != count * (6 + 2 * width)) {
    return WrongSize("QUANTISED", chunk.data.size(), count * (6 + 2 * width));
  }
  const auto plane = [&](size_t begin) { return chunk.data.substr(begin * count); };
  const auto normal = [&](size_t begin, size_t i) {
    return static_cast<int32_t>(PlaneValue(plane(begin), width, i));
  };
  GridPoints grid(*chunk.quantisation, has_normals, points);
  for (size_t i = 0; i < count; ++i) {
    grid.Append({static_cast<double>(PlaneValue(plane(0), 2, i)),
                 static_cast<double>(PlaneValue(plane(2), 2, i)),
                 static_cast<double>(PlaneValue(plane(4), 2, i))},
                {normal(6, i), normal(6 + width, i)});
  }
  return absl::OkStatus();
}

absl::Status DecodeByLibdraco(const EncodedChunk& chunk, bool has_normals, DecodedPoints* points) {
  const auto decoded = DecodeDracoChunkIntegers(Bytes(chunk));
  if (!decoded.ok()) return absl::DataLossError(std::string(decoded.status().message()));
  const size_t normal_values = has_normals ? 2 * chunk.point_count : 0;
  if (decoded->positions.size() != 3 * chunk.point_count) {
    return WrongSize("DRACO", decoded->positions.size(), 3 * chunk.point_count);
  }
  if (decoded->normals.size() != normal_values) {
    return WrongSize("DRACO", decoded->normals.size(), normal_values);
  }
  GridPoints grid(*chunk.quantisation, has_normals, points);
  for (size_t i = 0; i < chunk.point_count; ++i) {
    const uint32_t* const p = &decoded->positions[3 * i];
    OctahedralNormal normal;
    if (has_normals) {
      normal = {static_cast<int32_t>(decoded->normals[2 * i]),
                static_cast<int32_t>(decoded->normals[2 * i + 1])};
    }
    grid.Append({double(p[0]), double(p[1]), double(p[2])}, normal);
  }
  return absl::OkStatus();
}

// Decodes the first chunks that have the same bits. Returns how many.
absl::StatusOr<size_t> DecodeBatch(std::span<const EncodedChunk> chunks, decoder::Codec codec,
                                   bool has_normals, decoder::ChunkDecoder* decoder,
                                   std::vector<uint16_t>* integers, DecodedPoints* points) {
  const v1::Quantisation& first = *chunks.front().quantisation;
  const decoder::ChunkForm form{
      .position_bits = static_cast<int>(first.bits()),
      .normal_bits = has_normals ? static_cast<int>(first.normal_bits()) : 0,
      .codec = codec};
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
  if (integers->size() < begins[count]) integers->resize(begins[count]);
  for (size_t i = 0; i < count; ++i) {
    jobs[i] = {.stream = Bytes(chunks[i]),
               .points = static_cast<uint32_t>(chunks[i].point_count),
               .out = integers->data() + begins[i]};
  }
  // A grid without bits for the normals of its view contradicts it: libdraco says what is wrong.
  if (!has_normals || form.normal_bits > 0) decoder->Decode(form, std::span(jobs).first(count));
  for (size_t i = 0; i < count; ++i) {
    if (!jobs[i].decoded && codec == decoder::Codec::kMeshopt) {
      return absl::DataLossError("a chunk is no meshopt stream of its view");
    }
    if (!jobs[i].decoded) {
      LATTICED_RETURN_IF_ERROR(DecodeByLibdraco(chunks[i], has_normals, points));
      continue;
    }
    GridPoints grid(*chunks[i].quantisation, has_normals, points);
    for (size_t at = begins[i]; at < begins[i + 1]; at += decoder::kNumbersPerPoint) {
      const uint16_t* const n = integers->data() + at;
      grid.Append({double(n[0]), double(n[1]), double(n[2])}, {n[4], n[5]});
    }
  }
  return count;
}

absl::Status DecodeInBatches(std::span<const EncodedChunk> chunks, decoder::Codec codec,
                             bool has_normals, DecodedPoints* points) {
  decoder::ChunkDecoder decoder;
  std::vector<uint16_t> integers;
  while (!chunks.empty()) {
    LATTICED_ASSIGN_OR_RETURN(const size_t count,
                              DecodeBatch(chunks, codec, has_normals, &decoder, &integers, points));
    chunks = chunks.subspan(count);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status DecodeChunks(std::span<const EncodedChunk> chunks, const v1::ViewOptions& view,
                          DecodedPoints* points) {
  const bool has_normals = view.normals() != v1::NORMAL_MODE_NONE;
  size_t count = points->positions.size();
  for (const EncodedChunk& chunk : chunks) count += chunk.point_count;
  points->positions.reserve(count);
  if (has_normals) points->normals.reserve(count);
  switch (view.encoding()) {
    case v1::ENCODING_RAW:
      for (const EncodedChunk& chunk : chunks) {
        LATTICED_RETURN_IF_ERROR(DecodeRaw(chunk, has_normals, points));
      }
      return absl::OkStatus();
    case v1::ENCODING_QUANTISED:
      for (const EncodedChunk& chunk : chunks) {
        LATTICED_RETURN_IF_ERROR(DecodeQuantised(chunk, has_normals, points));
      }
      return absl::OkStatus();
    case v1::ENCODING_DRACO_POINTS:
    case v1::ENCODING_DRACO_MESH:
      return DecodeInBatches(chunks, decoder::Codec::kDraco, has_normals, points);
    case v1::ENCODING_MESHOPT:
      return DecodeInBatches(chunks, decoder::Codec::kMeshopt, has_normals, points);
    default:
      return absl::DataLossError(
          fmt::format("the server sent encoding {}, which this client does not know",
                      static_cast<int>(view.encoding())));
  }
}

}  // namespace latticed::client
