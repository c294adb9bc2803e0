// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <ostream>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/latticectl/command_line/failure.h"
#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/command_line/value_types.h"
#include "client/cpp/latticectl/commands/commands.h"
#include "client/cpp/latticectl/commands/edit_makers.h"
#include "client/cpp/latticectl/commands/folds_line.h"
#include "client/cpp/latticectl/commands/held_points.h"
#include "client/cpp/latticectl/commands/ray_flag.h"
#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "client/cpp/latticectl/geometry/outside_text.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/session.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr NamedValues<v1::LatticeAxis, 3> kAxes{
    {{"u", v1::LATTICE_AXIS_U}, {"v", v1::LATTICE_AXIS_V}, {"w", v1::LATTICE_AXIS_W}}};
constexpr NamedValues<v1::ResetTarget, 2> kTargets{
    {{"identity", v1::RESET_TARGET_IDENTITY}, {"initial", v1::RESET_TARGET_INITIAL}}};
constexpr NamedValues<v1::UndoScope, 2> kScopes{
    {{"mine", v1::UNDO_SCOPE_MINE}, {"scene", v1::UNDO_SCOPE_SCENE}}};
// Derived from user and host. All calls of a user are one editor, so redo finds an earlier call's undo.
std::string StableEditorId() {
  char host[256] = "";
  (void)gethostname(host, sizeof(host) - 1);
  std::string hex = Sha256Hex(fmt::format("latticectl {} {}", getuid(), host));
  hex[12] = '4';  // in the form of a random UUID
  hex[16] = '8';
  return fmt::format("{}-{}-{}-{}-{}", hex.substr(0, 8), hex.substr(8, 4), hex.substr(12, 4),
                     hex.substr(16, 4), hex.substr(20, 12));
}

// For edits that depend only on flags.
EditMaker FromFlags(void (*fill)(const EditFlags&, v1::Edit&)) {
  return [fill](const EditFlags& flags, const v1::LatticeState&, Client&, v1::Edit& edit) {
    fill(flags, edit);
    return absl::OkStatus();
  };
}

// The lowest number that no lattice has.
uint32_t FreeNumber(const v1::Scene& scene) {
  uint32_t number = 0;
  for (const auto& lattice : scene.lattices()) {
    if (lattice.index() == number) ++number;
  }
  return number;
}

// What an edit begins with. One that may be of a lattice that was removed, or of one that is to be, knows the structure alone.
absl::StatusOr<v1::LatticeState> EditedLattice(const EditFlags& flags, bool needs_lattice,
                                               Client& client, v1::EditBatch& batch) {
  batch.set_lattice(flags.lattice_number);
  if (needs_lattice && !flags.adds) {
    return client.GetLattice(flags.scene, flags.lattice_number);
  }
  LATTICED_ASSIGN_OR_RETURN(const auto scene, client.GetScene(flags.scene));
  if (flags.adds) batch.set_lattice(FreeNumber(scene));
  v1::LatticeState state;
  state.set_structure_id(scene.structure_id());
  return state;
}

// Each lattice has undo steps of its own, also a removed one: a refusal names the lattice that was meant.
absl::Status ExplainSteps(const absl::Status& status, const v1::EditBatch& batch) {
  error::Details details = error::DetailsOf(status);
  if (details.reason != "NOTHING_TO_UNDO" && details.reason != "NOTHING_TO_REDO") return status;
  const bool of_scene = batch.edits(0).undo().scope() == v1::UNDO_SCOPE_SCENE;
  const std::string message =
      fmt::format("lattice {} has no {}", batch.lattice(),
                  details.reason == "NOTHING_TO_REDO" ? "step left that this editor has undone"
                  : of_scene                          ? "step left to undo"
                                                      : "step of this editor left to undo");
  details.metadata[kAdviceKey] =
      "other lattices, also removed ones, have steps of their own: --lattice-number";
  return error::WithDetails(absl::Status(status.code(), message), details);
}

// What the numbers of a result do not say.
std::string NotesOn(const v1::EditBatch& batch, const EditFlags& flags,
                    const v1::LatticeState& before, const v1::EditResult& result) {
  const v1::Edit& edit = batch.edits(0);
  std::string text = HeldLine(edit, before);
  if (edit.has_drag_points()) {
    text += fmt::format("distance left to the target: {}\n", result.drag_residual());
  }
  if (edit.replace_lattice().keep_shape()) {
    text += fmt::format("the shape changed by about {}\n", result.drag_residual());
  }
  if (flags.adds) {
    text += fmt::format("it is lattice {0}: edits, undo too, name it by --lattice-number {0}\n",
                        batch.lattice());
  }
  if (edit.has_remove_lattice()) {
    text += fmt::format("'latticectl edit undo {} --lattice-number {}' gives it back\n",
                        batch.scene(), batch.lattice());
  }
  return result.has_folds() ? text + FoldsLine(result.folds()) : text;
}

