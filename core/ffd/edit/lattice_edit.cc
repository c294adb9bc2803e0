// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/edit/lattice_edit.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/constraints/point_freedom.h"
#include "core/ffd/control_point_range.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/edit/direct_manipulation.h"
#include "core/ffd/edit/knot_insertion.h"
#include "core/ffd/edit/lattice_refit.h"
#include "core/ffd/outside/outside_map.h"
#include "fmt/format.h"

namespace latticed {

absl::Status NotAlone(std::string_view field) {
  return error::InvalidField(field, "must be the only edit of its batch, outside any gesture");
}

namespace {

// Indices must be in range, and none may come twice: the order of two changes of one point would
// not be defined.
absl::Status CheckIndices(const std::vector<uint32_t>& indices, size_t count,
                          std::string_view field) {
  if (indices.empty()) {
    return error::InvalidField(fmt::format("{}.indices", field), "must not be empty");
  }
  std::vector<bool> seen(count);
  for (size_t n = 0; n < indices.size(); ++n) {
    const uint32_t index = indices[n];
    if (index >= count) {
      return error::OutOfRange(fmt::format("{}.indices[{}]", field, n), index, 0,
                               static_cast<double>(count) - 1);
    }
    if (seen[index]) {
      return error::InvalidField(fmt::format("{}.indices[{}]", field, n),
                                 fmt::format("control point {} is named twice", index));
    }
    seen[index] = true;
  }
  return absl::OkStatus();
}

absl::Status CheckCount(size_t got, size_t expected, const std::string& field) {
  if (got == expected) return absl::OkStatus();
  return error::InvalidField(
      field, fmt::format("got {} numbers, x, y, z of {} control points = {} are needed", 3 * got,
                         expected, 3 * expected));
}

absl::Status Write(EditTarget& target, uint32_t index, Vec3d position, const std::string& field) {
  LATTICED_RETURN_IF_ERROR(CheckControlPoint(position, field));
  if (target.freedom != nullptr && target.freedom->is_held(index)) return absl::OkStatus();
  target.lattice.control_points[index] = position;
  target.written[index] = true;
  target.named.push_back(index);
  return absl::OkStatus();
}

// Positions travel as a flat list x, y, z, x, …: errors name the component in it. Its name is made for an error only.
absl::Status CheckListed(const std::vector<Vec3d>& positions, size_t n, const std::string& field) {
  for (int c = 0; c < 3; ++c) {
    const double x = positions[n][c];
    if (CheckControlCoordinate(x, field).ok()) continue;
    return CheckControlCoordinate(x, fmt::format("{}[{}]", field, 3 * n + static_cast<size_t>(c)));
  }
  return absl::OkStatus();
}

absl::Status WriteListed(EditTarget& target, uint32_t index, const std::vector<Vec3d>& positions,
                         size_t n, const std::string& field) {
  LATTICED_RETURN_IF_ERROR(CheckListed(positions, n, field));
  return Write(target, index, positions[n], field);
}

absl::Status Apply(const SetControlPoints& edit, std::string_view field, EditTarget& target) {
  const std::string path = fmt::format("{}.set_control_points", field);
  const std::string positions = path + ".positions";
  auto status = CheckIndices(edit.indices, target.lattice.control_points.size(), path);
  if (status.ok()) status = CheckCount(edit.positions.size(), edit.indices.size(), positions);
  for (size_t n = 0; status.ok() && n < edit.indices.size(); ++n) {
    status = WriteListed(target, edit.indices[n], edit.positions, n, positions);
  }
  return status;
}

absl::Status Apply(const MoveControlPoints& edit, std::string_view field, EditTarget& target) {
  const std::string path = fmt::format("{}.move_control_points", field);
  const std::string offset = path + ".offset";
  auto& points = target.lattice.control_points;
  auto status = CheckIndices(edit.indices, points.size(), path);
  if (status.ok() && !IsFinite(edit.offset)) status = error::NotFinite(offset);
  for (size_t n = 0; status.ok() && n < edit.indices.size(); ++n) {
    const uint32_t index = edit.indices[n];
    status = Write(target, index, points[index] + edit.offset, offset);
  }
  return status;
}

absl::Status CheckAffine(const std::array<double, 16>& m, const std::string& path) {
  if (!std::all_of(m.begin(), m.end(), [](double x) { return std::isfinite(x); })) {
    return error::NotFinite(path);
  }
  if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) {
    return error::InvalidField(path,
                               fmt::format("the last row is ({}, {}, {}, {}), an affine matrix has "
                                           "(0, 0, 0, 1); matrices are column-major",
                                           m[3], m[7], m[11], m[15]));
  }
  return absl::OkStatus();
}

absl::Status Apply(const TransformControlPoints& edit, std::string_view field, EditTarget& target) {
  const std::string path = fmt::format("{}.transform_control_points", field);
  const std::string matrix = path + ".matrix";
  auto& points = target.lattice.control_points;
  auto status = CheckIndices(edit.indices, points.size(), path);
  if (status.ok()) status = CheckAffine(edit.matrix, matrix);
  const auto column = [&edit](size_t c) {
    return Vec3d{edit.matrix[4 * c], edit.matrix[4 * c + 1], edit.matrix[4 * c + 2]};
  };
  for (size_t n = 0; status.ok() && n < edit.indices.size(); ++n) {
    const Vec3d p = points[edit.indices[n]];
    status = Write(target, edit.indices[n],
                   p.x * column(0) + p.y * column(1) + p.z * column(2) + column(3), matrix);
  }
  return status;
}

absl::Status Apply(const CarryControlPoints& edit, std::string_view field, EditTarget& target) {
  const std::string path = fmt::format("{}.carry_control_points", field);
  const std::string parent = path + ".parent";
  auto& points = target.lattice.control_points;
  std::vector<uint32_t> all;
  if (edit.indices.empty()) {
    all.resize(points.size());
    std::iota(all.begin(), all.end(), 0u);
  }
  const std::vector<uint32_t>& indices = edit.indices.empty() ? all : edit.indices;
  const OutsideMap outside(edit.parent.structure);
  const std::vector<Vec3d> continued = outside.Continue(edit.parent.control_points);
  auto status = CheckIndices(indices, points.size(), path);
  for (size_t n = 0; status.ok() && n < indices.size(); ++n) {
    const uint32_t index = indices[n];
    const DeformedPoint carried = EvaluateWorld(outside.continued(), continued, points[index]);
    if (carried.inside) status = Write(target, index, carried.position, parent);
  }
  return status;
}

absl::Status WriteAll(const std::vector<Vec3d>& positions, const std::string& path,
                      EditTarget& target) {
  absl::Status status;
  for (size_t i = 0; status.ok() && i < positions.size(); ++i) {
    status = WriteListed(target, static_cast<uint32_t>(i), positions, i, path);
  }
  return status;
}

absl::Status Apply(const ReplaceControlPoints& edit, std::string_view field, EditTarget& target) {
  const std::string path = fmt::format("{}.replace_control_points.control_points", field);
  auto status = CheckCount(edit.control_points.size(), target.lattice.control_points.size(), path);
  return status.ok() ? WriteAll(edit.control_points, path, target) : status;
}

absl::Status Apply(const DragPoints& edit, std::string_view field, EditTarget& target) {
  const std::string path = fmt::format("{}.drag_points", field);
  const std::string targets = path + ".targets";
  const size_t count = edit.points.size();
  LATTICED_RETURN_IF_ERROR(error::CheckRange(path + ".points", static_cast<double>(count), 1,
                                             static_cast<double>(limits::kMaxDragPoints)));
  if (edit.targets.size() != count) {
    return error::InvalidField(
        targets, fmt::format("got {} targets for {} points", edit.targets.size(), count));
  }
  absl::Status status;
  for (size_t n = 0; status.ok() && n < count; ++n) {
    status = CheckListed(edit.targets, n, targets);
  }
  if (!status.ok()) return status;
  if (target.strength == 0) {
    return error::FailedPrecondition(
        "NO_STRENGTH", fmt::format("{}: the scene's strength is 0, so no control point moves the "
                                   "surface; set another strength first",
                                   path));
  }
  const ControlPointMoves moves = DragToTargets(target.lattice, edit.points, edit.targets,
                                                target.freedom, edit.weights, target.strength);
  for (size_t n = 0; status.ok() && n < moves.indices.size(); ++n) {
    const uint32_t index = moves.indices[n];
    status = Write(target, index, target.lattice.control_points[index] + moves.offsets[n], targets);
  }
  target.drag_residual = std::max(target.drag_residual, moves.residual);
  target.named.clear();  // the moves are images already, also where the points are not
  return status;
}

absl::Status Apply(const SetStrength& edit, std::string_view field, EditTarget& target) {
  LATTICED_RETURN_IF_ERROR(
      CheckStrength(edit.strength, fmt::format("{}.set_strength.strength", field)));
  target.strength = edit.strength;
  target.strength_written = true;
  return absl::OkStatus();
}

absl::Status Apply(const Reset& edit, absl::FunctionRef<Lattice()> initial, std::string_view field,
                   EditTarget& target) {
  const std::string path = fmt::format("{}.reset", field);
  if (edit.to == ResetTo::kIdentity) {
    return WriteAll(IdentityControlPoints(target.lattice.structure), path, target);
  }
  LATTICED_ASSIGN_OR_RETURN(auto refined, WithKnotsOf(initial(), target.lattice.structure));
  return WriteAll(refined.control_points, path, target);
}

absl::Status ApplyFreely(const Edit& edit, absl::FunctionRef<Lattice()> initial,
                         std::string_view field, EditTarget& target) {
  return std::visit(
      [&](const auto& e) -> absl::Status {
        using T = std::decay_t<decltype(e)>;
        if constexpr (std::is_same_v<T, InsertKnot>) {
          return NotAlone(fmt::format("{}.insert_knot", field));
        } else if constexpr (std::is_same_v<T, ReplaceLattice>) {
          return NotAlone(fmt::format("{}.replace_lattice", field));
        } else if constexpr (std::is_same_v<T, SetConstraints>) {
          return NotAlone(fmt::format("{}.set_constraints", field));
        } else if constexpr (std::is_same_v<T, SetWeights>) {
          return NotAlone(fmt::format("{}.set_weights", field));
        } else if constexpr (std::is_same_v<T, RemoveLattice>) {
          return NotAlone(fmt::format("{}.remove_lattice", field));
        } else if constexpr (std::is_same_v<T, Undo>) {
          return NotAlone(fmt::format("{}.undo", field));
        } else if constexpr (std::is_same_v<T, Redo>) {
          return NotAlone(fmt::format("{}.redo", field));
        } else if constexpr (std::is_same_v<T, Reset>) {
          return Apply(e, initial, field, target);
        } else {
          return Apply(e, field, target);
        }
      },
      edit);
}

}  // namespace

