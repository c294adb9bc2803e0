// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/fused/fused_output.h"

#include <algorithm>
#include <cstring>

#include "core/base/limits.h"
#include "core/cpu/fused/prefetch.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed::fused {
namespace {

size_t Components(const ViewSpec& spec) { return spec.normals == NormalMode::kNone ? 3 : 6; }

size_t PatchFloats(const ViewSpec& spec) {
  return static_cast<size_t>(PointsPerPatch(spec.segments)) * Components(spec);
}

}  // namespace

FusedOutput::FusedOutput(const DeformPlan& plan, const FusedLayout& layout,
                         const QuantisationBox& box, const ViewSpec& spec, FusedOrder order,
                         std::span<uint8_t> vertices)
    : plan_(plan), layout_(layout), spec_(spec), order_(order), vertices_(vertices) {
  const double step = box.step(spec.position_bits);
  const Vec3f offset = ToFloat((plan.local_origin - box.origin) / step);
  scale_.fill(static_cast<float>(1 / step));
  offset_ = {offset.x, offset.y, offset.z};
}

// Calls f(lane, lanes, planes) for each run of the group's patches that lies in one chunk.
template <class F>
void FusedOutput::ForRuns(const Group& group, const F& f) const {
  for (size_t lane = 0; lane < group.lanes;) {
    const size_t patch = group.first_patch + lane;
    const size_t of_chunk = limits::kPatchesPerChunk - patch % limits::kPatchesPerChunk;
    const size_t lanes = std::min(group.lanes - lane, of_chunk);
    f(lane, lanes, PatchPlanes(patch));
    lane += lanes;
  }
}

void FusedOutput::Prefetch(const Group& group) const {
  if (spec_.format != VertexFormat::kQuantised) return;  // lane order uses streaming stores
  ForRuns(group, [](size_t, size_t lanes, const std::array<Plane, 5>& planes) {
    for (const Plane& plane : planes) PrefetchToWrite(plane.bytes, lanes * plane.stride);
  });
}

void FusedOutput::Store(uint32_t group, const GroupScratch& scratch) const {
  if (spec_.format == VertexFormat::kQuantised) {
    StoreInPlanes(layout_.groups[group], scratch);
  } else if (order_ == FusedOrder::kLanes) {
    auto* floats = reinterpret_cast<float*>(vertices_.data());
    StoreLaneOrder(scratch, Components(spec_), floats + group * PatchFloats(spec_) * kLanes);
  } else {
    StoreByPoint(layout_.groups[group], scratch);
  }
}

void FusedOutput::StoreByPoint(const Group& group, const GroupScratch& scratch) const {
  auto* floats = reinterpret_cast<float*>(vertices_.data());
  std::array<float*, kLanes> destination{};
  for (size_t l = 0; l < group.lanes; ++l) {
    destination[l] = floats + (group.first_patch + l) * PatchFloats(spec_);
  }
  StoreFloats(scratch, Components(spec_), group.lanes, destination);
}

void FusedOutput::StoreInPlanes(const Group& group, const GroupScratch& scratch) const {
  const bool normals = spec_.normals != NormalMode::kNone;
  QuantiseArguments q{.scratch = scratch,
                      .scale = scale_,
                      .offset = offset_,
                      .position_bits = spec_.position_bits,
                      .normal_bits = normals ? spec_.normal_bits : 0,
                      .lanes = group.lanes};
  ForRuns(group, [&](size_t lane, size_t lanes, const std::array<Plane, 5>& planes) {
    for (size_t l = 0; l < lanes; ++l) {
      for (size_t plane = 0; plane < 5; ++plane) {
        q.destination[lane + l][plane] = planes[plane].bytes + l * planes[plane].stride;
      }
    }
  });
  StoreQuantised(q);
}

// Where a patch's x, y, z, s and t go in the planes of its chunk. Without normals, s and t take no bytes.
std::array<FusedOutput::Plane, 5> FusedOutput::PatchPlanes(size_t patch) const {
  const auto points = static_cast<size_t>(PointsPerPatch(spec_.segments));
  const auto [first, last] = plan_.ChunkPatches(patch / limits::kPatchesPerChunk);
  const size_t chunk_points = (last - first) * points, before = (patch - first) * points;
  const size_t normal_bytes = spec_.normals == NormalMode::kNone ? 0
                              : spec_.normal_bits <= 8           ? 1
                                                                 : 2;
  uint8_t* positions = vertices_.data() + first * points * BytesPerPoint(spec_);
  uint8_t* normals = positions + 6 * chunk_points;
  std::array<Plane, 5> planes;
  for (size_t c = 0; c < 3; ++c) {
    planes[c] = {positions + (c * chunk_points + before) * 2, points * 2};
  }
  for (size_t c = 0; c < 2; ++c) {
    planes[3 + c] = {normals + (c * chunk_points + before) * normal_bytes, points * normal_bytes};
  }
  return planes;
}

size_t LaneOrderBytes(const FusedLayout& layout, const ViewSpec& spec) {
  return layout.groups.size() * PatchFloats(spec) * kLanes * sizeof(float);
}

void ReadLaneOrder(const DeformPlan& plan, const FusedLayout& layout, const ViewSpec& spec,
                   std::span<const uint8_t> vertices, uint32_t chunk, std::span<uint8_t> out) {
  const size_t values = PatchFloats(spec);
  const auto [first, last] = plan.ChunkPatches(chunk);
  for (size_t p = first; p < last; ++p) {
    const uint32_t g = layout.group_of_patch[p];
    const size_t lane = p - layout.groups[g].first_patch;
    const uint8_t* from = vertices.data() + (g * values * kLanes + lane) * sizeof(float);
    uint8_t* to = out.data() + (p - first) * values * sizeof(float);
    for (size_t v = 0; v < values; ++v) {
      std::memcpy(to + v * sizeof(float), from + v * kLanes * sizeof(float), sizeof(float));
    }
  }
}

}  // namespace latticed::fused
