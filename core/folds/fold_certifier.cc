// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/fold_certifier.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/bounds.h"
#include "core/base/status_macros.h"
#include "core/ffd/plan/dirty_set.h"
#include "core/folds/fold_search.h"
#include "core/folds/triangle_search.h"
#include "core/folds/turned_determinant.h"
#include "core/folds/turned_volume.h"
#include "core/folds/weighted_determinant.h"

namespace latticed {
namespace {

// The parameters of the patches in a box.
Bounds PatchBounds(const DeformPlan& plan, uint32_t box) {
  Bounds bounds;
  for (uint32_t p = plan.box_patches[box]; p < plan.box_patches[box + 1]; ++p) {
    for (const uint32_t vertex : plan.patches[p].vertex) {
      bounds.Extend(plan.vertices[vertex].parameter);
    }
  }
  return bounds;
}

// Whether a turned lattice reaches a part of the scope outside the frame of the plan's own one.
bool OutsideMoves(const DeformPlan& plan, FoldScope scope) {
  if (plan.turned.empty()) return false;
  if (scope == FoldScope::kVolume) return TurnedVolume::ReachesOutside(plan);
  for (size_t p = plan.box_patches[plan.outside_box()]; p < plan.patches.size(); ++p) {
    if (TurnedPatches::IsReached(plan, p)) return true;
  }
  return false;
}

}  // namespace

FoldCertifier::FoldCertifier(std::shared_ptr<const DeformPlan> plan, FoldScope scope)
    : plan_(std::move(plan)), scope_(scope), map_(plan_->structure) {
  std::array<int, 3> place{};
  for (uint32_t box = 0; box < plan_->outside_box(); ++box) {
    const KnotBox& knots = plan_->boxes[box];
    // Boxes follow each other u fastest: an axis starts again where its parameter does.
    if (box > 0) {
      const KnotBox& last = plan_->boxes[box - 1];
      place[0] = knots.lower.x > last.lower.x ? place[0] + 1 : 0;
      if (knots.lower.y != last.lower.y) place[1] = knots.lower.y > last.lower.y ? place[1] + 1 : 0;
      if (knots.lower.z != last.lower.z) ++place[2];
    }
    Bounds bounds{.min = knots.lower, .max = knots.upper};
    if (scope == FoldScope::kSurface) bounds = PatchBounds(*plan_, box);
    if (!bounds.empty()) parts_.push_back({box, place, {knots.span, bounds.min, bounds.max}});
  }
  if (OutsideMoves(*plan_, scope)) parts_.push_back({plan_->outside_box(), kOutsidePlace, {}});
  parts_.shrink_to_fit();
}

size_t FoldCertifier::MostBytes(const DeformPlan& plan) {
  const size_t bytes =
      sizeof(FoldCertifier) + plan.boxes.size() * (sizeof(Part) + sizeof(FoldedBox));
  if (plan.turned.empty()) return bytes;
  return bytes + std::max(TurnedPatches::MostBytes(plan), TurnedVolume::MostBytes(plan));
}

struct FoldCertifier::Looker {
  Looker(const DeformPlan& plan, FoldScope scope, std::span<const Vec3d> points)
      : control_points(points) {
    const bool is_turned = !plan.turned.empty();
    if (is_turned && scope == FoldScope::kVolume) volume.emplace(plan, points);
    if (plan.is_weighted()) {
      for (size_t i = 0; i < points.size(); ++i) {
        offsets.push_back(points[i] - plan.identity_points[i]);
      }
    }
    if (plan.is_weighted() || is_turned) triangles.emplace();
    if (is_turned && scope == FoldScope::kSurface) turned.emplace(plan, points, offsets);
  }

