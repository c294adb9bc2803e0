// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The part that Deform, Watch and GetUpdate share: one watcher, one outstanding write, an orderly end. The
// reactor reads and owns the call; this class decides what is written next:
//
//   small events (hello, edit_result, heartbeat, goaway) > first lattice > presence > lattice >
//   the update's next event
//
// Only small events are queued, and the reactor stops reading when too many wait (backlog). A stream ends OK
// when full detail has reached finish_at (half-close, GetUpdate), or after goaway; with a status when the
// scene is deleted or cannot be evaluated; CANCELLED when the client cancels or its deadline passes. The
// watcher is then destroyed at once, so that nothing is evaluated or kept for it.
//
// After goaway the stream stays open for kRefusalTime, and edits that come in this time are refused with an answer.
//
// A client that does not read keeps one message in memory, with the chunks in it, also when their snapshot
// is retired. The stream reserves the message from --memory, at most one MiB.
//
// Locks    the stream's mutex before those of scene and view
// Threads  safe
#ifndef LATTICED_SERVER_RPC_SCENE_STREAM_H_
#define LATTICED_SERVER_RPC_SCENE_STREAM_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include <grpcpp/alarm.h>
#include <grpcpp/grpcpp.h>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "latticed/v1/scene.pb.h"
#include "server/base/quotas/tenant_quotas.h"
#include "server/engine/memory/memory_budget.h"
#include "server/engine/scene.h"
#include "server/engine/scene/presence.h"
#include "server/engine/watch_control.h"
#include "server/engine/watcher.h"
#include "server/rpc/due_answers.h"

namespace latticed {

class CallerAccount;  // server/stores/callers.h
struct ServerEnv;

enum class StreamState {
  kIdle,      // open, and nothing is being written
  kWriting,   // one write is outstanding
  kFinished,  // nothing more is written or counted
};

// The writing half of a reactor. Neither call blocks; each is made at most once per OnWriteDone.
class StreamSink {
 public:
  virtual ~StreamSink() = default;
  virtual void Write(const grpc::ByteBuffer* buffer) = 0;  // the buffer lives until OnWriteDone
  virtual void Finish(const grpc::Status& status) = 0;
};

class SceneStream : public SceneListener,
                    public WatchControl,
                    public std::enable_shared_from_this<SceneStream> {
 public:
  struct Options {
    WatcherOptions watcher;
    // Set for GetUpdate: no hello, no heartbeats, and the stream ends after the first update at or above
    // this revision.
    std::optional<uint64_t> only_update;
  };
  // Opens the watch of `scene`; nothing is written before Start. The sink lives until its reactor
  // is done, which is after Finish. Watcher::Create's errors, and kResourceExhausted where there is
  // no room for a message, or the tenant's quota is used up.
  // It is charged to options.watcher.account.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<SceneStream>> Open(
      ServerEnv* env, const CallerAccount& caller, std::shared_ptr<Scene> scene, Options options,
      StreamSink* sink);

  // Writes the first event. Called when the reactor can find the stream, because the write may end at once.
  void Start() ABSL_LOCKS_EXCLUDED(mutex_);

