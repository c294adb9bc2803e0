// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One stream of a load, with its own connection.
//
//   editor, closed loop       a Deform stream, as of a native client. It sends the next edit when the
//                             update with the last one is complete. After its last edit it keeps reading
//   editor, open or interval  a Watch, and ApplyEdits from a second thread, as a browser does. Only one
//                             batch is unanswered at a time, as the protocol asks. In the open loop every
//                             edit is sent in its own batch, even if it is late. In interval mode all edits
//                             are one gesture, and only the newest edit that is due is sent
//   watcher                   a Watch that keeps up, reads slow_rate, or reads one update and then nothing
//
// Errors   the server's; those after Start end the run (LoadControl)
// Threads  one at a time; log() as UpdateLog says, surface() only before Start and after Close
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_STREAM_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_STREAM_H_

#include <memory>
#include <string>
#include <thread>

#include "absl/status/statusor.h"
#include "absl/synchronization/notification.h"
#include "client/cpp/latticectl/commands/load_plan.h"
#include "client/cpp/library/latticed_client.h"
#include "client/cpp/load/edit_log.h"
#include "client/cpp/load/load_control.h"
#include "client/cpp/load/update_log.h"

namespace latticed::client {

class LoadStream {
 public:
  enum class Kind { kEditor, kWatcher, kSlow, kStalled };
  // All of these must outlive the stream.
  struct Context {
    const LoadPlan* plan = nullptr;
    LoadControl* control = nullptr;
    std::string scene;
    v1::ViewOptions view;  // the plan's, with its tolerance in the scene's units
    const v1::LatticeState* lattice = nullptr;  // before the first edit
    EditLog* edits = nullptr;
  };

  // Returns when the first update has come. `number` counts the streams of a kind in a scene. A stalled
  // watcher turns off the limit of unacknowledged updates, so only the transport's flow control stops
  // the server.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<LoadStream>> Open(
      std::unique_ptr<Client> client, Kind kind, int number, Context context);
  LoadStream(const LoadStream&) = delete;  // its threads use it
  LoadStream& operator=(const LoadStream&) = delete;
  ~LoadStream() { Close(); }

  // Starts the threads. The first edit is due at `begin`. With a period, editor n of N is due n / N of
  // the period later, so that editors take turns.
  void Start(absl::Time begin);
  // Waits until all edits have been answered.
  void WaitUntilEdited();
  // Waits for an update of this revision or a later one. Errors: kDeadlineExceeded after a minute, and
  // those of the stream.
  [[nodiscard]] absl::Status WaitFor(uint64_t revision);
  // Ends the stream and its threads. May be called again.
  void Close();

  Kind kind() const { return kind_; }
  bool keeps_up() const { return kind_ == Kind::kEditor || kind_ == Kind::kWatcher; }
  const UpdateLog& log() const { return log_; }
  const Surface& surface() const {
    return deform_ != nullptr ? deform_->surface() : watch_->surface();
  }

 private:
  LoadStream(std::unique_ptr<Client> client, Kind kind, int number, Context context);
  absl::Status OpenStream();
  void Take(const v1::SceneEvent& event);
  // Reads the next result or update. The error may be the refusal of an edit.
  absl::Status Next();
  absl::Status EditInClosedLoop(absl::Time begin);
  absl::Status EditEveryPeriod(absl::Time begin);
  void Fail(const absl::Status& status);

  const std::unique_ptr<Client> client_;
  const Kind kind_;
  const int number_;
  const Context context_;
  const bool decodes_;
  UpdateLog log_;
  bool started_ = false;
  v1::EditResult result_;          // the newest result of deform_
  uint64_t applied_sequence_ = 0;  // of deform_'s newest update
  absl::Notification edited_, closing_;
  // One of the two is set. They use client_ and log_.
  std::unique_ptr<DeformStream> deform_;
  std::unique_ptr<WatchStream> watch_;
  std::thread reader_, editor_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_STREAM_H_
