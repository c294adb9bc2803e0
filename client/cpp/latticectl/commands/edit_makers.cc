// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/commands/edit_makers.h"

#include <cmath>
#include <limits>

#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/ray_flag.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/geometry/outside_text.h"
#include "client/cpp/latticectl/geometry/weights_source.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

absl::Status AppendIndices(const EditFlags& flags, const v1::LatticeState& state,
                           google::protobuf::RepeatedField<uint32_t>* indices) {
  const v1::LatticeAxes& size = state.lattice().size();
  for (const std::string& point : flags.points) {
    const auto [i, j, k] = ParseAxes(point);
    if (i < 0 || i >= size.u() || j < 0 || j >= size.v() || k < 0 || k >= size.w()) {
      return absl::InvalidArgumentError(
          fmt::format("--point {}: the lattice has {} x {} x {} control points, counted from 0,0,0",
                      point, size.u(), size.v(), size.w()));
    }
    indices->Add(static_cast<uint32_t>(i + size.u() * (j + size.v() * k)));
  }
  return absl::OkStatus();
}

// The point that --ray picks, or that --at gives as FACE, three corners, three barycentrics.
absl::StatusOr<v1::SurfacePoint> HeldPoint(const EditFlags& flags, Client& client) {
  if (!flags.ray.empty()) return client.Pick(PickRequestOf(flags.scene, flags.ray));
  v1::SurfacePoint point;
  for (size_t i = 0; i < 4; ++i) {
    const double number = flags.at[i];
    if (!(number >= 0 && number <= std::numeric_limits<uint32_t>::max()) ||
        number != std::floor(number)) {
      return absl::InvalidArgumentError(fmt::format(
          "--at: {} is not the index of a face or corner (whole numbers from 0)", number));
    }
    const auto index = static_cast<uint32_t>(number);
    i == 0 ? point.set_face(index) : point.add_corners(index);
  }
  for (size_t i = 4; i < 7; ++i) point.add_barycentrics(flags.at[i]);
  return point;
}

absl::StatusOr<Vec3d> DeformedPosition(const EditFlags& flags, const v1::SurfacePoint& point,
                                       Client& client) {
  if (point.has_position()) {
    return Vec3d{point.position().x(), point.position().y(), point.position().z()};
  }
  v1::EvaluatePointsRequest request;
  request.set_scene(flags.scene);
  *request.mutable_surface_points()->add_points() = point;
  LATTICED_ASSIGN_OR_RETURN(const auto evaluated, client.EvaluatePoints(request));
  return Vec3d{evaluated.positions(0), evaluated.positions(1), evaluated.positions(2)};
}

}  // namespace

absl::Status MakeMove(const EditFlags& flags, const v1::LatticeState& state, Client&,
                      v1::Edit& edit) {
  auto& move = *edit.mutable_move_control_points();
  *move.mutable_offset() = ToProto(Vec3d{flags.vector[0], flags.vector[1], flags.vector[2]});
  return AppendIndices(flags, state, move.mutable_indices());
}

absl::Status MakeSet(const EditFlags& flags, const v1::LatticeState& state, Client&,
                     v1::Edit& edit) {
  auto& set = *edit.mutable_set_control_points();
  for (size_t i = 0; i < flags.points.size(); ++i) {
    set.mutable_positions()->Add(flags.vector.begin(), flags.vector.end());
  }
  return AppendIndices(flags, state, set.mutable_indices());
}

absl::Status MakeDrag(const EditFlags& flags, const v1::LatticeState&, Client& client,
                      v1::Edit& edit) {
  LATTICED_ASSIGN_OR_RETURN(const auto point, HeldPoint(flags, client));
  v1::DragPoints& drag = *edit.mutable_drag_points();
  *drag.add_points() = point;
  drag.mutable_targets()->Add(flags.vector.begin(), flags.vector.end());
  if (flags.by.empty()) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(const auto position, DeformedPosition(flags, point, client));
  for (int axis = 0; axis < 3; ++axis) {
    drag.add_targets(position[axis] + flags.by[static_cast<size_t>(axis)]);
  }
  return absl::OkStatus();
}

