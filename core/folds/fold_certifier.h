// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Certifies that a deformation does not fold, box by box: the determinant of box_determinant.h, decided by fold_search.h.
// With vertex weights a box is certified when all of its patches are, on which the surface's own determinant
// (weighted_determinant.h) is decided by triangle_search.h; a folded patch is the first one. With turned lattices the same is
// done by turned_determinant.h, and in the volume by turned_volume.h. The outside box is looked at too, if one of them reaches
// a patch there, or, in the volume, reaches out of the plan's own frame.
//
// The parts of the boxes that are looked at depend on the plan alone and are kept. A report of the control points before an
// edit saves the boxes that the edit does not influence: both ways lead to the same report. det J > 0 is local. It does not
// exclude that distant parts of a surface pass through each other.
//
// Units    world
// Errors   what `stop` returns
// Threads  immutable
#ifndef LATTICED_CORE_FOLDS_FOLD_CERTIFIER_H_
#define LATTICED_CORE_FOLDS_FOLD_CERTIFIER_H_

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/folds/box_determinant.h"
#include "core/folds/fold_report.h"
#include "core/folds/triangle_search.h"

namespace latticed {

class FoldCertifier {
 public:
  // A plan with weights has only kSurface.
  FoldCertifier(std::shared_ptr<const DeformPlan> plan, FoldScope scope);

  const DeformPlan& plan() const { return *plan_; }
  // Looks at all boxes in the scope. `stop` is called before each of them.
  [[nodiscard]] absl::StatusOr<FoldReport> Certify(std::span<const Vec3d> control_points,
                                                   StopCheck stop = NeverStop) const;
  // The same, from the report before the control points with the indices `changed` moved.
  [[nodiscard]] FoldReport Recertify(const FoldReport& before, std::span<const uint32_t> changed,
                                     std::span<const Vec3d> control_points) const;
  // The most bytes that a certifier and a report of a plan's boxes take.
  [[nodiscard]] static size_t MostBytes(const DeformPlan& plan);
  [[nodiscard]] size_t MemoryBytes() const {
    return sizeof *this + parts_.capacity() * sizeof(Part);
  }

 private:
  struct Part {
    uint32_t box = 0;
    std::array<int, 3> place{};
    BoxPart part;
  };

  // What looking at boxes one after the other keeps.
  struct Looker;

  [[nodiscard]] absl::Status Examine(const Part& part, Looker& looker, StopCheck stop,
                                     FoldReport& report) const;
  void ExamineBox(const Part& part, Looker& looker, FoldReport& report) const;
  template <typename Patches>
  void ExaminePatches(const Part& part, Patches& patches, TriangleSearch& search,
                      FoldReport& report) const;

  std::shared_ptr<const DeformPlan> plan_;
  FoldScope scope_;
  FrameMap map_;
  std::vector<Part> parts_;  // by box, ascending
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_FOLD_CERTIFIER_H_
