// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether the volume folds under lattices that are turned against each other, box by box.
//
//   J = I + sum over g (J_g - I)        g: the lattices whose frames hold the point
//
// A cell is a knot box of the plan's own lattice, or a moved one of a turned lattice, for its part outside the plan's own
// frame: so nothing is looked at where all lattices are at rest.
//
//   near rest   sum over g |J_g - I| < 1, by bounds that are kept for each knot box. Most cells are
//   certified   each lattice adds a piece for each of its knot boxes that the cell meets, and for each face of its frame that
//               it crosses (volume_lattice.h). For each choice of a piece of every lattice, det J > 0 in the part of the cell
//               inside their planes (jacobian_form.h). So a step of J at a knot or at a face costs nothing
//   folded      det J of the definition (EvaluateWorld) is 0 or less, at the cell's centre or where its bound is least
//   neither     it is halved along the axis that costs the bound most; the cell with the least bound is next
//
// After kMostVolumeCells cells a knot box is undecided. The turned lattices' knot boxes outside are decided one by one, each
// with all other turned lattices, and make one decision.
//
// Outside the plan's own frame, a point closer to it than kPlaneSnap counts as inside, as in the definition. A turned lattice
// counts as the identity in knot boxes whose control points are all at rest, though these are rounded.
//
// Errors   what `stop` returns
// Threads  one at a time: what is known of knot boxes is kept from cell to cell
#ifndef LATTICED_CORE_FOLDS_TURNED_VOLUME_H_
#define LATTICED_CORE_FOLDS_TURNED_VOLUME_H_

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/folds/fold_report.h"
#include "core/folds/volume_lattice.h"

namespace latticed {

inline constexpr int kMostVolumeCells = 4'000;

struct VolumeDecision {
  FoldState state = FoldState::kCertified;
  // Unless certified: where det J is 0 or less, or else the least that was seen.
  Vec3d rest_point;
  double determinant = 0;
  int cells = 0;  // looked at, the first one not counted if it is near rest
};

// Keeps references to the plan and the control points.
class TurnedVolume {
 public:
  TurnedVolume(const DeformPlan& plan, std::span<const Vec3d> control_points);

  // Whether a moved control point of a turned lattice reaches a knot box of the plan.
  [[nodiscard]] bool IsReached(uint32_t box) const;
  [[nodiscard]] VolumeDecision DecideBox(uint32_t box);
  // All that is outside the plan's own frame: the first knot box that is folded there, or an undecided one.
  [[nodiscard]] absl::StatusOr<VolumeDecision> DecideOutside(StopCheck stop);

  // Whether a turned lattice reaches out of the frame of the plan's own one.
  [[nodiscard]] static bool ReachesOutside(const DeformPlan& plan);
  // By box, the outside box last: whether one of the control points can change what is decided about it.
  [[nodiscard]] static std::vector<bool> InfluencedBoxes(const DeformPlan& plan,
                                                         std::span<const uint32_t> indices);
  // What it keeps of the boxes of a plan.
  [[nodiscard]] static size_t MostBytes(const DeformPlan& plan);

 private:
  // A part of a knot box of the lattice `of`, in its parameters.
  struct Cell {
    size_t of = 0;
    std::array<int, 3> span{};
    Vec3d lower, upper;
    int halvings = 0;
    // Set by Bound: the bound of det J, the point where it is least, and the axis to halve.
    double least = 0;
    Vec3d place;
    int axis = 0;
  };

  [[nodiscard]] VolumeDecision Decide(const Cell& whole);
  [[nodiscard]] bool IsNearRest(const Cell& cell);
  void Bound(Cell& cell);
  // Takes the least bound of all choices of one of the pieces of each lattice.
  void BoundChoices(size_t lattice, const JacobianForm& form, double rest, Cell& cell);
  // Whether the definition is folded in the cell, at its centre or at its place.
  [[nodiscard]] bool Look(const Cell& cell, VolumeDecision& decision) const;

  const DeformPlan& plan_;
  std::span<const Vec3d> control_points_;
  std::vector<VolumeLattice> lattices_;           // the plan's own, then the turned ones
  std::vector<std::vector<VolumePiece>> pieces_;  // of the cell in hand, of lattices with any
  std::vector<CellPlane> planes_;                 // of the choice in hand
  Vec3d loss_;                                    // of the least bound of the cell in hand
};

}  // namespace latticed

#endif  // LATTICED_CORE_FOLDS_TURNED_VOLUME_H_
