// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/backend.h"

#include <array>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace {

constexpr std::array<std::pair<Pipeline, std::string_view>, 4> kPipelineNames{{
    {Pipeline::kFused, "fused"},
    {Pipeline::kGemm, "gemm"},
    {Pipeline::kGemm12, "gemm12"},
    {Pipeline::kControlNet, "control-net"},
}};

absl::Status CheckRange(std::string_view field, int got, int lowest, int highest) {
  if (got < lowest || got > highest) return error::OutOfRange(field, got, lowest, highest);
  return absl::OkStatus();
}

}  // namespace

std::string_view PipelineName(Pipeline pipeline) {
  for (const auto& [value, name] : kPipelineNames) {
    if (value == pipeline) return name;
  }
  return "unknown";
}

absl::StatusOr<Pipeline> PipelineFromName(std::string_view name) {
  for (const auto& [value, known] : kPipelineNames) {
    if (known == name || (name == "control_net" && value == Pipeline::kControlNet)) return value;
  }
  return error::InvalidField("pipeline", "known are fused, gemm, gemm12 and control-net");
}

VertexFormat FormatOf(Encoding encoding) {
  return encoding == Encoding::kRaw ? VertexFormat::kFloat32 : VertexFormat::kQuantised;
}

bool IsDraco(Encoding encoding) {
  return encoding == Encoding::kDracoPoints || encoding == Encoding::kDracoMesh;
}

size_t BytesPerPoint(const ViewSpec& spec) {
  const bool normals = spec.normals != NormalMode::kNone;
  if (spec.format == VertexFormat::kFloat32) return (normals ? 6 : 3) * sizeof(float);
  return 3 * sizeof(uint16_t) + (normals ? (spec.normal_bits <= 8 ? 2u : 4u) : 0u);
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
  LATTICED_RETURN_IF_ERROR(
      CheckRange("view.segments", spec.segments, limits::kMinSegments, limits::kMaxSegments));
  if (spec.format == VertexFormat::kFloat32) return absl::OkStatus();
  LATTICED_RETURN_IF_ERROR(CheckRange("view.position_bits", spec.position_bits,
                                      limits::kMinPositionBits, limits::kMaxPositionBits));
  if (spec.normals == NormalMode::kNone) return absl::OkStatus();
  return CheckRange("view.normal_bits", spec.normal_bits, limits::kMinNormalBits,
                    limits::kMaxNormalBits);
}

size_t ChunkPoints(const DeformPlan& plan, size_t chunk, int segments) {
  const auto [first, last] = plan.ChunkPatches(chunk);
  return (last - first) * static_cast<size_t>(PointsPerPatch(segments));
}

}  // namespace latticed
