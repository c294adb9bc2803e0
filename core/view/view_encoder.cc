// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/view_encoder.h"

#include <mutex>
#include <utility>

#include "core/base/limits.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace {

std::vector<std::array<uint32_t, 3>> ChunkTriangles(int segments) {
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  std::vector<std::array<uint32_t, 3>> triangles;
  triangles.reserve(pattern.triangles.size() * limits::kPatchesPerChunk);
  for (uint32_t p = 0; p < static_cast<uint32_t>(limits::kPatchesPerChunk); ++p) {
    const uint32_t base = p * static_cast<uint32_t>(pattern.points.size());
    for (const auto& t : pattern.triangles) {
      triangles.push_back({base + t[0], base + t[1], base + t[2]});
    }
  }
  return triangles;
}

}  // namespace

absl::StatusOr<std::vector<uint8_t>> ViewEncoder::EncodeDraco(
    uint32_t chunk, Encoding encoding, double range, std::span<const uint8_t> bytes) const {
  const size_t points = ChunkPoints(plan_, chunk, spec_.segments);
  const int normal_bits = spec_.normals == NormalMode::kNone ? 0 : spec_.normal_bits;
  const QuantisedVertices vertices =
      QuantisedVertices::FromBytes(bytes, points, spec_.position_bits, normal_bits);
  if (encoding == Encoding::kDracoPoints) return encoder_->EncodePoints(vertices, range);
  const auto [first, last] = plan_.ChunkPatches(chunk);
  const size_t triangles = (last - first) * static_cast<size_t>(TrianglesPerPatch(spec_.segments));
  return encoder_->EncodeMesh(vertices, range, std::span(triangles_).first(triangles));
}

absl::Status ViewEncoder::Encode(std::span<const uint32_t> chunks, Encoding encoding, double range,
                                 BytesOf bytes_of, std::span<SharedBytes> results) {
  if (encoding == Encoding::kDracoMesh && triangles_.empty()) {
    triangles_ = ChunkTriangles(spec_.segments);
  }
  const bool draco = encoding == Encoding::kDracoPoints || encoding == Encoding::kDracoMesh;
  std::mutex mutex;
  absl::Status first_error;
  arena_.ForEach(chunks.size(), [&](size_t i) {
    std::vector<uint8_t> scratch;
    const std::span<const uint8_t> bytes = bytes_of(i, scratch);
    if (!draco) {
      if (scratch.empty()) scratch.assign(bytes.begin(), bytes.end());
      results[i] = MakeSharedBytes(std::move(scratch));
      return;
    }
    auto encoded = EncodeDraco(chunks[i], encoding, range, bytes);
    if (encoded.ok()) {
      results[i] = MakeSharedBytes(*std::move(encoded));
      return;
    }
    const std::scoped_lock lock(mutex);
    first_error.Update(encoded.status());
  });
  return first_error;
}

}  // namespace latticed
