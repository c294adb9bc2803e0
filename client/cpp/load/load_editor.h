// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One editor of a load: it edits a scene as its plan says and watches it.
//
// Errors   the server's; they end the run (LoadControl)
// Threads  one at a time; log() as it says, surface() after Close
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
  // What it works with. All outlive it.
  struct Context {
    const LoadPlan* plan = nullptr;
    const v1::LatticeState* lattice = nullptr;  // before all edits
    EditLog* edits = nullptr;
    LoadControl* control = nullptr;
    int number = 0;  // in its scene
    bool decodes = false;
  };

  virtual ~LoadEditor() = default;
  // The first edit is due at `begin`, or a share of the period later, so that editors take turns.
  virtual void Start(absl::Time begin) = 0;
  // Until all its edits have been answered.
  virtual void WaitUntilDone() = 0;
  // Until its stream has this revision. kDeadlineExceeded, or why the stream has failed.
  [[nodiscard]] virtual absl::Status WaitFor(uint64_t revision) = 0;
  // Ends stream and threads. Idempotent.
  virtual void Close() = 0;

  virtual const UpdateLog& log() const = 0;
  virtual const Surface& surface() const = 0;
};

// By the plan's mode; returns with the first update.
[[nodiscard]] absl::StatusOr<std::unique_ptr<LoadEditor>> OpenLoadEditor(
    std::unique_ptr<Client> client, v1::WatchRequest request, const LoadEditor::Context& context);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_EDITOR_H_
