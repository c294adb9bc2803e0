// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the edits of an EditHistory keep.
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/ffd/control_point_range.h"
#include "core/ffd/history/edit_history.h"

namespace latticed {

absl::Status EditHistory::KeepVolume(const EditBatch& batch, const Rules& rules,
                                     EditTarget& target) const {
  const auto& kept = batch.keep_volume.has_value() ? batch.keep_volume : constraints().volume;
  if (!kept.has_value() || rules.keeper == nullptr) return absl::OkStatus();
  if (batch.keep_volume.has_value()) LATTICED_RETURN_IF_ERROR(Check(*kept, "keep_volume"));
  auto& points = target.lattice.control_points;
  const std::vector<Vec3d> before = points;
  LATTICED_RETURN_IF_ERROR(
      rules.keeper->Keep(*kept, rules.freedom, target.written, target.strength, points));
  for (size_t i = 0; i < points.size(); ++i) {
    if (SameBits(before[i], points[i])) continue;
    LATTICED_RETURN_IF_ERROR(CheckControlPoint(points[i], "keep_volume"));
    target.written[i] = true;
  }
  return absl::OkStatus();
}

absl::Status EditHistory::Constrain(const std::string& editor_id, const Constraints& constraints,
                                    const Rules& rules) {
  LATTICED_RETURN_IF_ERROR(
      Check(constraints, lattice().structure, "edits[0].set_constraints.constraints"));
  if (constraints.volume.has_value() && rules.keeper != nullptr) {
    LATTICED_RETURN_IF_ERROR(rules.keeper->CheckEncloses(lattice().control_points, strength()));
  }
  ForgetUndone(editor_id);
  EditStep step = NewStep(editor_id);
  step.constraints = constraints;
  Push(std::move(step));
  return absl::OkStatus();
}

const PointFreedom* EditHistory::Freedom() {
  if (constraints().points_are_free()) {
    freedom_.reset();
  } else if (freedom_ == nullptr || freedom_->structure_id != structure_id_ ||
             freedom_->constraints != constraints()) {
    freedom_ = std::make_shared<const KnownFreedom>(KnownFreedom{
        structure_id_, constraints(), PointFreedom(constraints(), lattice().structure)});
  }
  return freedom_ == nullptr ? nullptr : &freedom_->freedom;
}

Constraints EditHistory::ConstraintsIn(const LatticeStructure& replaced) const {
  if (absent()) return {};  // another lattice begins
  return AfterReplacement(constraints(), lattice().structure, replaced);
}

absl::Status EditHistory::KeepIn(Lattice& replaced, const EditBatch& batch,
                                 const VolumeKeeper* keeper) const {
  const Constraints kept = ConstraintsIn(replaced.structure);
  std::optional<PointFreedom> freedom;
  if (!kept.points_are_free()) freedom.emplace(kept, replaced.structure);
  const LatticeStructure& present = lattice().structure;
  // Where control points stay, as when the shape is kept, a mirror moves nothing by itself.
  if (freedom.has_value() && HaveSameNet(present, replaced.structure) &&
      present.frame == replaced.structure.frame &&
      replaced.control_points != lattice().control_points) {
    EditTarget target({replaced.structure, lattice().control_points});
    target.freedom = &*freedom;
    LATTICED_RETURN_IF_ERROR(ApplyEdit(
        ReplaceControlPoints{std::move(replaced.control_points)}, [] { return Lattice{}; },
        "edits[0]", target));
    replaced.control_points = std::move(target.lattice.control_points);
  }
  const auto& volume = batch.keep_volume.has_value() ? batch.keep_volume : kept.volume;
  if (!volume.has_value() || keeper == nullptr) return absl::OkStatus();
  if (batch.keep_volume.has_value()) LATTICED_RETURN_IF_ERROR(Check(*volume, "keep_volume"));
  auto& points = replaced.control_points;
  LATTICED_RETURN_IF_ERROR(keeper->Keep(*volume, freedom.has_value() ? &*freedom : nullptr,
                                        std::vector<bool>(points.size()), absent() ? 1 : strength(),
                                        points));
  for (const Vec3d point : points) {
    LATTICED_RETURN_IF_ERROR(CheckControlPoint(point, "keep_volume"));
  }
  return absl::OkStatus();
}

}  // namespace latticed
