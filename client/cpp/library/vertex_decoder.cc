// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/vertex_decoder.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>
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

static_assert(sizeof(GridVertex) == decoder::kNumbersPerPoint * sizeof(uint16_t));
static_assert(sizeof(WorldVertex) == 6 * sizeof(float));

bool HasNormals(const v1::ViewOptions& view) { return view.normals() != v1::NORMAL_MODE_NONE; }

size_t CountPoints(std::span<const EncodedChunk> chunks) {
  size_t count = 0;
  for (const EncodedChunk& chunk : chunks) count += chunk.point_count;
  return count;
}

absl::Status CheckMemory(size_t got, size_t points) {
  if (got == points) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("there is memory for {} points, the chunks have {}", got, points));
}

absl::Status WrongSize(std::string_view encoding, size_t got, size_t expected) {
  return absl::DataLossError(
      fmt::format("a {} chunk holds {} values or bytes instead of {}", encoding, got, expected));
}

std::span<const uint8_t> Bytes(const EncodedChunk& chunk) {
  return {reinterpret_cast<const uint8_t*>(chunk.data.data()), chunk.data.size()};
}

Vec3d Origin(const v1::Quantisation& quantisation) {
  return {quantisation.origin().x(), quantisation.origin().y(), quantisation.origin().z()};
}

// Where points in world coordinates go.
class WorldVertices {
 public:
  explicit WorldVertices(WorldVertex* at) : at_(at) {}
  void Put(Vec3d position, Vec3f normal) { *at_++ = {ToFloat(position), normal}; }

 private:
  WorldVertex* at_;
};
// Growing is as fast as sizing the vectors first, which writes zeros.
class PointVectors {
 public:
  PointVectors(bool has_normals, DecodedPoints* points)
      : has_normals_(has_normals), points_(points) {}
  void Put(Vec3d position, Vec3f normal) {
    points_->positions.push_back(position);
    if (has_normals_) points_->normals.push_back(normal);
  }

 private:
  const bool has_normals_;
  DecodedPoints* const points_;
};

template <class Sink>
absl::Status DecodeRaw(const EncodedChunk& chunk, bool has_normals, Sink& sink) {
  const size_t floats = has_normals ? 6 : 3;
  const size_t bytes = chunk.point_count * floats * sizeof(float);
  if (chunk.data.size() != bytes) return WrongSize("RAW", chunk.data.size(), bytes);
  const Vec3d origin = Origin(*chunk.quantisation);
  for (size_t i = 0; i < chunk.point_count; ++i) {
    float value[6] = {};
    std::memcpy(value, chunk.data.data() + i * floats * sizeof(float), floats * sizeof(float));
    sink.Put(origin + ToDouble({value[0], value[1], value[2]}), {value[3], value[4], value[5]});
  }
  return absl::OkStatus();
}

template <class Sink>
void PutGrid(std::span<const GridVertex> vertices, const v1::Quantisation& quantisation,
             bool has_normals, Sink& sink) {
  const Vec3d origin = Origin(quantisation);
  const double step = quantisation.step();
  const auto bits = static_cast<int>(quantisation.normal_bits());
  for (const GridVertex& v : vertices) {
    const Vec3d position = origin + Vec3d{double(v.x), double(v.y), double(v.z)} * step;
    sink.Put(position, has_normals ? DequantiseNormal({v.s, v.t}, bits) : Vec3f{});
  }
}

absl::Status DecodeQuantised(const EncodedChunk& chunk, bool has_normals, GridVertex* vertices) {
  const size_t count = chunk.point_count;
  const size_t width = !has_normals ? 0 : chunk.quantisation->normal_bits() <= 8 ? 1 : 2;
  if (chunk.data.size() != count * (6 + 2 * width)) {
    return WrongSize("QUANTISED", chunk.data.size(), count * (6 + 2 * width));
  }
  // Planes of values, little endian, with `bytes` bytes each.
  const auto value = [&](size_t first, size_t bytes, size_t i) {
    uint16_t number = 0;
    std::memcpy(&number, chunk.data.data() + first * count + bytes * i, bytes);
    return number;
  };
  for (size_t i = 0; i < count; ++i) {
    vertices[i] = {.x = value(0, 2, i),
                   .y = value(2, 2, i),
                   .z = value(4, 2, i),
                   .s = value(6, width, i),
                   .t = value(6 + width, width, i)};
  }
  return absl::OkStatus();
}

