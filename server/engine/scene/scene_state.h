// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene at one revision, and what follows from it.
//
// Threads  immutable once it is a scene's; pure functions
#ifndef LATTICED_SERVER_ENGINE_SCENE_SCENE_STATE_H_
#define LATTICED_SERVER_ENGINE_SCENE_SCENE_STATE_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/time/time.h"
#include "core/base/bounds.h"
#include "core/ffd/lattice.h"
#include "core/ffd/pick/patch_tree.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/plan/quantisation_box.h"
#include "server/engine/lattices/scene_lattice.h"
#include "server/engine/scene/scene_measures.h"

namespace latticed {

struct SceneState {
  uint64_t revision = 0;
  uint64_t structure_id =
      1;                   // names knots, frame and what goes on outside; a new plan has a new one
  SceneLattices lattices;  // as edits and clients see them
  std::shared_ptr<const DeformPlan> plan;       // of their sum, with what goes on outside
  std::shared_ptr<const PatchTree> patch_tree;  // of the plan
  std::shared_ptr<SceneMeasures> measures;      // of the plan
  std::shared_ptr<const std::vector<Vec3d>> control_points;  // of the plan
  QuantisationBox box;
  // Which of the plan's control points influence any patch: the box must hold these, and the patches outside.
  std::shared_ptr<const std::vector<bool>> influential;
  uint64_t patches_on_faces = 0;  // MayTear, of the plan
  absl::Time commit_time;
  // About the edit that made the revision.
  uint64_t patches_touched = 0;
  bool gesture_open = false;
  // Until when edits count as coming, unless a newer state says otherwise: see BusyUntil.
  absl::Time busy_until;
};

// Control points with a non-zero basis function on a box that holds patches.
[[nodiscard]] std::vector<bool> InfluentialPoints(const DeformPlan& plan);

// How many patches have an edge or corner on a face where a move of the lattice may tear the surface. Where the lattice is
// continued beyond a face, and fades out, none may.
[[nodiscard]] uint64_t PatchesThatMayTear(const DeformPlan& plan, const SceneLattices& lattices);

// What the quantisation box must hold: a B-spline volume stays in the hull of its control points, and what turned lattices add
// in the hull of their moves. With weights, points lie
// between there and the mesh at rest.
[[nodiscard]] Bounds BoundsOf(const SceneState& state);

// Until when edits count as coming after one at `edit_time`, when the edit before it was at `before`. They
// pause after one and a half times the time between the two, but not less than 40 nor more than 80 ms.
[[nodiscard]] absl::Time BusyUntil(absl::Time before, absl::Time edit_time);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_SCENE_STATE_H_
