// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What one scene must be, by what its server has acknowledged: a lattice for each revision. It applies the acknowledged
// edits in the order of their revisions, in this process, which does not crash with the server.
//
//   lost       the scene is at an older revision than one that was acknowledged or told before; or it is not there
//   doubled    the scene has more revisions than edits were sent
//   gap        a revision that no edit was acknowledged with, while no answer is missing
//   twice      a revision that two edits were acknowledged with, as by two servers that both have the scene
//   differs    the bytes of the lattice, or structure_id, are not those of the model at this revision
//
// The first of these ends the checks of the scene: the model says nothing about what comes after it.
//
// Threads  safe
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_SCENE_MODEL_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_SCENE_MODEL_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "client/cpp/latticectl/torture/torture_report.h"
#include "core/base/mutex.h"
#include "core/ffd/history/edit_history.h"
#include "latticed/v1/edit.pb.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed::client {

class SceneModel {
 public:
  // `initial`: the lattice at revision 0.
  SceneModel(std::string scene, Lattice initial);

  // An edit is about to be sent. One of the next two says how it ended.
  void Begin();
  // `batch` has the sequence with which it was sent.
  void Acknowledged(EditBatch batch, const v1::EditResult& result);
  // The edit was refused. `unsure`: because of the store, which may keep an edit that it has refused if it crashes then.
  void Refused(EditBatch batch, bool unsure);
  // An update has shown this revision.
  void Told(uint64_t revision);
  // The server says that the scene is not there, or damaged.
  void Gone(const absl::Status& status);

  // The newest revision that was acknowledged or told.
  uint64_t newest() const;
  // Compares with what GetLattice has answered. `newest`: newest() before the call. If answers for some of its revisions
  // are still to come, it compares when they are here.
  void Check(uint64_t newest, const v1::LatticeState& state);

  // What was found. Its `what` is empty if nothing was.
  Faults faults() const;
  bool intact() const { return faults().what.empty(); }
  const std::string& scene() const { return scene_; }

 private:
  void Fail(uint64_t Faults::*kind, uint64_t count, uint64_t revision, const std::string& what)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Compare() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Applies the edit of the model's next revision. False if its answer is missing, or it failed.
  bool Advance() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool ApplyUnsure() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  struct Answer {
    EditBatch batch;
    uint64_t structure_id;  // as acknowledged
  };

  const std::string scene_;
  mutable Mutex mutex_;
  EditHistory history_ ABSL_GUARDED_BY(mutex_);  // at the newest revision that was compared
  std::map<uint64_t, Answer> answers_ ABSL_GUARDED_BY(mutex_);     // by revision, above history_'s
  std::vector<EditBatch> unsure_ ABSL_GUARDED_BY(mutex_);          // in the order of their refusals
  std::optional<v1::LatticeState> state_ ABSL_GUARDED_BY(mutex_);  // to be compared
  uint64_t begun_ ABSL_GUARDED_BY(mutex_) = 0;    // edits that were sent, and not certainly refused
  uint64_t waiting_ ABSL_GUARDED_BY(mutex_) = 0;  // of them without an answer
  uint64_t newest_ ABSL_GUARDED_BY(mutex_) = 0;
  Faults faults_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_SCENE_MODEL_H_
