// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/view_encoder.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <utility>

#include "core/adaptive/adaptive_pattern.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace {

std::vector<std::array<uint32_t, 3>> ChunkTriangles(int segments, size_t patches) {
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  std::vector<std::array<uint32_t, 3>> triangles;
  triangles.reserve(pattern.triangles.size() * patches);
  for (size_t p = 0; p < patches; ++p) {
    const auto base = static_cast<uint32_t>(p * pattern.points.size());
    for (const auto& t : pattern.triangles) {
      triangles.push_back({base + t[0], base + t[1], base + t[2]});
    }
  }
  return triangles;
}

std::vector<std::array<uint32_t, 3>> PatternTriangles(std::span<const uint16_t> patterns) {
  std::vector<std::array<uint32_t, 3>> triangles;
  uint32_t base = 0;
  for (const uint16_t code : patterns) {
    const AdaptivePattern& pattern = AdaptivePattern::Get(*PatternKey::FromCode(code));
    for (const auto& t : pattern.triangles) {
      triangles.push_back({base + t[0], base + t[1], base + t[2]});
    }
    base += static_cast<uint32_t>(pattern.points.size());
  }
  return triangles;
}

size_t DivideUp(size_t count, size_t step) { return (count + step - 1) / step; }

// The size at which all threads get the same number of batches, none larger than `most`.
size_t BatchSize(size_t count, size_t most, size_t threads) {
  const size_t rounds = DivideUp(count, most * threads);
  return DivideUp(count, rounds * threads);
}

}  // namespace

VertexDigest DigestOf(std::span<const uint8_t> vertices) {
  const XXH128_hash_t hash = XXH3_128bits(vertices.data(), vertices.size());
  return {hash.low64 & ~uint64_t{1}, hash.high64};  // an even one is the host's
}

uint64_t EncoderBytesOf(const DeformPlan& plan, const ViewSpec& spec, const ChunkEncoder& encoder,
                        const CpuArena& arena) {
  if (plan.chunk_count() == 0) return 0;
  const int normal_bits = spec.normals == NormalMode::kNone ? 0 : spec.normal_bits;
  return arena.most_threads() *
         encoder.WorkingBytes(ChunkPoints(plan, 0, spec.segments), spec.position_bits, normal_bits);
}

size_t ViewEncoder::PointsOf(uint32_t chunk) const {
  return patterns_of_ ? PatternPoints(patterns_of_(chunk))
                      : ChunkPoints(plan_, chunk, spec_.segments);
}

QuantisedVertices ViewEncoder::VerticesOf(uint32_t chunk, std::span<const uint8_t> bytes) const {
  const int normal_bits = spec_.normals == NormalMode::kNone ? 0 : spec_.normal_bits;
  return QuantisedVertices::FromBytes(bytes, PointsOf(chunk), spec_.position_bits, normal_bits);
}

const ChunkConnectivity& ViewEncoder::Connectivity(uint32_t chunk) {
  const auto [first, last] = plan_.ChunkPatches(chunk);
  const auto known = connectivity_.find(last - first);
  if (known != connectivity_.end()) return known->second;
  return connectivity_
      .try_emplace(last - first, ChunkPoints(plan_, chunk, spec_.segments),
                   ChunkTriangles(spec_.segments, last - first))
      .first->second;
}

size_t ViewEncoder::MemoryBytes() const {
  size_t bytes = 0;
  for (const auto& [patches, connectivity] : connectivity_) bytes += connectivity.MemoryBytes();
  return bytes;
}

uint64_t ViewEncoder::MostBytes(const ViewSpec& spec) {
  // Two connectivities, each of indices and their code. The code takes no more bytes than the indices.
  constexpr uint64_t kTriangleBytes = 2 * 2 * sizeof(std::array<uint32_t, 3>);
  return kTriangleBytes * limits::kPatchesPerChunk *
         static_cast<uint64_t>(TrianglesPerPatch(spec.segments));
}

