// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <ostream>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/latticectl/commands.h"
#include "client/cpp/latticectl/json_output.h"
#include "client/cpp/latticectl/lattice_json.h"
#include "client/cpp/latticectl/ray_flags.h"
#include "client/cpp/latticectl/session.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

struct EditFlags {
  SessionFlags session;
  std::string scene, editor, axis = "u", target = "identity", scope = "scene";
  std::vector<std::string> points;  // "i,j,k"
  std::vector<double> vector;       // of --by or --to
  std::vector<double> by;           // of drag, in place of --to
  std::vector<double> ray, at;      // what drag takes hold of
  double knot = 0;
  bool json = false;
};

using EditMaker = absl::Status (*)(const EditFlags&, const v1::LatticeState&, Session&, v1::Edit*);

// The same from call to call, so that redo finds what undo did: made of user and host.
std::string StableEditorId() {
  char host[256] = "";
  (void)gethostname(host, sizeof(host) - 1);
  std::string hex = Sha256Hex(fmt::format("latticectl {} {}", getuid(), host));
  hex[12] = '4';  // in the form of a random UUID
  hex[16] = '8';
  return fmt::format("{}-{}-{}-{}-{}", hex.substr(0, 8), hex.substr(8, 4), hex.substr(12, 4),
                     hex.substr(16, 4), hex.substr(20, 12));
}

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

absl::Status MakeMove(const EditFlags& flags, const v1::LatticeState& state, Session&,
                      v1::Edit* edit) {
  auto* move = edit->mutable_move_control_points();
  move->mutable_offset()->set_x(flags.vector[0]);
  move->mutable_offset()->set_y(flags.vector[1]);
  move->mutable_offset()->set_z(flags.vector[2]);
  return AppendIndices(flags, state, move->mutable_indices());
}

absl::Status MakeSet(const EditFlags& flags, const v1::LatticeState& state, Session&,
                     v1::Edit* edit) {
  auto* set = edit->mutable_set_control_points();
  for (size_t i = 0; i < flags.points.size(); ++i) {
    for (const double value : flags.vector) set->add_positions(value);
  }
  return AppendIndices(flags, state, set->mutable_indices());
}

// What was picked, or named: FACE, three corners, three barycentrics.
absl::StatusOr<v1::SurfacePoint> HoldOf(const EditFlags& flags, Session& session) {
  if (!flags.ray.empty()) {
    const auto point = session.client().Pick(PickRequestOf(flags.scene, flags.ray));
    if (!point.ok()) return session.Explain(point.status());
    return point;
  }
  v1::SurfacePoint point;
  for (size_t i = 0; i < 4; ++i) {
    const double number = flags.at[i];
    if (!(number >= 0 && number <= std::numeric_limits<uint32_t>::max()) ||
        number != std::floor(number)) {
      return absl::InvalidArgumentError(
          fmt::format("--at: {} is no face or corner, which are counted from 0", number));
    }
    const auto index = static_cast<uint32_t>(number);
    i == 0 ? point.set_face(index) : point.add_corners(index);
  }
  for (size_t i = 4; i < 7; ++i) point.add_barycentrics(flags.at[i]);
  return point;
}

absl::StatusOr<v1::Vec3> DeformedPosition(const EditFlags& flags, const v1::SurfacePoint& point,
                                          Session& session) {
  if (point.has_position()) return point.position();
  v1::EvaluatePointsRequest request;
  request.set_scene(flags.scene);
  *request.mutable_surface_points()->add_points() = point;
  const auto evaluated = session.client().EvaluatePoints(request);
  if (!evaluated.ok()) return session.Explain(evaluated.status());
  v1::Vec3 position;
  position.set_x(evaluated->positions(0));
  position.set_y(evaluated->positions(1));
  position.set_z(evaluated->positions(2));
  return position;
}

absl::Status MakeDrag(const EditFlags& flags, const v1::LatticeState&, Session& session,
                      v1::Edit* edit) {
  LATTICED_ASSIGN_OR_RETURN(const auto point, HoldOf(flags, session));
  v1::DragPoints& drag = *edit->mutable_drag_points();
  *drag.add_points() = point;
  drag.mutable_targets()->Add(flags.vector.begin(), flags.vector.end());
  if (flags.by.empty()) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(const auto position, DeformedPosition(flags, point, session));
  drag.add_targets(position.x() + flags.by[0]);
  drag.add_targets(position.y() + flags.by[1]);
  drag.add_targets(position.z() + flags.by[2]);
  return absl::OkStatus();
}

absl::Status MakeInsertKnot(const EditFlags& flags, const v1::LatticeState&, Session&,
                            v1::Edit* edit) {
  edit->mutable_insert_knot()->set_axis(flags.axis == "u"   ? v1::LATTICE_AXIS_U
                                        : flags.axis == "v" ? v1::LATTICE_AXIS_V
                                                            : v1::LATTICE_AXIS_W);
  edit->mutable_insert_knot()->set_value(flags.knot);
  return absl::OkStatus();
}

