// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/fused/cpu_fused.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/limits.h"
#include "core/cpu/flush_denormals.h"
#include "core/cpu/fused/box_polynomials.h"
#include "core/cpu/fused/fused_layout.h"
#include "core/cpu/fused/fused_output.h"
#include "core/cpu/fused/kernel/fused_kernel.h"
#include "core/cpu/fused/kernel/weight_lanes.h"
#include "core/cpu/fused/prefetch.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace fused {
namespace {

constexpr size_t kGroupsPerTask = 4;
constexpr size_t kMaxPoints = static_cast<size_t>(PointsPerPatch(limits::kMaxSegments));

struct alignas(64) ThreadScratch {
  std::array<float, 6 * kMaxPoints * kLanes> rows;
  std::array<WeakNormal, kMaxPoints * kLanes> weak;
};

// 16 lanes of one value, aligned for vector stores.
struct alignas(64) LaneRow {
  float value[kLanes];
};

// The data of one Evaluate that its tasks share.
struct Frame {
  std::span<const Vec3d> control_points;
  const ViewSpec& spec;
  const FusedOutput output;
  std::vector<bool> attached;
  std::vector<uint32_t> groups;         // to evaluate
  std::vector<uint32_t> polynomial_of;  // box -> index into polynomials
  std::vector<BoxPolynomial> polynomials;
  std::vector<uint32_t> boxes;                       // of polynomials
  std::vector<uint32_t> edge_groups, corner_groups;  // feature groups to evaluate
  std::vector<LaneRow> edge_points, corner_points;   // by feature group
};

class Kernel final : public FusedKernel {
 public:
  explicit Kernel(std::shared_ptr<const FusedPlan> plan)
      : fused_plan_(std::move(plan)),
        plan_(fused_plan_->plan.get()),
        polynomials_(fused_plan_->polynomials),
        layout_(fused_plan_->layout) {}

  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks, const ViewSpec& spec,
                        std::span<uint8_t> vertices, CpuArena& arena,
                        FusedOrder order) const override {
    Frame frame{.control_points = control_points,
                .spec = spec,
                .output = {*plan_, layout_, box, spec, order, vertices}};
    if (!plan_->seams.empty()) frame.attached = AttachedSeams(*plan_, control_points);
    Gather(chunks, frame);
    arena.ForEach(frame.boxes.size(), [&](size_t i) {
      frame.polynomials[i] = polynomials_.Make(frame.boxes[i], control_points);
    });
    EvaluateFeatures(frame, arena);
    EvaluateGroups(frame, arena);
    return absl::OkStatus();
  }

  size_t LaneOrderBytes(const ViewSpec& spec) const override {
    return fused::LaneOrderBytes(layout_, spec);
  }

  void ReadLaneOrder(std::span<const uint8_t> vertices, const ViewSpec& spec, uint32_t chunk,
                     std::span<uint8_t> out) const override {
    fused::ReadLaneOrder(*plan_, layout_, spec, vertices, chunk, out);
  }

 private:
  // Finds the groups that hold patches of the chunks, the features that they borrow, and the boxes of both.
  void Gather(std::span<const uint32_t> chunks, Frame& frame) const {
    for (const uint32_t chunk : chunks) {
      const auto [first, last] = plan_->ChunkPatches(chunk);
      for (uint32_t g = layout_.group_of_patch[first]; g <= layout_.group_of_patch[last - 1]; ++g) {
        if (frame.groups.empty() || frame.groups.back() < g) frame.groups.push_back(g);
      }
    }
    frame.polynomial_of.assign(plan_->boxes.size(), kNoIndex);
    const auto need_box = [&](uint32_t box) {
      if (frame.polynomial_of[box] != kNoIndex) return;
      frame.polynomial_of[box] = static_cast<uint32_t>(frame.boxes.size());
      frame.boxes.push_back(box);
    };
    std::vector<bool> edge_needed(layout_.edges.groups.size());
    std::vector<bool> corner_needed(layout_.corners.groups.size());
    for (const uint32_t g : frame.groups) {
      const Group& group = layout_.groups[g];
      need_box(group.box);
      for (uint32_t f = group.first_fix; f < group.last_fix; ++f) {
        const Fix& fix = layout_.fixes[f];
        const uint32_t feature = FeatureOf(fix, frame);
        if (feature == kNoIndex) continue;
        const uint32_t feature_group = feature / static_cast<uint32_t>(kLanes);
        auto& needed = fix.is_edge ? edge_needed : corner_needed;
        if (needed[feature_group]) continue;
        needed[feature_group] = true;
        const auto& set_boxes = fix.is_edge ? layout_.edges.boxes : layout_.corners.boxes;
        need_box(set_boxes[feature_group]);
        (fix.is_edge ? frame.edge_groups : frame.corner_groups).push_back(feature_group);
      }
    }
    frame.polynomials.resize(frame.boxes.size());
  }