  void OnSceneChanged() override ABSL_LOCKS_EXCLUDED(mutex_);
  const MemoryAccount* account() const override { return account_.get(); }
  const Scene& scene() const override { return *scene_; }
  Scene& mutable_scene() const { return *scene_; }
  [[nodiscard]] absl::Status Control(const WatchCommand& command) override
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Called by the reactor. `ok` is false when the call is over.
  void OnWriteDone(bool ok) ABSL_LOCKS_EXCLUDED(mutex_);
  void OnCancel() ABSL_LOCKS_EXCLUDED(mutex_);
  // The client has shown that it is alive.
  void Touch() ABSL_LOCKS_EXCLUDED(mutex_);
  // An edit has come, and Answer will be called with the number that this returns. Answers are sent in the order of these
  // calls.
  [[nodiscard]] uint64_t ExpectAnswer() ABSL_LOCKS_EXCLUDED(mutex_);
  // Called before and after an edit is applied: its answer is sent before the next chunks, and before any
  // update that contains it. A second answer with the same number is ignored.
  void BeginEdit() ABSL_LOCKS_EXCLUDED(mutex_);
  void Answer(uint64_t number, const v1::SceneEvent& result) ABSL_LOCKS_EXCLUDED(mutex_);
  // No more messages will come: the stream ends OK after all answers, and an update at or above the highest revision in
  // them; without any edit, at or above the newest revision.
  void HalfClose() ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends the stream, after the message that is being written.
  void Fail(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  // The call is done: the sink is not called any more, and the presence that the stream showed is taken
  // back. Called before the reactor releases the stream.
  void Close() ABSL_LOCKS_EXCLUDED(mutex_);
  // Whether nothing more is written, so that messages of the client cannot be answered.
  bool ended() const ABSL_LOCKS_EXCLUDED(mutex_);
  // How many small events wait to be written, answers to edits that are being stored among them.
  size_t backlog() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  SceneStream(ServerEnv* env, std::shared_ptr<Scene> scene, const Options& options,
              StreamSink* sink);
  void Greet() ABSL_LOCKS_EXCLUDED(mutex_);
  void Pump() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<std::optional<grpc::ByteBuffer>> NextBuffer()
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::optional<grpc::ByteBuffer> NextPresence() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Calls `what` at `time`, if the alarm and the stream still exist.
  std::unique_ptr<grpc::Alarm> AlarmAt(absl::Time time, void (SceneStream::*what)());
  void WakeAt(absl::Time time) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void OnPace() ABSL_LOCKS_EXCLUDED(mutex_);
  // Sets `waiting` to those that the presence wakes.
  absl::Status Steer(const WatchCommand& command, PresenceBoard::Waiting& waiting)
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status CheckPresence(const Presence& presence) const;
  bool AtEnd() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void FinishLocked(const grpc::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Hear() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ScheduleHeartbeat() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void OnHeartbeat() ABSL_LOCKS_EXCLUDED(mutex_);
  void GoAway() ABSL_LOCKS_EXCLUDED(mutex_);

  ServerEnv* const env_;
  const std::shared_ptr<Scene> scene_;
  const bool only_update_;
  const std::string watch_id_;
  const std::string editor_id_;  // may be empty
  const MemoryAccountPtr account_;
  TenantQuotas::Place place_;  // null for GetUpdate
  // Start and Close may run at the same time. This lock comes before mutex_.
  Mutex drain_mutex_;
  bool closed_ ABSL_GUARDED_BY(drain_mutex_) = false;
  std::optional<std::stop_callback<std::function<void()>>> on_drain_ ABSL_GUARDED_BY(drain_mutex_);

  mutable Mutex mutex_;
  StreamState state_ ABSL_GUARDED_BY(mutex_) = StreamState::kIdle;
  StreamSink* const sink_ ABSL_PT_GUARDED_BY(mutex_);
  MemoryReservation room_ ABSL_GUARDED_BY(mutex_);            // for the message being written
  std::unique_ptr<Watcher> watcher_ ABSL_GUARDED_BY(mutex_);  // null once finished
  std::deque<grpc::ByteBuffer> small_ ABSL_GUARDED_BY(mutex_);
  PresenceFeed presence_ ABSL_GUARDED_BY(mutex_);
  MemoryReservation presence_room_ ABSL_GUARDED_BY(mutex_);  // for the presence that is shown
  grpc::ByteBuffer writing_ ABSL_GUARDED_BY(mutex_);
  std::optional<uint64_t> finish_at_ ABSL_GUARDED_BY(mutex_);
  bool half_closed_ ABSL_GUARDED_BY(mutex_) = false;
  DueAnswers due_ ABSL_GUARDED_BY(mutex_);
  bool going_away_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<grpc::Status> end_
      ABSL_GUARDED_BY(mutex_);                       // after the message that is being written
  absl::Time refusals_end_ ABSL_GUARDED_BY(mutex_);  // once going away
  absl::Time last_heard_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<grpc::Alarm> heartbeat_ ABSL_GUARDED_BY(mutex_);
  // For wake_at of watcher and presence.
  std::unique_ptr<grpc::Alarm> pace_ ABSL_GUARDED_BY(mutex_);
  // By the tenant's quota of bytes. Small events, heartbeats above all, do not wait for it.
  absl::Time open_at_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  absl::Time pace_time_ ABSL_GUARDED_BY(mutex_) = absl::InfiniteFuture();
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SCENE_STREAM_H_
