// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes the edits of `latticectl edit` from its flags.
//
// Errors   kInvalidArgument, those of files.h, and of calls
// Threads  pure functions but for calls
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_EDIT_MAKERS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_EDIT_MAKERS_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cpp/latticectl/session/session.h"
#include "latticed/v1/edit.pb.h"

namespace latticed::client {

struct EditFlags : ServerFlags {
  std::string scene, editor;
  std::vector<std::string> points;    // "i,j,k"
  std::vector<double> vector;         // --by of move, --to of set and drag
  std::vector<double> by;             // --by of drag, instead of --to
  std::vector<double> ray, at;        // drag moves this point; one of the two is set
  std::string lattice, size, degree;  // of replace; of resize, "u,v,w"
  std::string outside;                // of outside
  bool keep_shape = false, refuse_folds = false;
  bool adds = false;                // replace adds the lattice
  bool batch_keeps_volume = false;  // this edit, whatever the constraints say
  uint32_t lattice_number = 0;
  double knot = 0;
  v1::LatticeAxis axis = v1::LATTICE_AXIS_U;
  v1::ResetTarget target = v1::RESET_TARGET_IDENTITY;
  v1::UndoScope scope = v1::UNDO_SCOPE_SCENE;
  std::vector<std::string> layers;  // of constrain: "u+2"
  v1::LatticeAxis mirror = v1::LATTICE_AXIS_UNSPECIFIED;
  v1::LatticeAxis volume_axis = v1::LATTICE_AXIS_UNSPECIFIED;
  bool keep_volume = false;
  std::optional<double> volume;
  double strength = 1;
  std::string weights;  // a file, or kNoWeights
};

inline constexpr char kNoWeights[] = "none";

using EditMaker =
    std::function<absl::Status(const EditFlags&, const v1::LatticeState&, Client&, v1::Edit&)>;

[[nodiscard]] absl::Status MakeMove(const EditFlags& flags, const v1::LatticeState& state,
                                    Client& client, v1::Edit& edit);
[[nodiscard]] absl::Status MakeSet(const EditFlags& flags, const v1::LatticeState& state,
                                   Client& client, v1::Edit& edit);
[[nodiscard]] absl::Status MakeDrag(const EditFlags& flags, const v1::LatticeState& state,
                                    Client& client, v1::Edit& edit);
[[nodiscard]] absl::Status MakeConstrain(const EditFlags& flags, const v1::LatticeState& state,
                                         Client& client, v1::Edit& edit);
[[nodiscard]] absl::Status MakeCarry(const EditFlags& flags, const v1::LatticeState& state,
                                     Client& client, v1::Edit& edit);
[[nodiscard]] absl::Status MakeReplace(const EditFlags& flags, const v1::LatticeState& state,
                                       Client& client, v1::Edit& edit);
[[nodiscard]] absl::Status MakeResize(const EditFlags& flags, const v1::LatticeState& state,
                                      Client& client, v1::Edit& edit);
[[nodiscard]] absl::Status MakeOutside(const EditFlags& flags, const v1::LatticeState& state,
                                       Client& client, v1::Edit& edit);
[[nodiscard]] absl::Status MakeWeights(const EditFlags& flags, const v1::LatticeState& state,
                                       Client& client, v1::Edit& edit);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_EDIT_MAKERS_H_