  static uint32_t FeatureOf(const Fix& fix, const Frame& frame) {
    const bool attached = fix.seam != kNoIndex && frame.attached[fix.seam];
    return attached ? fix.attached : fix.detached;
  }

  size_t EdgeStride(const ViewSpec& spec) const {
    return static_cast<size_t>(spec.segments - 1) * 3;
  }

  void EvaluateFeatures(Frame& frame, CpuArena& arena) const {
    const std::array<int, 3> degree = polynomials_.degree();
    const size_t stride = EdgeStride(frame.spec);
    frame.edge_points.resize(layout_.edges.groups.size() * stride);
    frame.corner_points.resize(layout_.corners.groups.size() * 3);
    const auto polynomial = [&](uint32_t box) -> const BoxPolynomial& {
      return frame.polynomials[frame.polynomial_of[box]];
    };
    // Features are evaluated in the same form as groups: an edge must have the same bits whichever code evaluates it.
    arena.ForEach(frame.edge_groups.size(), [&](size_t i) {
      const FlushDenormals flush;
      const size_t g = frame.edge_groups[i];
      if (stride == 0) return;  // one segment: edges have no interior points
      const BoxPolynomial& box = polynomial(layout_.edges.boxes[g]);
      const EdgeLanes& edges = layout_.edges.groups[g];
      float* out = frame.edge_points[g * stride].value;
      if (plan_->is_weighted()) {
        EvaluateWeightedEdges(degree, box, edges, layout_.weights.edges[g], frame.spec.segments,
                              out);
      } else {
        EvaluateEdges(degree, box, edges, frame.spec.segments, out);
      }
    });
    arena.ForEach(frame.corner_groups.size(), [&](size_t i) {
      const FlushDenormals flush;
      const size_t g = frame.corner_groups[i];
      const BoxPolynomial& box = polynomial(layout_.corners.boxes[g]);
      const CornerLanes& corners = layout_.corners.groups[g];
      float* out = frame.corner_points[g * 3].value;
      if (plan_->is_weighted()) {
        EvaluateWeightedCorners(degree, box, corners, layout_.weights.corners[g], out);
      } else {
        EvaluateCorners(degree, box, corners, out);
      }
    });
  }

  void EvaluateGroups(const Frame& frame, CpuArena& arena) const {
    arena.ForRanges(frame.groups.size(), kGroupsPerTask, [&](size_t begin, size_t end) {
      const FlushDenormals flush;
      for (size_t i = begin; i < end; ++i) EvaluateOneGroup(frame, frame.groups[i]);
    });
  }