absl::Status DecodeByLibdraco(const EncodedChunk& chunk, bool has_normals, GridVertex* vertices) {
  const auto decoded = DecodeDracoChunkIntegers(Bytes(chunk));
  if (!decoded.ok()) return absl::DataLossError(std::string(decoded.status().message()));
  const auto& [positions, normals] = *decoded;
  const size_t count = chunk.point_count, normal_values = has_normals ? 2 * count : 0;
  if (positions.size() != 3 * count) return WrongSize("DRACO", positions.size(), 3 * count);
  if (normals.size() != normal_values) return WrongSize("DRACO", normals.size(), normal_values);
  uint32_t all_bits = 0;
  const auto narrow = [&](uint32_t value) {
    all_bits |= value;
    return static_cast<uint16_t>(value);
  };
  for (size_t i = 0; i < count; ++i) {
    const uint32_t* const p = &positions[3 * i];
    vertices[i] = {.x = narrow(p[0]), .y = narrow(p[1]), .z = narrow(p[2])};
    if (!has_normals) continue;
    vertices[i].s = narrow(normals[2 * i]);
    vertices[i].t = narrow(normals[2 * i + 1]);
  }
  if (all_bits <= std::numeric_limits<uint16_t>::max()) return absl::OkStatus();
  return absl::DataLossError("a DRACO chunk holds numbers of more than 16 bits");
}

// Decodes the first chunks that have the same bits, kBatch at most. Returns how many.
absl::StatusOr<size_t> DecodeBatch(std::span<const EncodedChunk> chunks, decoder::Codec codec,
                                   bool has_normals, decoder::ChunkDecoder& decoder,
                                   GridVertex* vertices) {
  const v1::Quantisation& first = *chunks.front().quantisation;
  const decoder::ChunkForm form{
      .position_bits = static_cast<int>(first.bits()),
      .normal_bits = has_normals ? static_cast<int>(first.normal_bits()) : 0,
      .codec = codec};
  std::array<decoder::ChunkJob, kBatch> jobs;
  size_t count = 0;
  for (; count < std::min(chunks.size(), kBatch); ++count) {
    const EncodedChunk& chunk = chunks[count];
    if (chunk.quantisation->bits() != first.bits() ||
        chunk.quantisation->normal_bits() != first.normal_bits()) {
      break;
    }
    jobs[count] = {.stream = Bytes(chunk),
                   .points = static_cast<uint32_t>(chunk.point_count),
                   .out = &vertices->x};
    vertices += chunk.point_count;
  }
  // A grid without bits for the normals of its view contradicts it: libdraco says what is wrong.
  if (!has_normals || form.normal_bits > 0) decoder.Decode(form, std::span(jobs).first(count));
  for (size_t i = 0; i < count; ++i) {
    if (jobs[i].decoded) continue;
    if (codec == decoder::Codec::kMeshopt) {
      return absl::DataLossError("a chunk is no meshopt stream of its view");
    }
    auto* const out = reinterpret_cast<GridVertex*>(jobs[i].out);
    LATTICED_RETURN_IF_ERROR(DecodeByLibdraco(chunks[i], has_normals, out));
  }
  return count;
}

}  // namespace

struct VertexDecoder::Workspace {
  decoder::ChunkDecoder decoder;
  std::vector<GridVertex> batch;

  absl::Status ToGrid(std::span<const EncodedChunk> chunks, const v1::ViewOptions& view,
                      GridVertex* vertices);
  absl::Status DecodeInBatches(std::span<const EncodedChunk> chunks, decoder::Codec codec,
                               bool has_normals, GridVertex* vertices);
  template <class Sink>
  absl::Status ToWorld(std::span<const EncodedChunk> chunks, const v1::ViewOptions& view,
                       Sink sink);
};

