// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edits of a lattice, as a client writes them, and their effect on one lattice.
//
// Layout   positions in world coordinates; matrices 4x4 column-major, affine, acting on columns
// Errors   kInvalidArgument naming the field, such as "edits[2].set_control_points.indices[5]"; a
//          refused edit may leave its target half written, so callers work on a copy
// Threads  plain data and pure functions
#ifndef LATTICED_CORE_FFD_EDIT_LATTICE_EDIT_H_
#define LATTICED_CORE_FFD_EDIT_LATTICE_EDIT_H_

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/ffd/constraints/constraints.h"
#include "core/ffd/lattice.h"
#include "core/ffd/weights/vertex_weights.h"

namespace latticed {

struct SetControlPoints {
  std::vector<uint32_t> indices;
  std::vector<Vec3d> positions;
};
struct MoveControlPoints {
  std::vector<uint32_t> indices;
  Vec3d offset;
};
struct TransformControlPoints {
  std::vector<uint32_t> indices;
  std::array<double, 16> matrix{};
};
// Each point x goes to F(x) of the parent's deformation F.
struct CarryControlPoints {
  std::vector<uint32_t> indices;  // empty: all
  Lattice parent;
};
struct ReplaceControlPoints {
  std::vector<Vec3d> control_points;
};
struct DragPoints {
  std::vector<Vec3d> points;    // of the rest world
  std::vector<Vec3d> targets;   // one each
  std::vector<double> weights;  // one each (weights/vertex_weights.h); empty: 1
};
struct InsertKnot {
  int axis = 0;  // 0 = u, 1 = v, 2 = w
  double value = 0;
};
struct ReplaceLattice {
  Lattice lattice;          // with keep_shape it has no control points yet
  bool keep_shape = false;  // fits them to the present shape (lattice_refit.h); the frame must stay
};
using StructureEdit = std::variant<InsertKnot, ReplaceLattice>;
enum class ResetTo {
  kIdentity,  // Greville points of the present structure
  kInitial,  // the points that the scene was made with or that replaced them last, with the knots inserted since
};
struct Reset {
  ResetTo to = ResetTo::kIdentity;
};
enum class UndoScope {
  kMine,   // the caller's last step
  kScene,  // the last step, whoever made it
};
struct Undo {
  UndoScope scope = UndoScope::kMine;
};
struct Redo {};
struct SetConstraints {
  Constraints constraints;
};
// Takes the lattice out of its scene.
struct RemoveLattice {};
// How much of the deformation the scene takes: x goes to x + strength (F(x) - x).
struct SetStrength {
  double strength = 1;  // 0 to 1
};

using Edit =
    std::variant<SetControlPoints, MoveControlPoints, TransformControlPoints, ReplaceControlPoints,
                 DragPoints, InsertKnot, ReplaceLattice, Reset, Undo, Redo, SetConstraints,
                 CarryControlPoints, SetStrength, SetWeights, RemoveLattice>;

enum class GesturePhase {
  kUpdate,  // replaces the gesture's previous update; the meaning of an unspecified phase
  kCommit,  // as kUpdate where there are edits, then ends the gesture
  kCancel,  // takes the gesture back; carries no edits
};

struct EditBatch {
  uint32_t lattice = 0;  // which of a scene's lattices; a history is of one, and does not read it
  std::string editor_id;
  uint64_t sequence = 0;  // from 1, rising
  uint64_t structure_id = 0;
  std::optional<uint64_t> expected_revision;
  std::string gesture_id;  // empty: the batch is an undo step of its own
  GesturePhase gesture_phase = GesturePhase::kUpdate;
  std::vector<Edit> edits;
  // A scene refuses the batch if it makes a new fold (server/engine/scene/fold_guard.h).
  bool refuse_folds = false;
  // In place of the volume that the constraints keep.
  std::optional<KeptVolume> keep_volume;
  // Not OK: the request could not be parsed. The batch is then refused with this status, in its
  // place in the editor's sequence.
  absl::Status refusal;
};

// The edit of a batch of one, outside of gestures, if it is of this kind. Else null.
template <typename T>
const T* LoneEdit(const EditBatch& batch) {
  if (batch.edits.size() != 1 || !batch.gesture_id.empty()) return nullptr;
  return std::get_if<T>(&batch.edits.front());
}

// Whether its first edit is of weights. Records of such batches have a second one, of the points that restore a kept volume.
[[nodiscard]] inline bool SetsWeights(const EditBatch& batch) {
  return !batch.edits.empty() && std::holds_alternative<SetWeights>(batch.edits.front());
}

class PointFreedom;

// The lattice to which the edits of a batch are applied, one after the other.
struct EditTarget {
  Lattice lattice;
  double strength = 1;                    // of the scene
  const PointFreedom* freedom = nullptr;  // null: all points are free
  std::vector<bool> written;              // per control point
  double drag_residual = 0;               // the largest of the drags, world units
  bool strength_written = false;
  std::vector<uint32_t> named;  // what the present edit has written; their mirror images follow