  void EvaluateOneGroup(const Frame& frame, uint32_t g) const {
    static thread_local ThreadScratch scratch;
    const Group& group = layout_.groups[g];
    const bool smooth = frame.spec.normals == NormalMode::kSmooth;
    GroupArguments arguments{
        .degree = polynomials_.degree(),
        .segments = frame.spec.segments,
        .box = &frame.polynomials[frame.polynomial_of[group.box]],
        .patches = &layout_.patches[g],
        .smooth = smooth ? &layout_.smooth[g] : nullptr,
        .normals = frame.spec.normals != NormalMode::kNone,
        .scratch = {scratch.rows.data(), static_cast<size_t>(PointsPerPatch(frame.spec.segments))},
        .weak = scratch.weak.data(),
        .weak_count = 0};
    // Prefetches what the next group reads and what this one writes, while this one is evaluated.
    // Without it, a quarter of the time is spent waiting for memory.
    if (g + 1 < layout_.groups.size()) {
      PrefetchToRead(&layout_.patches[g + 1], sizeof(PatchLanes));
      if (plan_->is_weighted()) {
        const bool few = frame.spec.segments <= kMostDirectSegments;
        PrefetchToRead(&layout_.weights.patches[g + 1],
                       few ? sizeof(PatchWeights) : sizeof(WeightedPatch));
      }
    }
    frame.output.Prefetch(group);
    if (plan_->is_weighted()) {
      EvaluateWeightedGroup(arguments, layout_.weights.patches[g]);
    } else {
      EvaluateGroup(arguments);
    }
    ApplyFixes(frame, group, arguments.scratch);
    ReplaceWeakNormals(frame, group, arguments);
    frame.output.Store(g, arguments.scratch);
  }

  void ApplyFixes(const Frame& frame, const Group& group, const GroupScratch& scratch) const {
    const TessellationPattern& pattern = TessellationPattern::Get(frame.spec.segments);
    const auto segments = static_cast<size_t>(frame.spec.segments);
    for (uint32_t f = group.first_fix; f < group.last_fix; ++f) {
      const Fix& fix = layout_.fixes[f];
      const uint32_t feature = FeatureOf(fix, frame);
      if (feature == kNoIndex) continue;
      const size_t feature_group = feature / kLanes, from_lane = feature % kLanes;
      const auto& points = pattern.edge_points[fix.slot];
      if (!fix.is_edge) {
        const LaneRow* from = &frame.corner_points[feature_group * 3];
        for (size_t c = 0; c < 3; ++c) {
          scratch.Row(c, points[0])[fix.lane] = from[c].value[from_lane];
        }
        continue;
      }
      const LaneRow* from = frame.edge_points.data() + feature_group * EdgeStride(frame.spec);
      for (size_t k = 1; k < segments; ++k, from += 3) {
        const size_t point = points[fix.reversed ? segments - k : k];
        for (size_t c = 0; c < 3; ++c) scratch.Row(c, point)[fix.lane] = from[c].value[from_lane];
      }
    }
  }

  void ReplaceWeakNormals(const Frame& frame, const Group& group,
                          const GroupArguments& arguments) const {
    if (arguments.weak_count == 0) return;
    const TessellationPattern& pattern = TessellationPattern::Get(frame.spec.segments);
    const DirectFfd definition(*plan_, frame.control_points);
    const auto kind = arguments.smooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
    for (size_t i = 0; i < arguments.weak_count; ++i) {
      const auto [point, lane] = arguments.weak[i];
      if (lane >= group.lanes) continue;
      std::array<double, 3> barycentrics;
      for (size_t c = 0; c < 3; ++c) {
        barycentrics[c] = static_cast<double>(pattern.points[point][c]) / frame.spec.segments;
      }
      const Vec3f n =
          ToFloat(definition.Evaluate(group.first_patch + lane, barycentrics, kind).normal);
      arguments.scratch.Row(3, point)[lane] = n.x;
      arguments.scratch.Row(4, point)[lane] = n.y;
      arguments.scratch.Row(5, point)[lane] = n.z;
    }
  }

  const std::shared_ptr<const FusedPlan> fused_plan_;
  const DeformPlan* const plan_;
  const BoxPolynomials& polynomials_;
  const FusedLayout& layout_;
};

}  // namespace
}  // namespace fused

std::unique_ptr<FusedKernel> FusedKernel::Create(std::shared_ptr<const fused::FusedPlan> plan) {
  return std::make_unique<fused::Kernel>(std::move(plan));
}

std::string FusedTargetName() {
  const std::string_view target = fused::TargetName();
  return target == "AVX3" ? "AVX-512" : std::string(target);
}

}  // namespace latticed
