// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edit batches and their results <-> core/ffd.
//
// Errors   kInvalidArgument with the path of the field, such as
// "edits[2].move_control_points.offset"
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_EDIT_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_EDIT_CONVERTERS_H_

#include "absl/status/statusor.h"
#include "core/ffd/editor_ledger.h"
#include "core/ffd/lattice_edit.h"
#include "core/mesh/polygon_mesh.h"
#include "latticed/v1/edit.pb.h"

namespace latticed {

// Checks what the message and the scene's mesh can tell: counts that must agree, known enum values,
// finite numbers, points of the surface. Indices, sequence and structure are the scene's to judge.
[[nodiscard]] absl::StatusOr<EditBatch> FromProto(const v1::EditBatch& batch,
                                                  const PolygonMesh& mesh);

// The same, for a scene to judge in its editor's sequence: what cannot be read is in `refusal`.
[[nodiscard]] EditBatch BatchFromProto(const v1::EditBatch& batch, const PolygonMesh& mesh);

// All but the timings.
[[nodiscard]] v1::EditResult ToProto(const EditSummary& summary);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_EDIT_CONVERTERS_H_