absl::Status VertexDecoder::Workspace::DecodeInBatches(std::span<const EncodedChunk> chunks,
                                                       decoder::Codec codec, bool has_normals,
                                                       GridVertex* vertices) {
  while (!chunks.empty()) {
    LATTICED_ASSIGN_OR_RETURN(const size_t count,
                              DecodeBatch(chunks, codec, has_normals, decoder, vertices));
    vertices += CountPoints(chunks.first(count));
    chunks = chunks.subspan(count);
  }
  return absl::OkStatus();
}

absl::Status VertexDecoder::Workspace::ToGrid(std::span<const EncodedChunk> chunks,
                                              const v1::ViewOptions& view, GridVertex* vertices) {
  switch (view.encoding()) {
    case v1::ENCODING_QUANTISED:
      for (const EncodedChunk& chunk : chunks) {
        LATTICED_RETURN_IF_ERROR(DecodeQuantised(chunk, HasNormals(view), vertices));
        vertices += chunk.point_count;
      }
      return absl::OkStatus();
    case v1::ENCODING_DRACO_POINTS:
    case v1::ENCODING_DRACO_MESH:
      return DecodeInBatches(chunks, decoder::Codec::kDraco, HasNormals(view), vertices);
    case v1::ENCODING_MESHOPT:
      return DecodeInBatches(chunks, decoder::Codec::kMeshopt, HasNormals(view), vertices);
    default:
      return absl::DataLossError(
          fmt::format("the server sent encoding {}, which this client does not know",
                      static_cast<int>(view.encoding())));
  }
}

template <class Sink>
absl::Status VertexDecoder::Workspace::ToWorld(std::span<const EncodedChunk> chunks,
                                               const v1::ViewOptions& view, Sink sink) {
  const bool has_normals = HasNormals(view);
  if (view.encoding() == v1::ENCODING_RAW) {
    for (const EncodedChunk& chunk : chunks) {
      LATTICED_RETURN_IF_ERROR(DecodeRaw(chunk, has_normals, sink));
    }
    return absl::OkStatus();
  }
  while (!chunks.empty()) {
    const auto some = chunks.first(std::min(chunks.size(), kBatch));
    if (batch.size() < CountPoints(some)) batch.resize(CountPoints(some));
    LATTICED_RETURN_IF_ERROR(ToGrid(some, view, batch.data()));
    const GridVertex* vertices = batch.data();
    for (const EncodedChunk& chunk : some) {
      PutGrid({vertices, chunk.point_count}, *chunk.quantisation, has_normals, sink);
      vertices += chunk.point_count;
    }
    chunks = chunks.subspan(some.size());
  }
  return absl::OkStatus();
}

VertexDecoder::VertexDecoder() : workspace_(std::make_unique<Workspace>()) {}
VertexDecoder::~VertexDecoder() = default;

absl::Status VertexDecoder::Decode(std::span<const EncodedChunk> chunks,
                                   const v1::ViewOptions& view, std::span<GridVertex> vertices) {
  LATTICED_RETURN_IF_ERROR(CheckMemory(vertices.size(), CountPoints(chunks)));
  if (view.encoding() == v1::ENCODING_RAW) {
    return absl::InvalidArgumentError("ENCODING_RAW has no grid: decode to world coordinates");
  }
  return workspace_->ToGrid(chunks, view, vertices.data());
}

absl::Status VertexDecoder::Decode(std::span<const EncodedChunk> chunks,
                                   const v1::ViewOptions& view, std::span<WorldVertex> vertices) {
  LATTICED_RETURN_IF_ERROR(CheckMemory(vertices.size(), CountPoints(chunks)));
  return workspace_->ToWorld(chunks, view, WorldVertices(vertices.data()));
}

absl::Status VertexDecoder::Decode(std::span<const EncodedChunk> chunks,
                                   const v1::ViewOptions& view, DecodedPoints* points) {
  const bool has_normals = HasNormals(view);
  points->positions.reserve(points->positions.size() + CountPoints(chunks));
  if (has_normals) points->normals.reserve(points->normals.size() + CountPoints(chunks));
  return workspace_->ToWorld(chunks, view, PointVectors(has_normals, points));
}

}  // namespace latticed::client