std::vector<size_t> ViewEncoder::FindChanged(size_t count, BytesOf bytes_of,
                                             std::span<VertexDigest> digests) {
  std::vector<size_t> places(count);
  std::iota(places.begin(), places.end(), size_t{0});
  if (digests.empty()) return places;
  std::vector<uint8_t> changed(count);  // bytes, because threads write neighbours at once
  arena_.ForEach(count, [&](size_t i) {
    std::vector<uint8_t> scratch;
    const VertexDigest digest = DigestOf(bytes_of(i, scratch));
    changed[i] = std::exchange(digests[i], digest) != digest;
  });
  std::erase_if(places, [&changed](size_t i) { return changed[i] == 0; });
  return places;
}

absl::Status ViewEncoder::EncodeDraco(std::span<const uint32_t> chunks,
                                      std::span<const size_t> places, Encoding encoding,
                                      double range, BytesOf bytes_of,
                                      std::span<SharedBytes> results) const {
  std::vector<std::vector<uint8_t>> scratch(places.size()), streams(places.size());
  std::vector<QuantisedVertices> vertices(places.size());
  for (size_t p = 0; p < places.size(); ++p) {
    vertices[p] = VerticesOf(chunks[places[p]], bytes_of(places[p], scratch[p]));
    vertices[p].is_sparse = static_cast<bool>(patterns_of_);
  }
  const bool is_mesh = encoding == Encoding::kDracoMesh;
  for (size_t begin = 0, end = 0; begin < vertices.size(); begin = end) {
    const ChunkConnectivity* connectivity = nullptr;
    std::optional<ChunkConnectivity> of_patterns;
    if (is_mesh && patterns_of_) {  // each chunk has triangles of its own
      const uint32_t chunk = chunks[places[begin]];
      connectivity = &of_patterns.emplace(PointsOf(chunk), PatternTriangles(patterns_of_(chunk)));
      end = begin + 1;
    } else {
      while (end < vertices.size() && vertices[end].SameShape(vertices[begin])) ++end;
    }
    if (is_mesh && !patterns_of_) {
      const auto [first_patch, last_patch] = plan_.ChunkPatches(chunks[places[begin]]);
      connectivity = &connectivity_.at(last_patch - first_patch);
    }
    const size_t count = end - begin;
    LATTICED_RETURN_IF_ERROR(encoder_->Encode(std::span(vertices).subspan(begin, count), range,
                                              connectivity,
                                              std::span(streams).subspan(begin, count)));
  }
  for (size_t p = 0; p < places.size(); ++p) {
    results[places[p]] = MakeSharedBytes(std::move(streams[p]));
  }
  return absl::OkStatus();
}

absl::Status ViewEncoder::Encode(std::span<const uint32_t> chunks, Encoding encoding, double range,
                                 BytesOf bytes_of, std::span<VertexDigest> digests,
                                 std::span<SharedBytes> results) {
  const std::vector<size_t> places = FindChanged(chunks.size(), bytes_of, digests);
  if (places.empty()) return absl::OkStatus();
  if (encoding == Encoding::kDracoMesh && !patterns_of_) {
    for (const uint32_t chunk : chunks) Connectivity(chunk);
  }
  if (!IsDraco(encoding)) {
    arena_.ForEach(places.size(), [&](size_t p) {
      std::vector<uint8_t> scratch;
      const std::span<const uint8_t> bytes = bytes_of(places[p], scratch);
      if (encoding == Encoding::kMeshopt) {
        results[places[p]] = MakeSharedBytes(EncodeMeshopt(VerticesOf(chunks[places[p]], bytes)));
        return;
      }
      if (scratch.empty()) scratch.assign(bytes.begin(), bytes.end());
      results[places[p]] = MakeSharedBytes(std::move(scratch));
    });
    return absl::OkStatus();
  }
  const size_t size = BatchSize(places.size(), encoder_->batch(), arena_.ThreadsFor(places.size()));
  return arena_.TryEach(DivideUp(places.size(), size), [&](size_t b) {
    const size_t first = b * size;
    const auto batch = std::span(places).subspan(first, std::min(size, places.size() - first));
    return EncodeDraco(chunks, batch, encoding, range, bytes_of, results);
  });
}

}  // namespace latticed
