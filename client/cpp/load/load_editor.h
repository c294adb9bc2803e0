// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One editor of a load: it edits a scene by the plan, and watches it.
//
// Errors   the server's; they end the run (LoadControl)
// Threads  one at a time; log() like UpdateLog, surface() only after Close
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_EDITOR_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_EDITOR_H_

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cpp/library/latticed_client.h"
#include "client/cpp/load/edit_log.h"
#include "client/cpp/load/load_control.h"
#include "client/cpp/load/load_plan.h"
#include "client/cpp/load/update_log.h"

namespace latticed::client {

class LoadEditor {
 public:
  // All of these outlive the editor.
  struct Context {
    const LoadPlan* plan = nullptr;
    const v1::LatticeState* lattice = nullptr;  // before the first edit
    EditLog* edits = nullptr;
    LoadControl* control = nullptr;
    int number = 0;  // counts the editors of a scene
    bool decodes = false;
  };

  virtual ~LoadEditor() = default;
  // The first edit is due at `begin`, or a fraction of the period later: editors take turns.
  virtual void Start(absl::Time begin) = 0;
  // Waits until all of its edits have been answered.
  virtual void WaitUntilDone() = 0;
  // Waits until its stream has this revision. kDeadlineExceeded, or the error of the stream.
  [[nodiscard]] virtual absl::Status WaitFor(uint64_t revision) = 0;
  // Ends the stream and the threads. Idempotent.
  virtual void Close() = 0;

  virtual const UpdateLog& log() const = 0;
  virtual const Surface& surface() const = 0;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_EDITOR_H_
