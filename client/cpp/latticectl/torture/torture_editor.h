// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One editor of a scene, with a Deform stream. It has one edit without an answer at a time, so that each answer names the
// revision of its edit. What the server cannot take now, for instance because its store fails, is a pause.
//
// Errors   the server's, where the stream does not go on by itself; refusals that no state of the scene explains
// Threads  Run: its own
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_EDITOR_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_EDITOR_H_

#include <cstdint>
#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/cpp/latticectl/torture/random_edits.h"
#include "client/cpp/latticectl/torture/scene_model.h"
#include "client/cpp/latticectl/torture/torture_report.h"
#include "client/cpp/library/latticed_client.h"

namespace latticed::client {

class TortureEditor {
 public:
  // All of these must outlive it.
  struct Context {
    Client* client = nullptr;
    SceneModel* model = nullptr;
    TortureCounts* counts = nullptr;
    absl::Duration period;  // between two edits
  };
  TortureEditor(Context context, RandomEdits edits) : context_(context), edits_(edits) {}

  // Edits until `ended` holds. The last edit is answered when it returns.
  [[nodiscard]] absl::Status Run(const std::function<bool()>& ended);

 private:
  absl::Status Open();
  // Sends an edit, and others in its place while the server puts them off. `due` is when the first was due.
  absl::Status Edit(absl::Time due, const std::function<bool()>& ended);
  absl::StatusOr<v1::EditResult> AwaitResult(uint64_t sequence);
  void CountReconnections();

  const Context context_;
  RandomEdits edits_;
  std::unique_ptr<DeformStream> stream_;
  int reconnections_ = 0;  // of them that were counted
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_TORTURE_TORTURE_EDITOR_H_
