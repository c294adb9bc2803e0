// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What an export reads: a scene's state and its target.
#ifndef LATTICED_TESTS_SERVER_SCENES_EXPORT_INPUT_H_
#define LATTICED_TESTS_SERVER_SCENES_EXPORT_INPUT_H_

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/status_macros.h"
#include "core/ffd/lattice.h"
#include "core/ffd/plan/deform_plan.h"
#include "server/engine/render/render_backend.h"
#include "server/engine/render/render_view.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {

// The mesh in a lattice.
inline absl::StatusOr<RenderInput> MakeInput(RenderBackend& backend,
                                             std::shared_ptr<const PolygonMesh> mesh,
                                             const Lattice& lattice) {
  LATTICED_ASSIGN_OR_RETURN(auto plan, MakePlan(std::move(mesh), lattice.structure));
  LATTICED_ASSIGN_OR_RETURN(auto target, backend.Prepare(plan, Pipeline::kFused));
  SceneState state;
  state.lattices = {{.map = std::make_shared<const OutsideMap>(lattice.structure)}};
  state.plan = plan;
  state.control_points = std::make_shared<const std::vector<Vec3d>>(lattice.control_points);
  Bounds bounds = plan->mesh_bounds;
  for (const Vec3d p : lattice.control_points) bounds.Extend(p);
  state.box = FitQuantisationBox(bounds, 1);
  return RenderInput{std::make_shared<const SceneState>(std::move(state)),
                     std::make_shared<TargetSlot>(&backend, std::move(target), std::move(plan),
                                                  MemoryReservation())};
}

// The mesh in a lattice of 5 x 4 x 4 control points of this degree, which are moved at random by `jitter`.
inline absl::StatusOr<RenderInput> MakeExportInput(RenderBackend& backend,
                                                   std::shared_ptr<const PolygonMesh> mesh,
                                                   std::array<int, 3> degree, double jitter) {
  LATTICED_ASSIGN_OR_RETURN(Lattice lattice,
                            FitLattice(mesh->ComputeBounds(), {5, 4, 4}, degree, 0.1));
  lattice.control_points = Jitter(lattice.structure, jitter, 7);
  return MakeInput(backend, std::move(mesh), lattice);
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SCENES_EXPORT_INPUT_H_
