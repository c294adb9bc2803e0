// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Knows where a scene folds near its surface from edit to edit, so that only boxes that an edit influences are looked at.
//
//   Admit   before a batch with refuse_folds: is there a new fold?
//   Follow  after a batch: the report of the new state
//
// Nothing is made before the first of these calls. A batch that needs no report leaves the last one behind, and the next
// call looks at all boxes again.
//
// New folds. A fold is new in a box that is in a worse state than before (FoldState): folded or undecided where it was
// certified, or folded where it was undecided. If the edit makes other boxes, what counts of a box is its rest_point: the
// fold is new if all boxes that had this point before were in a better state. So a scene that was certified stays so.
//
// Errors   kFailedPrecondition: reason FOLD
// Threads  one at a time
#ifndef LATTICED_SERVER_ENGINE_SCENE_FOLD_GUARD_H_
#define LATTICED_SERVER_ENGINE_SCENE_FOLD_GUARD_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/folds/fold_certifier.h"
#include "server/engine/scene/scene_state.h"

namespace latticed {

class FoldGuard {
 public:
  // Whether a batch that leads from `before` to these control points, under `plan`, makes no new fold. The plan is another
  // one where structures or weights change.
  [[nodiscard]] absl::Status Admit(const SceneState& before,
                                   const std::shared_ptr<const DeformPlan>& plan,
                                   std::span<const Vec3d> control_points);
  // The report of `after`. `changed`: the control points that moved since `before`, if both have one plan.
  [[nodiscard]] std::shared_ptr<const FoldReport> Follow(const SceneState& before,
                                                         const SceneState& after,
                                                         std::span<const uint32_t> changed);
  [[nodiscard]] size_t MemoryBytes() const;

 private:
  // What is known of one state.
  struct Known {
    std::shared_ptr<const FoldCertifier> certifier;
    std::shared_ptr<const FoldReport> report;
    uint64_t revision = 0;  // of the report
  };

  const FoldReport& ReportOf(const SceneState& state);

  Known known_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_FOLD_GUARD_H_