absl::Status MakeReset(const EditFlags& flags, const v1::LatticeState&, Session&, v1::Edit* edit) {
  edit->mutable_reset()->set_target(flags.target == "initial" ? v1::RESET_TARGET_INITIAL
                                                              : v1::RESET_TARGET_IDENTITY);
  return absl::OkStatus();
}

absl::Status MakeUndo(const EditFlags& flags, const v1::LatticeState&, Session&, v1::Edit* edit) {
  edit->mutable_undo()->set_scope(flags.scope == "mine" ? v1::UNDO_SCOPE_MINE
                                                        : v1::UNDO_SCOPE_SCENE);
  return absl::OkStatus();
}

absl::Status MakeRedo(const EditFlags&, const v1::LatticeState&, Session&, v1::Edit* edit) {
  edit->mutable_redo();
  return absl::OkStatus();
}

absl::Status Run(const EditFlags& flags, EditMaker make, Console console) {
  LATTICED_ASSIGN_OR_RETURN(auto session, Session::Open(flags.session));
  const auto lattice = session.client().GetLattice(flags.scene);
  if (!lattice.ok()) return session.Explain(lattice.status());
  v1::EditBatch batch;
  batch.set_scene(flags.scene);
  batch.set_editor_id(flags.editor.empty() ? StableEditorId() : flags.editor);
  // Rises from call to call, also for an editor that is used again.
  batch.set_sequence(static_cast<uint64_t>(absl::ToUnixMicros(absl::Now())));
  batch.set_structure_id(lattice->structure_id());
  LATTICED_RETURN_IF_ERROR(make(flags, *lattice, session, batch.add_edits()));
  const auto result = session.client().ApplyEdits(batch);
  if (!result.ok()) return session.Explain(result.status());
  if (flags.json) {
    console.out << MessageJson(*result);
  } else {
    console.out << fmt::format(
        "revision {}: {} patches in {} knot boxes changed, largest move {}\n", result->revision(),
        result->patches_touched(), result->boxes_touched(), result->largest_move());
    if (batch.edits(0).has_drag_points()) {
      console.out << fmt::format("left to the target: {}\n", result->drag_residual());
    }
  }
  return absl::OkStatus();
}

void AddDragOptions(CLI::App& command, EditFlags& flags) {
  auto* hold = command.add_option_group("what", "The point: one of these");
  AddRayFlag(*hold, flags.ray);
  hold->add_option(
          "--at", flags.at,
          "Point FACE,CORNER,CORNER,CORNER,B,B,B of the mesh, as 'latticectl pick' says it")
      ->delimiter(',')
      ->expected(7);
  hold->require_option(1);
  auto* target = command.add_option_group("where", "Where it goes: one of these");
  target->add_option("--to", flags.vector, "Position X,Y,Z in the world")
      ->delimiter(',')
      ->expected(3);
  target->add_option("--by", flags.by, "Offset X,Y,Z in world units")->delimiter(',')->expected(3);
  target->require_option(1);
}

}  // namespace

void AddEditCommands(CLI::App& app, CommandLine& line) {
  auto flags = std::make_shared<EditFlags>();
  CLI::App* edit = app.add_subcommand("edit", "Edits the lattice of a scene");
  edit->require_subcommand(1);
  const auto add = [&](const char* name, const char* what, EditMaker make) {
    CLI::App* command = edit->add_subcommand(name, what);
    command->add_option("scene", flags->scene, "Id of the scene")->required();
    command->add_option("--editor", flags->editor,
                        "UUID of the editor; by default one of this user and host");
    AddSessionFlags(*command, flags->session, ServerChoice::kRequired);
    AddJsonFlag(*command, flags->json);
    command->callback([flags, make, &line] {
      line.action = [=, &line] { return Run(*flags, make, line.console); };
    });
    return command;
  };
  const auto add_points = [&](CLI::App* command, const char* vector_flag, const char* what) {
    command->add_option("--point", flags->points, "Control point I,J,K; may be repeated")
        ->required()
        ->take_all()
        ->check(CheckAxes);
    command->add_option(vector_flag, flags->vector, what)->required()->delimiter(',')->expected(3);
  };
  add_points(add("move", "Moves control points", MakeMove), "--by", "Offset X,Y,Z in world units");
  add_points(add("set", "Puts control points somewhere", MakeSet), "--to", "Position X,Y,Z");
  AddDragOptions(
      *add("drag", "Moves control points so that a point of the surface goes somewhere", MakeDrag),
      *flags);
  CLI::App* insert =
      add("insert-knot", "Refines the lattice without a change of shape", MakeInsertKnot);
  insert->add_option("axis", flags->axis, "Axis")
      ->required()
      ->check(CLI::IsMember({"u", "v", "w"}));
  insert->add_option("value", flags->knot, "The knot, inside the domain")->required();
  add("reset", "Puts all control points back", MakeReset)
      ->add_option("--to", flags->target, "Where to")
      ->check(CLI::IsMember({"identity", "initial"}));
  add("undo", "Reverts the last step", MakeUndo)
      ->add_option("--scope", flags->scope, "Whose: this editor's, or anybody's")
      ->check(CLI::IsMember({"mine", "scene"}));
  add("redo", "Applies the step again that was undone last", MakeRedo);
}

}  // namespace latticed::client
