// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edit batches and their results <-> core/ffd.
//
// Errors   kInvalidArgument with the path of the field, "edits[2].move_control_points.offset"
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_EDIT_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_EDIT_CONVERTERS_H_

#include "absl/status/statusor.h"
#include "core/ffd/edit/lattice_edit.h"
#include "core/ffd/history/editor_ledger.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/weights/vertex_weights.h"
#include "core/mesh/polygon_mesh.h"
#include "latticed/v1/edit.pb.h"

namespace latticed {

// Checks what follows from the message and the scene's mesh: counts that must agree, known enum values,
// finite numbers, points of the surface. The scene checks indices, sequence and structure.
[[nodiscard]] absl::StatusOr<EditBatch> FromProto(const v1::EditBatch& batch,
                                                  const PolygonMesh& mesh,
                                                  const VertexWeights& weights = nullptr);

// The same, but an error is put in `refusal`, so that the scene refuses the batch in its place in the
// editor's sequence.
[[nodiscard]] EditBatch BatchFromProto(const v1::EditBatch& batch, const PolygonMesh& mesh,
                                       const VertexWeights& weights = nullptr);
// The same for a scene with this plan.
[[nodiscard]] inline EditBatch BatchFromProto(const v1::EditBatch& batch, const DeformPlan& plan) {
  return BatchFromProto(batch, *plan.mesh, plan.mesh_weights);
}

// Whether applying the batch may take more than a millisecond: it drags many points or keeps a volume, or it may change
// the structure, and a plan must be made. Where it is examined for folds, as in scenes with fold_watch, also if it moves
// many control points.
[[nodiscard]] bool MayTakeLong(const v1::EditBatch& batch, bool fold_watch = false);

// Sets all fields but the timings.
[[nodiscard]] v1::EditResult ToProto(const EditSummary& summary);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_EDIT_CONVERTERS_H_