absl::Status MakeConstrain(const EditFlags& flags, const v1::LatticeState& state, Client&,
                           v1::Edit& edit) {
  v1::Constraints& constraints = *edit.mutable_set_constraints()->mutable_constraints();
  if (!flags.points.empty()) {
    LATTICED_RETURN_IF_ERROR(AppendIndices(flags, state, constraints.mutable_held()));
  }
  for (const std::string& face : flags.layers) {  // checked: an axis, a sign, a digit
    v1::HeldLayers& held = *constraints.add_held_layers();
    held.set_axis(static_cast<v1::LatticeAxis>(v1::LATTICE_AXIS_U + (face[0] - 'u')));
    held.set_at_end(face[1] == '+');
    held.set_layers(face[2] - '0');
  }
  constraints.set_mirror(flags.mirror);
  const bool has_axis = flags.volume_axis != v1::LATTICE_AXIS_UNSPECIFIED;
  if (!flags.keep_volume && !flags.volume.has_value() && !has_axis) return absl::OkStatus();
  constraints.mutable_volume()->set_axis(flags.volume_axis);
  if (flags.volume.has_value()) constraints.mutable_volume()->set_volume(*flags.volume);
  return absl::OkStatus();
}

absl::Status MakeCarry(const EditFlags& flags, const v1::LatticeState& state, Client&,
                       v1::Edit& edit) {
  v1::CarryControlPoints& carry = *edit.mutable_carry_control_points();
  LATTICED_ASSIGN_OR_RETURN(*carry.mutable_parent(), ReadLattice(flags.lattice));
  return AppendIndices(flags, state, carry.mutable_indices());
}

absl::Status MakeReplace(const EditFlags& flags, const v1::LatticeState&, Client&, v1::Edit& edit) {
  v1::ReplaceLattice& replace = *edit.mutable_replace_lattice();
  LATTICED_ASSIGN_OR_RETURN(*replace.mutable_lattice(), ReadLattice(flags.lattice));
  replace.set_keep_shape(flags.keep_shape);
  if (flags.keep_shape) replace.mutable_lattice()->clear_control_points();
  return absl::OkStatus();
}

// Sets the axes given as text, and drops the knots of those that change.
absl::Status MakeResize(const EditFlags& flags, const v1::LatticeState& state, Client&,
                        v1::Edit& edit) {
  if (flags.size.empty() && flags.degree.empty()) {
    return absl::InvalidArgumentError("--size or --degree is needed");
  }
  v1::ReplaceLattice& replace = *edit.mutable_replace_lattice();
  replace.set_keep_shape(true);
  const v1::Lattice& present = state.lattice();
  v1::Lattice& lattice = *replace.mutable_lattice();
  lattice = present;
  lattice.clear_control_points();
  const auto set = [](const std::string& text, v1::LatticeAxes& axes) {
    if (text.empty()) return;
    const auto [u, v, w] = ParseAxes(text);
    axes.set_u(u);
    axes.set_v(v);
    axes.set_w(w);
  };
  set(flags.size, *lattice.mutable_size());
  set(flags.degree, *lattice.mutable_degree());
  const auto differs = [&](auto axis) {
    return (lattice.size().*axis)() != (present.size().*axis)() ||
           (lattice.degree().*axis)() != (present.degree().*axis)();
  };
  if (differs(&v1::LatticeAxes::u)) lattice.clear_knots_u();
  if (differs(&v1::LatticeAxes::v)) lattice.clear_knots_v();
  if (differs(&v1::LatticeAxes::w)) lattice.clear_knots_w();
  return absl::OkStatus();
}

// The scene's own lattice, with another continuation. Whoever edits meanwhile makes the server refuse it.
absl::Status MakeOutside(const EditFlags& flags, const v1::LatticeState& state, Client&,
                         v1::Edit& edit) {
  v1::Lattice& lattice = *edit.mutable_replace_lattice()->mutable_lattice();
  lattice = state.lattice();
  LATTICED_ASSIGN_OR_RETURN(*lattice.mutable_outside(), ParseOutside(flags.outside));
  return absl::OkStatus();
}

absl::Status MakeWeights(const EditFlags& flags, const v1::LatticeState&, Client&, v1::Edit& edit) {
  v1::SetWeights& set = *edit.mutable_set_weights();
  if (flags.weights == kNoWeights) {
    set.set_clear(true);
    return absl::OkStatus();
  }
  if (flags.weights == kWeightsOfMesh) {
    return absl::InvalidArgumentError(
        "weights: those of the mesh's file are taken when a scene is made ('scene create "
        "--weights attribute'); here name a .npy or .csv file, or none");
  }
  LATTICED_ASSIGN_OR_RETURN(*set.mutable_values(), ReadWeights(flags.weights));
  return absl::OkStatus();
}

}  // namespace latticed::client
