// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Undo steps as layers over a base lattice. A control point has the position in the topmost layer
// that holds it, else its position in the base:
//
//   point               0  1  2  3
//   step 3 (editor B)   .  .  p  .     Removing step 2 gives point 0 its position in the base,
//   step 2 (editor A)   p  .  p  .     and does not change point 2, which step 3 holds.
//   base                p  p  p  p
//
// A step that changes the structure holds every point. The indices of steps above it refer to its structure, so nothing
// below it can be taken out before it. A step that removes the lattice keeps all points; a replacement above it ends its
// absence.
//
// Errors   none: callers check first
// Threads  plain data
#ifndef LATTICED_CORE_FFD_HISTORY_EDIT_LAYERS_H_
#define LATTICED_CORE_FFD_HISTORY_EDIT_LAYERS_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/ffd/edit/lattice_edit.h"
#include "core/ffd/lattice.h"

namespace latticed {

// A step in the history of another lattice of the scene.
struct FollowedStep {
  uint32_t lattice = 0;
  uint64_t step = 0;  // its id
  friend bool operator==(const FollowedStep&, const FollowedStep&) = default;
};

struct EditStep {
  // The structure that an edit made, and the edit, which a redo repeats. A replacement is kept without its lattice, which
  // is `structure` and `positions`.
  struct Structural {
    LatticeStructure structure;
    StructureEdit edit;

    bool replaces() const { return std::holds_alternative<ReplaceLattice>(edit); }
  };

  uint64_t id = 0;
  // The id of the structural step to whose structure these indices refer; 0 = the initial structure.
  uint64_t structure_step = 0;
  uint64_t written_at = 0;
  std::string editor_id;
  std::string gesture_id;
  bool open = false;       // its gesture has not ended
  bool timed_out = false;  // committed by silence: an update may open it again
  std::chrono::steady_clock::time_point last_heard;
  // Control points, ascending, and their positions. A structural step has no indices, but the positions of all points.
  std::vector<uint32_t> indices;
  std::vector<Vec3d> positions;
  // The positions before the gesture of all points that it has ever touched.
  std::map<uint32_t, Vec3d> start;
  std::optional<Structural> structural;
  // What edits keep from this step on. Of set_constraints, and of structural steps, whose control points are others.
  std::optional<Constraints> constraints;
  // The scene's strength from this step on.
  std::optional<double> strength;
  // The scene's vertex weights from this step on; null: none.
  std::optional<VertexWeights> weights;
  // Whether it takes the lattice away.
  bool removes = false;
  // The step of another lattice after which this one restores the volume. It comes and goes with that one alone.
  std::optional<FollowedStep> follows;

  void Close(bool by_time_out);
  bool Overlaps(const EditStep& other) const;
  size_t MemoryBytes() const;
};

// What lies below all steps: what lattice() and initial() would be without them, and the id of the structural step that
// base comes from, 0 for none.
struct LayersBase {
  Lattice base;
  Lattice initial;
  uint64_t structure_step = 0;
  Constraints constraints;
  double strength = 1;
  std::optional<VertexWeights> weights;  // unset: as the scene was made
  bool absent = false;                   // there is no lattice yet, or no more
};

class EditLayers {
 public:
  explicit EditLayers(Lattice base, double strength = 1);
  // Goes on from what another one had. Steps must fit the structures below them.
  EditLayers(LayersBase base, std::deque<EditStep> steps);

  const Lattice& lattice() const { return lattice_; }
  // The lattice that the layers began with, or the last replacement as it was made.
  Lattice initial() const;
  // What edits keep now.
  const Constraints& constraints() const;
  // The scene's strength now.
  double strength() const { return StrengthWithout(steps_.size()); }
  // The scene's vertex weights now; unset: as it was made.
  std::optional<VertexWeights> weights() const { return WeightsWithout(steps_.size()); }
  // Whether the lattice is away. Its points and structure are then those that it had, or will have.
  bool absent() const { return AbsentWithout(steps_.size()); }
  const LayersBase& base() const { return base_; }
  // Oldest first.
  const std::deque<EditStep>& steps() const { return steps_; }

  void Push(EditStep step);
  EditStep Remove(size_t position);
  // Ends the step's gesture. After a time-out, a later update may continue it.
  void Close(size_t position, bool timed_out);
  // Makes the oldest step part of the base: it can no longer be undone.
  void FoldOldest();

  // Id of the topmost structural step; 0 if there is none.
  uint64_t structure_step() const;
  // The control points without the step at `position`, which is not structural.
  std::vector<Vec3d> PointsWithout(size_t position) const;
  // The strength without the step at `position`.
  double StrengthWithout(size_t position) const;
  // The vertex weights without it.
  std::optional<VertexWeights> WeightsWithout(size_t position) const;
  // Whether the lattice is away without it.
  bool AbsentWithout(size_t position) const;
  // The structure without the step at `position`.
  const LatticeStructure& StructureWithout(size_t position) const;
  // The bytes of all steps.
  size_t MemoryBytes() const { return bytes_; }
  // The bytes of the two lattices below the steps, as far as they have more control points than the present one; of an absent
  // lattice all, and its own.
  size_t BaseBytes() const;

 private:
  // Gives the points with these indices the positions that they have without the step at `skipped`.
  void RestorePoints(const std::vector<uint32_t>& indices, size_t skipped,
                     std::vector<Vec3d>& points) const;
  void RebuildLattice();

  LayersBase base_;
  Lattice lattice_;
  std::deque<EditStep> steps_;  // each edit adds one at the end, and folds one at the front
  size_t bytes_ = 0;            // of steps_
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_HISTORY_EDIT_LAYERS_H_
