// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/edit_converters.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/wire/constraint_converters.h"
#include "server/wire/converters.h"
#include "server/wire/enum_table.h"
#include "server/wire/fold_converters.h"
#include "server/wire/grpc_status.h"
#include "server/wire/outside_converters.h"
#include "server/wire/surface_points.h"

namespace latticed {
namespace {

using Indices = google::protobuf::RepeatedField<uint32_t>;

constexpr auto kAxes =
    std::to_array<std::pair<v1::LatticeAxis, int>>({{v1::LATTICE_AXIS_U, 0},
                                                    {v1::LATTICE_AXIS_V, 1},
                                                    {v1::LATTICE_AXIS_W, 2},
                                                    {v1::LATTICE_AXIS_UNSPECIFIED, 0}});

constexpr auto kTargets = std::to_array<std::pair<v1::ResetTarget, ResetTo>>(
    {{v1::RESET_TARGET_IDENTITY, ResetTo::kIdentity},
     {v1::RESET_TARGET_INITIAL, ResetTo::kInitial},
     {v1::RESET_TARGET_UNSPECIFIED, ResetTo::kIdentity}});

constexpr auto kScopes = std::to_array<std::pair<v1::UndoScope, UndoScope>>(
    {{v1::UNDO_SCOPE_MINE, UndoScope::kMine},
     {v1::UNDO_SCOPE_SCENE, UndoScope::kScene},
     {v1::UNDO_SCOPE_UNSPECIFIED, UndoScope::kMine}});

constexpr auto kPhases = std::to_array<std::pair<v1::GesturePhase, GesturePhase>>(
    {{v1::GESTURE_PHASE_UPDATE, GesturePhase::kUpdate},
     {v1::GESTURE_PHASE_COMMIT, GesturePhase::kCommit},
     {v1::GESTURE_PHASE_CANCEL, GesturePhase::kCancel},
     {v1::GESTURE_PHASE_UNSPECIFIED, GesturePhase::kUpdate}});

absl::StatusOr<std::vector<uint32_t>> ReadIndices(const Indices& indices, std::string_view field) {
  if (indices.empty()) {
    return error::InvalidField(fmt::format("{}.indices", field), "at least one is needed");
  }
  if (indices.size() > limits::kMaxControlPoints) {
    return error::OutOfRange(fmt::format("{}.indices", field), indices.size(), 1,
                             limits::kMaxControlPoints);
  }
  return std::vector<uint32_t>(indices.begin(), indices.end());
}

absl::StatusOr<Edit> Read(const v1::SetControlPoints& edit, std::string_view field) {
  LATTICED_ASSIGN_OR_RETURN(auto indices, ReadIndices(edit.indices(), field));
  const std::string positions_field = fmt::format("{}.positions", field);
  LATTICED_ASSIGN_OR_RETURN(
      auto positions,
      PointsFromProto(edit.positions(), limits::kMaxControlPoints, positions_field));
  if (positions.size() != indices.size()) {
    return error::InvalidField(positions_field, fmt::format("got {} points for {} indices",
                                                            positions.size(), indices.size()));
  }
  return SetControlPoints{std::move(indices), std::move(positions)};
}

absl::StatusOr<Edit> Read(const v1::MoveControlPoints& edit, std::string_view field) {
  LATTICED_ASSIGN_OR_RETURN(auto indices, ReadIndices(edit.indices(), field));
  const std::string offset_field = fmt::format("{}.offset", field);
  if (!edit.has_offset()) return error::InvalidField(offset_field, "is required");
  LATTICED_ASSIGN_OR_RETURN(const auto offset, FromProto(edit.offset(), offset_field));
  return MoveControlPoints{std::move(indices), offset};
}

absl::StatusOr<Edit> Read(const v1::TransformControlPoints& edit, std::string_view field) {
  LATTICED_ASSIGN_OR_RETURN(auto indices, ReadIndices(edit.indices(), field));
  TransformControlPoints result{std::move(indices), {}};
  if (static_cast<size_t>(edit.matrix_size()) != result.matrix.size()) {
    return error::InvalidField(fmt::format("{}.matrix", field),
                               fmt::format("got {} numbers, 16 are needed", edit.matrix_size()));
  }
  std::copy(edit.matrix().begin(), edit.matrix().end(), result.matrix.begin());
  return result;
}

absl::StatusOr<Edit> Read(const v1::CarryControlPoints& edit, std::string_view field) {
  std::vector<uint32_t> indices;
  if (!edit.indices().empty()) {
    LATTICED_ASSIGN_OR_RETURN(indices, ReadIndices(edit.indices(), field));
  }
  const std::string path = fmt::format("{}.parent", field);
  if (!edit.has_parent()) return error::InvalidField(path, "must be set");
  if (edit.parent().control_points().empty()) {
    return error::InvalidField(path + ".control_points", "an identity moves nothing");
  }
  LATTICED_RETURN_IF_ERROR(CheckHasWidths(edit.parent().outside(), path + ".outside"));
  LATTICED_ASSIGN_OR_RETURN(auto parent, FromProto(edit.parent(), path));
  return CarryControlPoints{std::move(indices), std::move(parent)};
}

absl::StatusOr<Edit> Read(const v1::ReplaceControlPoints& edit, std::string_view field) {
  LATTICED_ASSIGN_OR_RETURN(auto points,
                            PointsFromProto(edit.control_points(), limits::kMaxControlPoints,
                                            fmt::format("{}.control_points", field)));
  return ReplaceControlPoints{std::move(points)};
}

absl::StatusOr<Edit> Read(const v1::DragPoints& edit, const PolygonMesh& mesh,
                          const VertexWeights& weights, std::string_view field) {
  const int count = edit.points_size();
  if (count < 1 || static_cast<size_t>(count) > limits::kMaxDragPoints) {
    return error::OutOfRange(fmt::format("{}.points", field), count, 1,
                             static_cast<double>(limits::kMaxDragPoints));
  }
  const std::string targets_field = fmt::format("{}.targets", field);
  LATTICED_ASSIGN_OR_RETURN(auto targets,
                            PointsFromProto(edit.targets(), limits::kMaxDragPoints, targets_field));
  if (targets.size() != static_cast<size_t>(count)) {
    return error::InvalidField(targets_field,
                               fmt::format("got {} targets for {} points", targets.size(), count));
  }
  DragPoints drag{.targets = std::move(targets)};
  for (int i = 0; i < count; ++i) {
    LATTICED_ASSIGN_OR_RETURN(
        const auto rest,
        RestPointFromProto(mesh, weights, edit.points(i), fmt::format("{}.points[{}]", field, i)));
    drag.points.push_back(rest.position);
    if (weights != nullptr) drag.weights.push_back(rest.weight);
  }
  return drag;
}

absl::StatusOr<Edit> Read(const v1::InsertKnot& edit, std::string_view field) {
  LATTICED_ASSIGN_OR_RETURN(const int axis,
                            ReadEnum(kAxes, edit.axis(), fmt::format("{}.axis", field)));
  return InsertKnot{axis, edit.value()};
}

absl::StatusOr<Edit> Read(const v1::ReplaceLattice& edit, const PolygonMesh& mesh,
                          std::string_view field) {
  const std::string path = fmt::format("{}.lattice", field);
  if (!edit.has_lattice()) return error::InvalidField(path, "must be set");
  if (edit.keep_shape() && edit.lattice().control_points_size() > 0) {
    return error::InvalidField(path + ".control_points", "must be empty with keep_shape");
  }
  if (edit.keep_shape()) {
    LATTICED_ASSIGN_OR_RETURN(auto structure,
                              StructureFromProto(edit.lattice(), path, mesh.positions));
    return ReplaceLattice{{.structure = std::move(structure), .control_points = {}}, true};
  }
  LATTICED_ASSIGN_OR_RETURN(auto lattice, FromProto(edit.lattice(), path, mesh.positions));
  return ReplaceLattice{std::move(lattice), false};
}

absl::StatusOr<Edit> Read(const v1::Reset& edit, std::string_view field) {
  LATTICED_ASSIGN_OR_RETURN(const ResetTo target,
                            ReadEnum(kTargets, edit.target(), fmt::format("{}.target", field)));
  return Reset{target};
}

absl::StatusOr<Edit> Read(const v1::Undo& edit, std::string_view field) {
  LATTICED_ASSIGN_OR_RETURN(const UndoScope scope,
                            ReadEnum(kScopes, edit.scope(), fmt::format("{}.scope", field)));
  return Undo{scope};
}

absl::StatusOr<Edit> Read(const v1::SetConstraints& edit, std::string_view field) {
  LATTICED_ASSIGN_OR_RETURN(auto constraints,
                            FromProto(edit.constraints(), fmt::format("{}.constraints", field)));
  return SetConstraints{std::move(constraints)};
}

absl::StatusOr<Edit> Read(const v1::SetStrength& edit, std::string_view field) {
  if (!edit.has_strength()) {
    return error::InvalidField(fmt::format("{}.strength", field), "is required");
  }
  return SetStrength{edit.strength()};
}

absl::StatusOr<std::vector<float>> ReadFloats(const std::string& bytes, std::string_view field) {
  if (bytes.size() % sizeof(float) != 0) {
    return error::InvalidField(
        field, fmt::format("{} bytes are no whole number of float32", bytes.size()));
  }
  std::vector<float> floats(bytes.size() / sizeof(float));
  std::ranges::copy(bytes, reinterpret_cast<char*>(floats.data()));
  return floats;
}

absl::StatusOr<Edit> Read(const v1::SetWeights& edit, std::string_view field) {
  SetWeights result;
  switch (edit.change_case()) {
    case v1::SetWeights::kValues: {
      const std::string path = fmt::format("{}.values", field);
      LATTICED_ASSIGN_OR_RETURN(result.values, ReadFloats(edit.values(), path));
      if (result.values.empty()) return error::InvalidField(path, "must not be empty");
      return result;
    }
    case v1::SetWeights::kSome: {
      const std::string path = fmt::format("{}.some", field);
      const auto& indices = edit.some().indices();
      if (indices.empty()) {
        return error::InvalidField(fmt::format("{}.indices", path), "at least one is needed");
      }
      result.indices.assign(indices.begin(), indices.end());
      LATTICED_ASSIGN_OR_RETURN(result.values,
                                ReadFloats(edit.some().values(), fmt::format("{}.values", path)));
      return result;
    }
    case v1::SetWeights::kClear:
      if (edit.clear()) return result;
      return error::InvalidField(fmt::format("{}.clear", field), "must be true where it is set");
    case v1::SetWeights::CHANGE_NOT_SET:
      break;
  }
  if (HoldsUnknown(edit)) return error::Unsupported(field, "this change of weights");
  return error::InvalidField(field, "values, some or clear must be set");
}

absl::StatusOr<Edit> ReadEdit(const v1::Edit& edit, const PolygonMesh& mesh,
                              const VertexWeights& weights, const std::string& field) {
  switch (edit.edit_case()) {
    case v1::Edit::kSetControlPoints:
      return Read(edit.set_control_points(), field + ".set_control_points");
    case v1::Edit::kMoveControlPoints:
      return Read(edit.move_control_points(), field + ".move_control_points");
    case v1::Edit::kTransformControlPoints:
      return Read(edit.transform_control_points(), field + ".transform_control_points");
    case v1::Edit::kReplaceControlPoints:
      return Read(edit.replace_control_points(), field + ".replace_control_points");
    case v1::Edit::kDragPoints:
      return Read(edit.drag_points(), mesh, weights, field + ".drag_points");
    case v1::Edit::kInsertKnot:
      return Read(edit.insert_knot(), field + ".insert_knot");
    case v1::Edit::kReplaceLattice:
      return Read(edit.replace_lattice(), mesh, field + ".replace_lattice");
    case v1::Edit::kReset:
      return Read(edit.reset(), field + ".reset");
    case v1::Edit::kUndo:
      return Read(edit.undo(), field + ".undo");
    case v1::Edit::kRedo:
      return Redo{};
    case v1::Edit::kSetConstraints:
      return Read(edit.set_constraints(), field + ".set_constraints");
    case v1::Edit::kCarryControlPoints:
      return Read(edit.carry_control_points(), field + ".carry_control_points");
    case v1::Edit::kSetStrength:
      return Read(edit.set_strength(), field + ".set_strength");
    case v1::Edit::kSetWeights:
      return Read(edit.set_weights(), field + ".set_weights");
    case v1::Edit::kRemoveLattice:
      return RemoveLattice{};
    case v1::Edit::EDIT_NOT_SET:
      break;
  }
  if (HoldsUnknown(edit)) return error::Unsupported(field, "this kind of edit");
  return error::InvalidField(field, "one kind of edit must be set");
}

}  // namespace

absl::StatusOr<EditBatch> FromProto(const v1::EditBatch& batch, const PolygonMesh& mesh,
                                    const VertexWeights& weights) {
  EditBatch result;
  result.lattice = batch.lattice();
  result.editor_id = batch.editor_id();
  result.sequence = batch.sequence();
  result.structure_id = batch.structure_id();
  if (batch.has_expected_revision()) result.expected_revision = batch.expected_revision();
  result.gesture_id = batch.gesture_id();
  LATTICED_ASSIGN_OR_RETURN(result.gesture_phase,
                            ReadEnum(kPhases, batch.gesture_phase(), "gesture_phase"));
  result.refuse_folds = batch.refuse_folds();
  if (batch.has_keep_volume()) {
    LATTICED_ASSIGN_OR_RETURN(result.keep_volume, FromProto(batch.keep_volume(), "keep_volume"));
  }
  result.edits.reserve(static_cast<size_t>(batch.edits_size()));
  for (int i = 0; i < batch.edits_size(); ++i) {
    // Refused before it is read: many short ones would take far more memory than the request.
    if (batch.edits(i).has_replace_lattice() && batch.edits_size() > 1) {
      return NotAlone(fmt::format("edits[{}].replace_lattice", i));
    }
    auto edit = ReadEdit(batch.edits(i), mesh, weights, fmt::format("edits[{}]", i));
    if (!edit.ok()) return edit.status();  // with the macro, GCC 12 takes the variant for unset
    result.edits.push_back(*std::move(edit));
  }
  return result;
}

EditBatch BatchFromProto(const v1::EditBatch& batch, const PolygonMesh& mesh,
                         const VertexWeights& weights) {
  auto readable = FromProto(batch, mesh, weights);
  if (readable.ok()) return *std::move(readable);
  EditBatch refused;
  refused.lattice = batch.lattice();
  refused.editor_id = batch.editor_id();
  refused.sequence = batch.sequence();
  refused.structure_id = batch.structure_id();
  refused.refusal = readable.status();
  return refused;
}

bool MayTakeLong(const v1::EditBatch& batch, bool fold_watch) {
  constexpr int kQuickDragPoints = 64, kQuickEdits = 64, kQuickFoldPoints = 64;
  int points = 0, moved = 0;
  if (batch.has_keep_volume()) return true;
  for (const v1::Edit& edit : batch.edits()) {
    if (edit.has_insert_knot() || edit.has_replace_lattice() || edit.has_reset() ||
        edit.has_set_constraints() || edit.has_undo() || edit.has_redo() ||
        edit.has_carry_control_points() || edit.has_set_strength() || edit.has_set_weights() ||
        edit.has_remove_lattice()) {
      return true;
    }
    points += edit.drag_points().points_size();
    moved += edit.set_control_points().indices_size() + edit.move_control_points().indices_size() +
             edit.transform_control_points().indices_size() +
             edit.replace_control_points().control_points_size();
  }
  if ((fold_watch || batch.refuse_folds()) && moved > kQuickFoldPoints) return true;
  return points > kQuickDragPoints || batch.edits_size() > kQuickEdits;
}

v1::EditResult ToProto(const EditSummary& summary) {
  v1::EditResult result;
  result.set_sequence(summary.sequence);
  if (!summary.status.ok()) *result.mutable_status() = ToRpcStatus(summary.status);
  result.set_revision(summary.revision);
  result.set_structure_id(summary.structure_id);
  result.set_boxes_touched(summary.boxes_touched);
  result.set_patches_touched(summary.patches_touched);
  result.set_largest_move(summary.largest_move);
  result.set_drag_residual(summary.drag_residual);
  if (summary.folds != nullptr) {
    *result.mutable_folds() =
        ToProto(*summary.folds, summary.revision, summary.structure_id, kMostEditPlaces);
  }
  return result;
}

}  // namespace latticed