absl::Status Run(const EditFlags& flags, const EditMaker& make, bool needs_lattice, Client& client,
                 Console console) {
  v1::EditBatch batch;
  batch.set_scene(flags.scene);
  batch.set_editor_id(flags.editor.empty() ? StableEditorId() : flags.editor);
  // An editor's sequences must rise from one call of this program to the next; the clock does.
  batch.set_sequence(static_cast<uint64_t>(absl::ToUnixMicros(absl::Now())));
  LATTICED_ASSIGN_OR_RETURN(const auto lattice, EditedLattice(flags, needs_lattice, client, batch));
  batch.set_structure_id(lattice.structure_id());
  batch.set_refuse_folds(flags.refuse_folds);
  if (flags.batch_keeps_volume) batch.mutable_keep_volume();
  LATTICED_RETURN_IF_ERROR(make(flags, lattice, client, *batch.add_edits()));
  if (!flags.outside.empty()) batch.set_expected_revision(lattice.revision());
  const auto applied = client.ApplyEdits(batch);
  if (!applied.ok()) return ExplainSteps(applied.status(), batch);
  const v1::EditResult& result = *applied;
  std::string text = fmt::format(
      "revision {}: {} patches in {} knot boxes changed, largest move {}\n", result.revision(),
      result.patches_touched(), result.boxes_touched(), result.largest_move());
  text += NotesOn(batch, flags, lattice, result);
  PrintResult(flags.json, result, text, console.out);
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
  edit->require_subcommand(0, 1);
  const auto add = [&](const char* name, const char* what, const char* example,
                       const EditMaker& make, bool needs_lattice = true) {
    CLI::App* command = edit->add_subcommand(name, what);
    SetExample(*command, example);
    command->add_option("scene", flags->scene, "Id of the scene")->required();
    command->add_option("--editor", flags->editor,
                        "UUID of the editor; by default one of this user and host");
    command->add_option("--lattice-number", flags->lattice_number,
                        "Which of the scene's lattices, from 0");
    command->add_flag("--refuse-folds", flags->refuse_folds,
                      "Fails if the edit makes a new fold near the surface");
    SetServerAction(*command, flags, line,
                    [=](const EditFlags& from, Client& client, Console console) {
                      return Run(from, make, needs_lattice, client, console);
                    });
    return command;
  };
  const auto may_keep_volume = [&](CLI::App* command) {
    command->add_flag("--keep-volume", flags->batch_keeps_volume,
                      "Moves other control points too, so that the surface encloses the volume "
                      "that it has at rest; of this edit alone ('edit constrain': of all)");
    return command;
  };
  const auto add_points = [&](CLI::App* command, const char* vector_flag, const char* what) {
    command->add_option("--point", flags->points, "Control point I,J,K; may be repeated")
        ->required()
        ->take_all()
        ->check(CheckAxes);
    command->add_option(vector_flag, flags->vector, what)->required()->delimiter(',')->expected(3);
  };
  add_points(may_keep_volume(add("move", "Moves control points",
                                 "edit move my-scene --point 1,1,3 --by 0,0,0.5", MakeMove)),
             "--by", "Offset X,Y,Z in world units");
  add_points(may_keep_volume(add("set", "Puts control points somewhere",
                                 "edit set my-scene --point 0,0,0 --to -1,-1,-2", MakeSet)),
             "--to", "Position X,Y,Z");
  CLI::App* carry = may_keep_volume(
      add("carry", "Moves control points as a parent lattice moves the world at their places",
          "edit carry my-scene --lattice parent.json", MakeCarry));
  carry->add_option("--lattice", flags->lattice, "JSON file of the parent, deformed")
      ->required()
      ->type_name(kFileType);
  carry
      ->add_option("--point", flags->points, "Control point I,J,K; may be repeated; by default all")
      ->take_all()
      ->check(CheckAxes);
  AddDragOptions(*may_keep_volume(add(
                     "drag", "Moves control points so that a point of the surface goes somewhere",
                     "edit drag my-scene --ray 0,0,5,0,0,-1 --by 0,0,0.2", MakeDrag)),
                 *flags);
  CLI::App* insert =
      add("insert-knot", "Refines the lattice without a change of shape",
          "edit insert-knot my-scene u 0.5", FromFlags([](const EditFlags& from, v1::Edit& to) {
            to.mutable_insert_knot()->set_axis(from.axis);
            to.mutable_insert_knot()->set_value(from.knot);
          }));
  AddNamedOption<v1::LatticeAxis>(
      *insert, "axis", kAxes, [flags = flags.get()](auto axis) { flags->axis = axis; }, "Axis")
      ->required();
  insert->add_option("value", flags->knot, "The knot, inside the domain")->required();
  CLI::App* resize =
      add("resize", "Changes size or degree, and keeps the shape as well as the lattice can",
          "edit resize my-scene --size 6,6,6 --degree 3,3,3", MakeResize);
  resize->add_option("--size", flags->size, "Control points per axis; by default as many as now")
      ->check(CheckAxes);
  resize->add_option("--degree", flags->degree, "Degree per axis, 1 to 3; by default as now")
      ->check(CheckAxes);
  CLI::App* replace = add("replace", "Gives the scene another lattice",
                          "edit replace my-scene --lattice L.json", MakeReplace);
  replace->add_option("--lattice", flags->lattice, "JSON file of the lattice")
      ->required()
      ->type_name(kFileType);
  CLI::Option* keep = replace->add_flag(
      "--keep-shape", flags->keep_shape,
      "Fits the control points to the present shape; the frame must be the scene's");
  replace
      ->add_flag("--add", flags->adds,
                 "Adds it to the scene's lattices instead; what all of them move the mesh adds up")
      ->excludes(keep)
      ->excludes(replace->get_option("--lattice-number"));
  add("remove-lattice",
      "Takes a lattice of several away; undo with the same --lattice-number gives it back",
      "edit remove-lattice my-scene --lattice-number 1",
      FromFlags([](const EditFlags&, v1::Edit& to) { to.mutable_remove_lattice(); }))
      ->get_option("--lattice-number")
      ->required();
  add("outside", "Changes what goes on outside the lattice, and nothing inside",
      "edit outside my-scene falloff:0.3", MakeOutside)
      ->add_option("outside", flags->outside, kOutsideHelp)
      ->required()
      ->check(CheckOutside);
  CLI::App* reset = add("reset", "Puts all control points back", "edit reset my-scene --to initial",
                        FromFlags([](const EditFlags& from, v1::Edit& to) {
                          to.mutable_reset()->set_target(from.target);
                        }));
  may_keep_volume(reset);
  AddNamedOption<v1::ResetTarget>(
      *reset, "--to", kTargets, [flags = flags.get()](auto target) { flags->target = target; },
      "Where to")
      ->default_str("identity");
  CLI::App* constrain =
      add("constrain", "Sets what later edits must keep, in place of what they kept",
          "edit constrain my-scene --keep-volume --layers u-2", MakeConstrain);
  constrain->add_option("--point", flags->points,
                        "Hold the control point i,j,k; may be given often");
  constrain
      ->add_option("--layers", flags->layers,
                   "Hold 1 to 3 layers at a face: u-2 where u begins, w+1 where w ends")
      ->check(CLI::Validator(
          [](std::string& face) {
            const bool known = face.size() == 3 && face[0] >= 'u' && face[0] <= 'w' &&
                               (face[1] == '-' || face[1] == '+') && face[2] >= '1' &&
                               face[2] <= '3';
            return known ? std::string() : "'" + face + "' is not an axis, - or +, and 1 to 3";
          },
          "FACE"));
  AddNamedOption<v1::LatticeAxis>(
      *constrain, "--mirror", kAxes, [flags = flags.get()](auto axis) { flags->mirror = axis; },
      "Control points move as mirror images on this axis");
  constrain->add_flag("--keep-volume", flags->keep_volume, "Keep the volume of the mesh at rest");
  constrain->add_option("--volume", flags->volume, "Keep this volume instead");
  AddNamedOption<v1::LatticeAxis>(
      *constrain, "--volume-axis", kAxes,
      [flags = flags.get()](auto axis) { flags->volume_axis = axis; },
      "Keep it by moves along this axis only");
  may_keep_volume(add("strength", "Sets how much of the deformation the scene takes",
                      "edit strength my-scene 0.5",
                      FromFlags([](const EditFlags& from, v1::Edit& to) {
                        to.mutable_set_strength()->set_strength(from.strength);
                      })))
      ->add_option("strength", flags->strength, "0, at rest, to 1, all of it")
      ->required();
  may_keep_volume(add("weights", "Sets how much of the deformation each vertex takes",
                      "edit weights my-scene weights.csv", MakeWeights, false))
      ->add_option("weights", flags->weights,
                   ".npy or .csv file with a number from 0 to 1 for each vertex; none: all follow. "
                   "Those of the mesh's file are taken by 'scene create --weights attribute'")
      ->required()
      ->type_name(kFileType);
  CLI::App* undo = add(
      "undo",
      "Reverts the last step of one lattice: of 0, or of --lattice-number. Each has "
      "steps of its own, also a removed one",
      "edit undo my-scene --lattice-number 1", FromFlags([](const EditFlags& from, v1::Edit& to) {
        to.mutable_undo()->set_scope(from.scope);
      }),
      false);
  AddNamedOption<v1::UndoScope>(
      *undo, "--scope", kScopes, [flags = flags.get()](auto scope) { flags->scope = scope; },
      "Whose: this editor's, or anybody's")
      ->default_str("scene");
  add("redo", "Applies the step again that was undone last, of one lattice as undo",
      "edit redo my-scene", FromFlags([](const EditFlags&, v1::Edit& to) { to.mutable_redo(); }),
      false);
}

}  // namespace latticed::client
