// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/adaptive/surface/feature_points.h"

#include <algorithm>

#include "core/cpu/flush_denormals.h"

namespace latticed::fused {
namespace {

void CopyCorner(const CornerLanes& from, size_t corner, RunPatches& to) {
  for (size_t axis = 0; axis < 3; ++axis) {
    std::ranges::copy(from.point[axis], to.corners[axis][corner].begin());
  }
}

void CopyWeights(const Lanes& from, size_t corner, RunWeights& to) {
  std::ranges::copy(from, to.weight[corner].begin());
}

}  // namespace

FeaturePoints::FeaturePoints(const FusedPlan& plan, std::span<const Vec3d> control_points,
                             FrameBoxes& boxes)
    : plan_(plan),
      boxes_(boxes),
      edges_(plan.layout.edges.groups.size() * kLanes),
      corners_(plan.layout.corners.groups.size() * kLanes),
      edge_groups_(plan.layout.edges.groups.size()),
      corner_groups_(plan.layout.corners.groups.size()) {
  if (!plan.plan->seams.empty()) attached_ = AttachedSeams(*plan.plan, control_points);
}

uint32_t FeaturePoints::FeatureOf(const Fix& fix) const {
  const bool is_attached = fix.seam != kNoIndex && attached_[fix.seam];
  return is_attached ? fix.attached : fix.detached;
}

void FeaturePoints::Need(const Fix& fix, int level) {
  const uint32_t feature = FeatureOf(fix);
  if (feature == kNoIndex) return;
  const uint32_t count = fix.is_edge ? (1u << level) - 1 : 1;
  if (count == 0) return;
  Place& place = fix.is_edge ? edges_[feature] : corners_[feature];
  if (place.first != kNoIndex) return;
  place = {static_cast<uint32_t>(points_.size()), count};
  points_.resize(points_.size() + count);
  const auto group = static_cast<uint32_t>(feature / kLanes);
  auto& known = fix.is_edge ? edge_groups_ : corner_groups_;
  if (known[group]) return;
  known[group] = true;
  work_.push_back({group, fix.is_edge});
  boxes_.Need(fix.is_edge ? plan_.layout.edges.boxes[group] : plan_.layout.corners.boxes[group]);
}

void FeaturePoints::MakeNeeded(CpuArena& arena) {
  arena.ForRanges(work_.size(), 1, [&](size_t begin, size_t end) {
    const FlushDenormals flush;
    static thread_local RunBuffer run;
    for (size_t i = begin; i < end; ++i) Evaluate(work_[i], run);
  });
}

void FeaturePoints::Evaluate(const Work& work, RunBuffer& run) {
  const FusedLayout& layout = plan_.layout;
  const std::vector<Place>& places = work.is_edge ? edges_ : corners_;
  run.Clear();
  if (work.is_edge) {
    CopyCorner(layout.edges.groups[work.group].from, 0, run.patches);
    CopyCorner(layout.edges.groups[work.group].to, 1, run.patches);
  } else {
    CopyCorner(layout.corners.groups[work.group], 0, run.patches);
  }
  const bool weighted = plan_.plan->is_weighted();
  if (weighted && work.is_edge) {
    CopyWeights(layout.weights.edges[work.group].from, 0, run.weights);
    CopyWeights(layout.weights.edges[work.group].to, 1, run.weights);
  } else if (weighted) {
    CopyWeights(layout.weights.corners[work.group].weight, 0, run.weights);
  }
  for (size_t lane = 0; lane < kLanes; ++lane) {
    const Place& place = places[work.group * kLanes + lane];
    for (uint32_t k = 0; k < place.count; ++k) {
      if (!work.is_edge) {
        run.Add(lane, PlaceCode(0, 0, 0), 0, 0);
        continue;
      }
      const auto segments = static_cast<float>(place.count + 1);
      run.Add(lane, PlaceCode(0, 1, 0), static_cast<float>(k + 1) / segments - 0.5f, 0);
    }
  }
  const uint32_t box =
      work.is_edge ? layout.edges.boxes[work.group] : layout.corners.boxes[work.group];
  run.Evaluate(plan_.polynomials.degree(), boxes_[box], NormalMode::kNone, weighted);
  size_t from = 0;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    const Place& place = places[work.group * kLanes + lane];
    for (uint32_t k = 0; k < place.count; ++k, ++from) {
      points_[place.first + k] = {run.Row(0)[from], run.Row(1)[from], run.Row(2)[from]};
    }
  }
}

std::span<const Vec3f> FeaturePoints::At(const Fix& fix) const {
  const uint32_t feature = FeatureOf(fix);
  if (feature == kNoIndex) return {};
  const Place& place = fix.is_edge ? edges_[feature] : corners_[feature];
  if (place.count == 0) return {};
  return std::span(points_).subspan(place.first, place.count);
}

}  // namespace latticed::fused