  const std::span<const Vec3d> control_points;
  FoldSearch search;
  // With weights or turned lattices.
  std::optional<TriangleSearch> triangles;
  std::vector<Vec3d> offsets;  // of control points from their places at rest, with weights
  // With turned lattices, by scope.
  std::optional<TurnedPatches> turned;
  std::optional<TurnedVolume> volume;
};

// `patches`: a WeightedBox of the part, or TurnedPatches.
template <typename Patches>
void FoldCertifier::ExaminePatches(const Part& part, Patches& patches, TriangleSearch& search,
                                   FoldReport& report) const {
  FoldedBox worst{part.box, part.place, FoldState::kCertified};
  for (uint32_t p = plan_->box_patches[part.box]; p < plan_->box_patches[part.box + 1]; ++p) {
    if (patches.IsNearRest(p)) continue;
    const double slack = patches.MakeDeterminant(p, search.polynomial());
    const TriangleDecision decision = search.Decide(slack);
    if (decision.state <= worst.state) continue;
    Vec3d rest_point;
    for (size_t c = 0; c < 3; ++c) {
      rest_point += decision.barycentrics[c] * plan_->vertices[plan_->patches[p].vertex[c]].world;
    }
    worst = {part.box, part.place, decision.state, rest_point, decision.value};
    if (worst.state == FoldState::kFolded) break;
  }
  if (worst.state != FoldState::kCertified) report.places.push_back(worst);
}

absl::Status FoldCertifier::Examine(const Part& part, Looker& looker, StopCheck stop,
                                    FoldReport& report) const {
  const bool is_outside = part.box == plan_->outside_box();
  if (!looker.volume.has_value() || !(is_outside || looker.volume->IsReached(part.box))) {
    ExamineBox(part, looker, report);
    return absl::OkStatus();
  }
  VolumeDecision decision;
  if (is_outside) {
    LATTICED_ASSIGN_OR_RETURN(decision, looker.volume->DecideOutside(stop));
  } else {
    decision = looker.volume->DecideBox(part.box);
  }
  if (decision.state != FoldState::kCertified) {
    report.places.push_back(
        {part.box, part.place, decision.state, decision.rest_point, decision.determinant});
  }
  return absl::OkStatus();
}

void FoldCertifier::ExamineBox(const Part& part, Looker& looker, FoldReport& report) const {
  if (looker.turned.has_value()) {
    return ExaminePatches(part, *looker.turned, *looker.triangles, report);
  }
  if (plan_->is_weighted()) {
    WeightedBox box(*plan_, part.box, looker.control_points, looker.offsets);
    return ExaminePatches(part, box, *looker.triangles, report);
  }
  const double slack = MakeBoxDeterminant(plan_->structure, looker.control_points, part.part,
                                          looker.search.polynomial());
  const FoldDecision decision = looker.search.Decide(slack);
  if (decision.state == FoldState::kCertified) return;
  Vec3d parameter = part.part.lower;
  for (int a = 0; a < 3; ++a) {
    parameter[a] += decision.place[a] * (part.part.upper[a] - part.part.lower[a]);
  }
  report.places.push_back(
      {part.box, part.place, decision.state, map_.ToWorld(parameter), decision.value});
}

absl::StatusOr<FoldReport> FoldCertifier::Certify(std::span<const Vec3d> control_points,
                                                  StopCheck stop) const {
  FoldReport report{.boxes = parts_.size()};
  Looker looker(*plan_, scope_, control_points);
  for (const Part& part : parts_) {
    LATTICED_RETURN_IF_ERROR(stop());
    LATTICED_RETURN_IF_ERROR(Examine(part, looker, stop, report));
  }
  return report;
}

FoldReport FoldCertifier::Recertify(const FoldReport& before, std::span<const uint32_t> changed,
                                    std::span<const Vec3d> control_points) const {
  FoldReport report{.boxes = before.boxes};
  const std::vector<bool> influenced = scope_ == FoldScope::kVolume && !plan_->turned.empty()
                                           ? TurnedVolume::InfluencedBoxes(*plan_, changed)
                                           : InfluencedBoxes(*plan_, changed);
  Looker looker(*plan_, scope_, control_points);
  auto old = before.places.begin();
  for (const Part& part : parts_) {
    const bool listed = old != before.places.end() && old->box == part.box;
    if (influenced[part.box]) {
      Examine(part, looker, NeverStop, report).IgnoreError();  // nothing stops it
    } else if (listed) {
      report.places.push_back(*old);
    }
    if (listed) ++old;
  }
  return report;
}

}  // namespace latticed
