// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/backend.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/adaptive/adaptive_pattern.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {
VertexFormat FormatOf(Encoding encoding) {
  if (encoding == Encoding::kRaw) return VertexFormat::kFloat32;
  return encoding == Encoding::kPatches ? VertexFormat::kEdgeBounds : VertexFormat::kQuantised;
}

bool IsDraco(Encoding encoding) {
  return encoding == Encoding::kDracoPoints || encoding == Encoding::kDracoMesh;
}

bool IsCompressed(Encoding encoding) { return IsDraco(encoding) || encoding == Encoding::kMeshopt; }

size_t BytesPerPoint(const ViewSpec& spec) {
  const bool normals = spec.normals != NormalMode::kNone;
  if (spec.format == VertexFormat::kEdgeBounds) return 0;
  if (spec.format == VertexFormat::kFloat32) return (normals ? 6 : 3) * sizeof(float);
  return 3 * sizeof(uint16_t) + (normals ? (spec.normal_bits <= 8 ? 2u : 4u) : 0u);
}

std::vector<uint32_t> EncodeOrder(const ViewTraits& traits, std::span<const uint32_t> chunks) {
  const size_t devices = traits.device_chunks.size();
  std::vector<std::span<const uint32_t>> left(devices);
  auto next = chunks.begin();
  for (size_t d = 0; d < devices; ++d) {
    const auto end = d + 1 < devices
                         ? std::lower_bound(next, chunks.end(), traits.device_chunks[d + 1])
                         : chunks.end();
    left[d] = {next, end};
    next = end;
  }
  const size_t most = std::max<size_t>(traits.encode_batch / devices, 1);
  std::vector<uint32_t> order;
  order.reserve(chunks.size());
  while (order.size() < chunks.size()) {
    for (auto& some : left) {
      const auto batch = some.first(std::min(most, some.size()));
      order.insert(order.end(), batch.begin(), batch.end());
      some = some.subspan(batch.size());
    }
  }
  return order;
}

SharedBytes MakeSharedBytes(std::vector<uint8_t> bytes) {
  auto owner = std::make_shared<const std::vector<uint8_t>>(std::move(bytes));
  return {owner, owner->data(), owner->size()};
}

uint64_t DeviceBytes(const MemoryUse& use) {
  uint64_t bytes = 0;
  for (const auto& [purpose, size] : use) bytes += purpose.starts_with(kDevicePurpose) ? size : 0;
  return bytes;
}

uint64_t HostBytes(const MemoryUse& use) {
  uint64_t bytes = 0;
  for (const auto& [purpose, size] : use) bytes += size;
  return bytes - DeviceBytes(use);
}

absl::Status Validate(const ViewSpec& spec) {
  if (spec.format == VertexFormat::kEdgeBounds) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(error::CheckRange("view.segments", spec.segments, limits::kMinSegments,
                                             limits::kMaxSegments));
  LATTICED_RETURN_IF_ERROR(
      error::CheckRange("view.tolerance", spec.tolerance, 0, std::numeric_limits<double>::max()));
  if (spec.format == VertexFormat::kFloat32) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(error::CheckRange("view.position_bits", spec.position_bits,
                                             limits::kMinPositionBits, limits::kMaxPositionBits));
  if (spec.normals == NormalMode::kNone) return absl::OkStatus();
  return error::CheckRange("view.normal_bits", spec.normal_bits, limits::kMinNormalBits,
                           limits::kMaxNormalBits);
}

absl::Status CheckSupported(const DeformPlan& plan, Pipeline pipeline) {
  if (plan.turned.empty() || pipeline != Pipeline::kFused) return absl::OkStatus();
  return error::NotWithTurned("pipeline fused");
}

size_t ChunkPoints(const DeformPlan& plan, size_t chunk, int segments) {
  const auto [first, last] = plan.ChunkPatches(chunk);
  return (last - first) * static_cast<size_t>(PointsPerPatch(segments));
}

size_t PatternPoints(std::span<const uint16_t> patterns) {
  size_t points = 0;
  for (const uint16_t code : patterns) {
    points += AdaptivePattern::Get(*PatternKey::FromCode(code)).points.size();
  }
  return points;
}

absl::Status CheckSupported(const DeformTarget& target, const ViewSpec& spec) {
  if (spec.format != VertexFormat::kEdgeBounds || target.has_edge_bounds()) return absl::OkStatus();
  return error::NoPatches("view.encoding");
}

size_t ChunkPoints(const DeformView& view, const DeformPlan& plan, uint32_t chunk) {
  const std::span<const uint16_t> patterns = view.Patterns().OfChunk(chunk);
  return patterns.empty() ? ChunkPoints(plan, chunk, view.spec().segments)
                          : PatternPoints(patterns);
}

}  // namespace latticed
