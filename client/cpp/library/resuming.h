// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The base of streams of scene events. After a goaway, or after an error that MayRetry names, it opens
// itself again with its resume token, for as long as the client's connection says and with the pauses of attempts.h.
//
//   stream.Start();
//   auto event = stream.Read();                   // … until nullopt
//   stream.Worked(resume_token);                  // whenever an update is complete
//
// Errors   the server's; those that MayRetry names only after 30 s (Connection::retry_for) without an update
// Threads  one at a time; Cancel from any
#ifndef LATTICED_CLIENT_CPP_LIBRARY_RESUMING_H_
#define LATTICED_CLIENT_CPP_LIBRARY_RESUMING_H_

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/library/retries/attempts.h"
#include "client/cpp/library/retries/reachability.h"
#include "client/cpp/library/status.h"
#include "client/cpp/library/surface.h"
#include "core/base/mutex.h"
#include "latticed/v1/scene.pb.h"

namespace latticed::client {

// Called with every event on the reading thread, before the stream handles the event. Nothing is read
// while it runs, so a slow observer is a slow reader.
using EventObserver = std::function<void(const v1::SceneEvent&)>;

// Presence of other editors, by editor_id.
using Others = std::map<std::string, v1::Presence>;

// Rpc is grpc::ClientReader or grpc::ClientReaderWriter, which share no public base class.
template <typename Rpc>
class ResumingStream {
 public:
  ResumingStream(const ResumingStream&) = delete;
  ResumingStream& operator=(const ResumingStream&) = delete;

  // Ends the rpc, or the pause before the next one.
  void Cancel() {
    const MutexLock lock(&mutex_);
    cancelled_ = true;
    if (context_ != nullptr) context_->TryCancel();
  }

  // The complete update that the stream opened with.
  const std::optional<CompleteUpdate>& first_update() const { return first_update_; }
  const Surface& surface() const { return surface_; }
  const v1::Hello& hello() const { return hello_; }
  // The other editors that are present, according to the events read so far.
  const Others& others() const { return others_; }
  // How often the stream had to open itself again.
  int reconnections() const { return reconnections_; }

 protected:
  // `server` and `channel` must outlive the stream. A request of `stop` cancels the stream.
  ResumingStream(v1::WatchRequest watch, Reachability* server, grpc::Channel* channel,
                 const std::stop_token& stop, EventObserver observer)
      : watch_(std::move(watch)),
        observer_(std::move(observer)),
        server_(server),
        channel_(channel),
        attempts_(server),
        cancel_on_stop_(stop, [this] { Cancel(); }) {}
  virtual ~ResumingStream() {
    if (rpc_ == nullptr) return;
    Cancel();
    v1::SceneEvent event;
    while (rpc_->Read(&event)) {
    }
    (void)rpc_->Finish();
  }

  virtual std::unique_ptr<grpc::ClientContext> NewContext() = 0;
  // Starts the rpc and sends its first requests.
  virtual std::unique_ptr<Rpc> OpenRpc(grpc::ClientContext* context) = 0;
  // The server ends the rpc: half-closes it, if the client writes requests.
  virtual void EndRequests() {}

  void Start() {
    {
      const MutexLock lock(&mutex_);
      context_ = NewContext();
      if (cancelled_) context_->TryCancel();
    }
    goaway_.reset();
    hello_at_ = absl::InfiniteFuture();
    rpc_ = OpenRpc(context_.get());
  }

  // Waits for the next event. Handles goaway and presence itself. Returns nullopt when the stream was
  // cancelled or has ended OK.
  [[nodiscard]] absl::StatusOr<std::optional<v1::SceneEvent>> Read() {
    while (rpc_ != nullptr) {
      v1::SceneEvent event;
      if (!rpc_->Read(&event)) {
        if (const absl::Status status = Restart(); !status.ok()) return status;
        continue;
      }
      if (observer_) observer_(event);
      if (event.has_goaway()) {
        goaway_ = event.goaway();
        EndRequests();
      } else if (event.has_presence()) {
        TakePresence(event.presence());
      } else {
        if (event.has_hello()) TakeHello(event.hello());
        return event;
      }
    }
    return std::nullopt;
  }

  // Called when an update is complete. The stream will resume after it.
  void Worked(std::string resume_token) {
    attempts_.Succeeded();
    watch_.set_resume_token(std::move(resume_token));
  }

  // The rpc, to write requests; null when the stream has ended.
  Rpc* rpc() const { return rpc_.get(); }
  // Its resume_token is always the newest.
  const v1::WatchRequest& watch() const { return watch_; }

  Surface surface_;
  std::optional<CompleteUpdate> first_update_;
  std::optional<v1::Presence> shown_;  // presence of this stream's own editor

 private:
  // A stream that has lived so long has worked, also without an update, as while nothing changes.
  static constexpr absl::Duration kWorks = absl::Seconds(1);
  // A server may ask for any pause. A much longer one would overflow the clock.
  static constexpr absl::Duration kLongestPause = absl::Hours(24 * 365);

  // Called when the rpc has ended. Starts another unless the stream has ended OK or was cancelled.
  // Returns the error if another attempt cannot help.
  absl::Status Restart() {
    absl::Status status = FromGrpc(rpc_->Finish(), *context_);
    // A proxy may replace the status of a call that the server ends.
    if (goaway_.has_value()) status = FromRpc(goaway_->status(), *context_);
    rpc_.reset();
    surface_.DropPartialUpdate();
    const bool done = status.ok() && !goaway_.has_value();
    if (done || cancelled()) return absl::OkStatus();
    if (goaway_.has_value()) {
      const auto& after = goaway_->retry_after();
      Pause(absl::Seconds(after.seconds()) + absl::Nanoseconds(after.nanos()));
    }
    if (absl::Now() - hello_at_ > kWorks) attempts_.Succeeded();
    if (!status.ok()) {
      const auto pause = attempts_.PauseAfter(status);
      if (!pause.has_value()) return status;
      Reachability::Wait(*channel_, *pause, [this] { return cancelled(); });
    }
    ++reconnections_;
    Start();
    return absl::OkStatus();
  }

  // After hello the server sends the presence of all editors.
  void TakeHello(const v1::Hello& hello) {
    hello_ = hello;
    hello_at_ = absl::Now();
    others_.clear();
  }

  void TakePresence(const v1::Presence& presence) {
    if (presence.left()) {
      others_.erase(presence.editor_id());
    } else {
      others_[presence.editor_id()] = presence;
    }
  }

  void Pause(absl::Duration duration) {
    const MutexLock lock(&mutex_);
    mutex_.AwaitFor([this] { return cancelled_; }, std::min(duration, kLongestPause));
  }

  bool cancelled() {
    const MutexLock lock(&mutex_);
    return cancelled_;
  }

  v1::WatchRequest watch_;
  const EventObserver observer_;
  v1::Hello hello_;
  Others others_;
  absl::Time hello_at_ = absl::InfiniteFuture();  // of the present rpc
  std::optional<v1::Goaway> goaway_;              // of the present rpc
  Reachability* const server_;
  grpc::Channel* const channel_;
  Attempts attempts_;
  int reconnections_ = 0;

  Mutex mutex_;  // Cancel is called from other threads
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  // Only the reading thread replaces it, with the mutex held. Only that thread reads it without the mutex.
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<Rpc> rpc_;                                        // uses *context_
  const std::stop_callback<std::function<void()>> cancel_on_stop_;  // last: uses the others
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_RESUMING_H_