  explicit EditTarget(Lattice start, double with_strength = 1);
};

// Applies one edit, as far as the target's freedom allows: held points stay, and images in the mirror move too. `field` is
// its path, such as "edits[2]". Errors: kInvalidArgument, also for insert_knot, replace_lattice, remove_lattice,
// set_constraints, set_weights, undo and redo, which need a history and must be alone in their batch; kFailedPrecondition
// NO_STRENGTH for a drag at strength 0. `initial` is called for the lattice that kInitial means.
[[nodiscard]] absl::Status ApplyEdit(const Edit& edit, absl::FunctionRef<Lattice()> initial,
                                     std::string_view field, EditTarget& target);

// kInvalidArgument naming `field`, reason NOT_FINITE or OUT_OF_RANGE: a scene's strength is 0 to 1.
[[nodiscard]] absl::Status CheckStrength(double strength, std::string_view field);

// kInvalidArgument for an edit that must be alone in its batch; `field` is its path with its name.
[[nodiscard]] absl::Status NotAlone(std::string_view field);

struct StructureChange {
  Lattice lattice;
  double residual = 0;  // of LatticeRefit, world units; 0 where no shape was to be kept
};

// Called with the structure that an edit leads to, before anything is changed; an error refuses the edit.
using AdmitStructure = std::function<absl::Status(const LatticeStructure&)>;

// The same with the weights that an edit leads to, null for none, under the present structure.
using AdmitWeights = std::function<absl::Status(const VertexWeights&)>;

// The same for an edit that takes the lattice away.
using AdmitRemoval = std::function<absl::Status()>;

// Called with the lattice and the strength that a batch leads to, before anything is changed; an error refuses the batch. It
// may be empty.
using AdmitPoints = std::function<absl::Status(
    const LatticeStructure&, std::span<const Vec3d> control_points, double strength)>;

// Makes another lattice of `lattice`. A knot on the axis `mirror` is inserted together with its mirror image. The edit's own
// lattice must be valid. Errors: kInvalidArgument naming a field that
// begins with `field`; those of `admit`.
[[nodiscard]] absl::StatusOr<StructureChange> ChangeStructure(const Lattice& lattice,
                                                              const StructureEdit& edit,
                                                              std::string_view field,
                                                              const AdmitStructure& admit,
                                                              std::optional<int> mirror = {});

// Whether two points have the same bits. A point "has not moved" if this is so.
[[nodiscard]] inline bool SameBits(Vec3d a, Vec3d b) {
  using Bits = std::array<uint64_t, 3>;
  const auto x = std::bit_cast<Bits>(a), y = std::bit_cast<Bits>(b);
  return ((x[0] ^ y[0]) | (x[1] ^ y[1]) | (x[2] ^ y[2])) == 0;
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_EDIT_LATTICE_EDIT_H_