EditTarget::EditTarget(Lattice start, double with_strength)
    : lattice(std::move(start)), strength(with_strength), written(lattice.control_points.size()) {}

absl::Status CheckStrength(double strength, std::string_view field) {
  if (!std::isfinite(strength)) return error::NotFinite(field);
  return error::CheckRange(field, strength, 0, 1);
}

absl::Status ApplyEdit(const Edit& edit, absl::FunctionRef<Lattice()> initial,
                       std::string_view field, EditTarget& target) {
  target.named.clear();
  LATTICED_RETURN_IF_ERROR(ApplyFreely(edit, initial, field, target));
  if (target.freedom == nullptr || !target.freedom->is_mirrored()) return absl::OkStatus();
  auto& points = target.lattice.control_points;
  for (const uint32_t index : target.freedom->Symmetrise(target.named, points)) {
    LATTICED_RETURN_IF_ERROR(CheckControlPoint(points[index], field));
    target.written[index] = true;
  }
  return absl::OkStatus();
}

absl::StatusOr<StructureChange> ChangeStructure(const Lattice& lattice, const StructureEdit& edit,
                                                std::string_view field, const AdmitStructure& admit,
                                                std::optional<int> mirror) {
  if (const auto* insert = std::get_if<InsertKnot>(&edit); insert != nullptr) {
    LATTICED_ASSIGN_OR_RETURN(auto refined,
                              WithKnotInserted(lattice, insert->axis, insert->value, field));
    if (const auto image = MirroredKnot(lattice.structure, insert->axis, insert->value);
        mirror == insert->axis && image.has_value()) {
      LATTICED_ASSIGN_OR_RETURN(refined, WithKnotInserted(refined, insert->axis, *image, field));
    }
    LATTICED_RETURN_IF_ERROR(admit(refined.structure));
    return StructureChange{std::move(refined)};
  }
  const auto& [wanted, keep_shape] = std::get<ReplaceLattice>(edit);
  if (keep_shape && wanted.structure.frame != lattice.structure.frame) {
    return error::InvalidField(fmt::format("{}.lattice.frame", field),
                               "must be the scene's to keep the shape");
  }
  LATTICED_RETURN_IF_ERROR(admit(wanted.structure));
  if (!keep_shape) return StructureChange{wanted};
  if (HaveSameNet(lattice.structure, wanted.structure)) {
    return StructureChange{{wanted.structure, lattice.control_points}};
  }
  LatticeRefit refit = Refit(lattice, wanted.structure);
  if (!Validate(refit.lattice).ok()) {
    return error::InvalidField(fmt::format("{}.lattice", field),
                               "cannot keep the shape: its knots lie too close together");
  }
  return StructureChange{std::move(refit.lattice), refit.residual};
}

}  // namespace latticed
