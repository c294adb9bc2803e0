// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/session/scene_patches.h"

#include "client/cpp/library/patches/lattice_from_proto.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {

absl::Status ScenePatches::Prepare(const Surface& surface, const LatticeStructure& structure) {
  const std::string& topology_id = surface.topology().topology_id();
  if (topology_id == topology_id_ && surface.view().normals() == normals_) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(auto plan,
                            client_.GetPatchPlan(scene_, topology_id, surface.view().normals()));
  LATTICED_ASSIGN_OR_RETURN(evaluator_, PatchEvaluator::Create(std::move(plan), structure));
  topology_id_ = topology_id;
  normals_ = surface.view().normals();
  return absl::OkStatus();
}

absl::Status ScenePatches::Evaluate(const Surface& surface) {
  LATTICED_ASSIGN_OR_RETURN(const Lattice lattice, EffectiveLattice(surface.update_lattice()));
  LATTICED_RETURN_IF_ERROR(Prepare(surface, lattice.structure));
  LATTICED_ASSIGN_OR_RETURN(const auto bounds, surface.EdgeBounds());
  LATTICED_ASSIGN_OR_RETURN(const double rounding,
                            evaluator_->PositionError(lattice.control_points));
  if (!(rounding < tolerance_)) {
    return error::InvalidField(
        "view.tolerance",
        fmt::format("got {:.3g}, points of patches allow more than {:.3g}", tolerance_, rounding),
        "OUT_OF_RANGE");
  }
  LATTICED_RETURN_IF_ERROR(
      evaluator_->Evaluate(lattice.control_points, bounds, tolerance_ - rounding, &points_));
  certified_error_ = points_.error + rounding;
  return absl::OkStatus();
}

DecodedPoints ScenePatches::TakePoints() {
  DecodedPoints points;
  const Vec3d origin = evaluator_->plan().header.origin;
  points.positions.reserve(points_.positions.size());
  for (const Vec3f position : points_.positions) {
    points.positions.push_back(origin + ToDouble(position));
  }
  points.normals = std::move(points_.normals);
  return points;
}

absl::Status CheckToleranceOfPatches(const v1::ViewOptions& view, bool has_tolerance) {
  if (view.encoding() != v1::ENCODING_PATCHES || has_tolerance) return absl::OkStatus();
  return error::InvalidField("view.tolerance",
                             "is needed with --encoding patches: it decides on the points");
}

}  // namespace latticed::client
