// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A stream of scene events that opens itself again with its resume token after a goaway, or after
// what MayRetry names: five times in a row, with pauses that double from 100 ms.
//
//   stream.Start();
//   auto event = stream.Read();                   // … until nullopt
//   stream.Worked(resume_token);                  // whenever an update is complete
//
// Errors   the server's, after five attempts in a row to open it again
// Threads  one at a time; Cancel from any
#ifndef LATTICED_CLIENT_CPP_LIBRARY_RESUMING_H_
#define LATTICED_CLIENT_CPP_LIBRARY_RESUMING_H_

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/library/reply.h"
#include "client/cpp/library/status.h"
#include "client/cpp/library/surface.h"
#include "core/base/mutex.h"
#include "latticed/v1/scene.pb.h"

namespace latticed::client {

// Called with every event as it comes, in the thread that reads, before the stream takes it. Nothing
// is read while it runs, so one that takes its time is a slow reader.
using EventObserver = std::function<void(const v1::SceneEvent&)>;

// Of grpc::ClientReader and grpc::ClientReaderWriter, which have no public base in common.
template <typename Stream>
class ResumingStream {
 public:
  using NewContext = std::function<std::unique_ptr<grpc::ClientContext>()>;
  // Makes the rpc, and sends what it begins with.
  using Open =
      std::function<std::unique_ptr<Stream>(grpc::ClientContext*, const v1::WatchRequest&)>;

  // `surface` forgets its partial update where the rpc breaks; a request of `stop` cancels.
  ResumingStream(v1::WatchRequest watch, NewContext new_context, Open open, Surface* surface,
                 const std::stop_token& stop, EventObserver observer)
      : watch_(std::move(watch)),
        new_context_(std::move(new_context)),
        open_(std::move(open)),
        surface_(surface),
        observer_(std::move(observer)),
        cancel_on_stop_(stop, [this] { Cancel(); }) {}
  ResumingStream(const ResumingStream&) = delete;
  ResumingStream& operator=(const ResumingStream&) = delete;
  ~ResumingStream() {
    if (rpc_ == nullptr) return;
    Cancel();
    v1::SceneEvent event;
    while (rpc_->Read(&event)) {
    }
    (void)rpc_->Finish();
  }

  void Start() {
    {
      const MutexLock lock(&mutex_);
      context_ = new_context_();
      if (cancelled_) context_->TryCancel();
    }
    goaway_ = false;
    rpc_ = open_(context_.get(), watch_);
  }

  // Waits for the next event but a goaway; nullopt when the stream was cancelled or has ended OK.
  [[nodiscard]] absl::StatusOr<std::optional<v1::SceneEvent>> Read() {
    while (rpc_ != nullptr) {
      v1::SceneEvent event;
      if (!rpc_->Read(&event)) {
        if (const absl::Status status = Restart(); !status.ok()) return status;
        continue;
      }
      if (observer_) observer_(event);
      if (event.has_goaway()) {
        goaway_ = true;
        const auto& after = event.goaway().retry_after();
        Pause(absl::Seconds(after.seconds()) + absl::Nanoseconds(after.nanos()));
      } else {
        return event;
      }
    }
    return std::nullopt;
  }

  // An update is complete: the stream resumes after it, and its failures are counted anew.
  void Worked(std::string resume_token) {
    failures_in_a_row_ = 0;
    watch_.set_resume_token(std::move(resume_token));
  }

  // Ends the rpc and pauses between two of them.
  void Cancel() {
    const MutexLock lock(&mutex_);
    cancelled_ = true;
    if (context_ != nullptr) context_->TryCancel();
  }

  // Where requests are written; null when the stream has ended.
  Stream* rpc() const { return rpc_.get(); }
  // Its resume_token is always the newest.
  const v1::WatchRequest& watch() const { return watch_; }
  // How often it had to open itself again.
  int reconnections() const { return reconnections_; }

 private:
  static constexpr int kMostFailuresInARow = 5;
  // A server may ask for any pause; a longer one would overflow the clock.
  static constexpr absl::Duration kLongestPause = absl::Hours(24 * 365);

  // The rpc has ended: makes another where that helps; the error is why not.
  absl::Status Restart() {
    const absl::Status status = FromGrpc(rpc_->Finish(), *context_);
    rpc_.reset();
    surface_->DropPartialUpdate();
    const bool done = status.ok() && !goaway_;
    if (done || cancelled()) return absl::OkStatus();
    if (!status.ok()) {
      if (!MayRetry(status) || ++failures_in_a_row_ > kMostFailuresInARow) return status;
      Pause(PauseAfter(failures_in_a_row_));
    }
    ++reconnections_;
    Start();
    return absl::OkStatus();
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
  const NewContext new_context_;
  const Open open_;
  Surface* const surface_;
  const EventObserver observer_;
  bool goaway_ = false;
  int failures_in_a_row_ = 0;
  int reconnections_ = 0;

  Mutex mutex_;  // Cancel is called from other threads
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  // Only the reading thread replaces it, under the mutex, and it alone reads it without.
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<Stream> rpc_;                                     // uses *context_
  const std::stop_callback<std::function<void()>> cancel_on_stop_;  // last: uses all
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_RESUMING_H_
