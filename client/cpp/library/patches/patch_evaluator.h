// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates a patch plan: from control points, edge bounds and a tolerance to points and triangles, as patches.proto
// defines it.
//
//   watch.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
//   auto stream = client->Deform(watch);
//   const Surface& held = (*stream)->surface();
//   auto plan = client->GetPatchPlan(scene, held.topology().topology_id(), held.view().normals());
//   auto lattice = EffectiveLattice(held.update_lattice());                      // lattice_from_proto.h
//   auto evaluator = PatchEvaluator::Create(*plan, lattice->structure);
//   …                                                                            // after each update:
//   lattice = EffectiveLattice(held.update_lattice());
//   evaluator->Evaluate(lattice->control_points, *held.EdgeBounds(), tolerance, &surface);
//
// Points that patches share have the same bits in all of them. On each axis, positions are within half a unit of a grid
// of 16 bits, and 1e-6 of the diagonal, unless knot boxes are larger than the surface: patches.proto. Triangles add
// `error` to that. Weights of vertices have 16 bits, too.
//
// Errors   kInvalidArgument where plan, lattice and arguments do not fit; kResourceExhausted past 2^32 points
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PATCHES_PATCH_EVALUATOR_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PATCHES_PATCH_EVALUATOR_H_

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cpp/library/patches/box_polynomials.h"
#include "client/cpp/library/patches/point_batch.h"
#include "core/adaptive/adaptive_pattern.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/ffd/outside/outside_map.h"
#include "core/patches/patch_plan.h"

namespace latticed::client {

struct PatchSurface {
  std::vector<Vec3f> positions;  // world units, relative to PatchPlanHeader.origin
  std::vector<Vec3f> normals;    // unit; empty without rest normals. 0 where the rest normal is 0
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> first_points;  // by patch, and the number of points at the end
  std::vector<uint16_t> patterns;      // by patch: PatchPattern.code
  // The largest distance between triangles and exact surface besides the error of points. Above the tolerance where an
  // edge would need a level above 5; infinite where nothing is known of one.
  double error = 0;
};

class PatchEvaluator {
 public:
  [[nodiscard]] static absl::StatusOr<PatchEvaluator> Create(std::shared_ptr<const PatchPlan> plan,
                                                             const LatticeStructure& structure);

  // edge_bounds: a byte for each edge of the plan. tolerance: world units, above 0. The memory of *surface is used again.
  [[nodiscard]] absl::Status Evaluate(std::span<const Vec3d> control_points,
                                      std::span<const uint8_t> edge_bounds, double tolerance,
                                      PatchSurface* surface);

  // The most by which a point with these control points differs from the exact one. World units. Its triangles are
  // within this and PatchSurface.error of the exact surface, both ways.
  [[nodiscard]] absl::StatusOr<double> PositionError(std::span<const Vec3d> control_points);

  const PatchPlan& plan() const { return *plan_; }

 private:
  PatchEvaluator(std::shared_ptr<const PatchPlan> plan, const LatticeStructure& structure);
  absl::Status FindBoxes();
  absl::Status CheckSeams(const LatticeStructure& structure) const;
  // The control points of the lattice that the plan is of.
  absl::StatusOr<std::vector<Vec3d>> Continued(std::span<const Vec3d> control_points) const;
  void FindAttached(std::span<const Vec3d> control_points);
  absl::Status ChoosePatterns(std::span<const uint8_t> edge_bounds, double tolerance,
                              PatchSurface* surface) const;
  bool IsAttached(const std::vector<uint32_t>& seams, uint32_t index) const {
    return !seams.empty() && seams[index] != PatchPlan::kNoSeam && attached_[seams[index]];
  }
  void EvaluatePatch(size_t patch, const AdaptivePattern& pattern, PointBatch* batch) const;

  std::shared_ptr<const PatchPlan> plan_;
  OutsideMap outside_;
  std::array<int, 3> size_;
  BoxPolynomials polynomials_;
  std::vector<uint32_t> patch_boxes_;  // by patch; 0 is the outside box
  std::vector<uint32_t> used_boxes_;   // knot boxes that points lie in, ascending
  std::vector<bool> attached_;         // by seam
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PATCHES_PATCH_EVALUATOR_H_
