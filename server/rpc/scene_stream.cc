// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/scene_stream.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "server/base/auth/tenant.h"
#include "server/base/random_id.h"
#include "server/engine/render/render_view.h"
#include "server/rpc/farewell.h"
#include "server/rpc/server_env.h"
#include "server/stores/callers.h"
#include "server/stores/scene_registry.h"
#include "server/wire/grpc_status.h"
#include "server/wire/presence_converters.h"
#include "server/wire/time_converters.h"
#include "server/wire/wire_buffers.h"

namespace latticed {
namespace {

// A client that has sent nothing for this many heartbeat intervals gets no updates until it sends something.
constexpr int kSilentHeartbeats = 3;
// How long edits that were sent before the client read goaway may still come.
constexpr absl::Duration kRefusalTime = absl::Milliseconds(200);

// The most bytes of a message to a watcher of this view: chunks, the whole lattice, patterns, or a
// small event.
uint64_t MostMessageBytes(const SceneState& state, const ViewKey& key) {
  constexpr uint64_t kSmall = 4'096, kPatterns = 192 << 10;
  uint64_t large =
      std::max(state.control_points->size() * sizeof(Vec3d), VertexBytes(*state.plan, key));
  if (key.spec.tolerance > 0) large = std::max(large, kPatterns);
  large +=
      std::min(state.plan->chunk_count(), limits::kMaxBatchChunks) * limits::kMaxChunkHeadBytes;
  return std::min<uint64_t>(large + kSmall, limits::kMaxMessageBytes);
}

// Twice the largest presence: the scene holds two while one replaces the other.
constexpr uint64_t kLargestPresence = 8'192, kPresenceBytes = 2 * kLargestPresence;
constexpr uint64_t kBookkeeping = 1'024;  // of the board and the allocator
static_assert(sizeof(Presence) + limits::kMaxPresenceIndices * sizeof(uint32_t) +
                  4 * limits::kMaxPresenceName + 2 * limits::kMaxEditorIdBytes + kBookkeeping <=
              kLargestPresence);

}  // namespace

SceneStream::SceneStream(ServerEnv* env, std::shared_ptr<Scene> scene, const Options& options,
                         StreamSink* sink)
    : env_(env),
      scene_(std::move(scene)),
      only_update_(options.only_update.has_value()),
      watch_id_(NewRandomId()),
      editor_id_(options.watcher.editor_id),
      account_(options.watcher.account),
      sink_(sink),
      presence_(&scene_->presence(), editor_id_),
      finish_at_(options.only_update),
      half_closed_(only_update_),
      last_heard_(absl::Now()) {}

absl::StatusOr<std::shared_ptr<SceneStream>> SceneStream::Open(ServerEnv* env,
                                                               const CallerAccount& caller,
                                                               std::shared_ptr<Scene> scene,
                                                               Options options, StreamSink* sink) {
  const auto most = static_cast<size_t>(env->options.max_watchers);
  if (scene->watcher_count() >= most) {
    return error::LimitExceeded("watchers of a scene", most);
  }
  if (const size_t share = caller.ShareOf(most); scene->WatchersOf(*caller.memory) >= share) {
    return error::LimitExceeded("watchers of a scene for one caller", share);
  }
  LATTICED_ASSIGN_OR_RETURN(
      auto place, env->quotas.OpenStream(TenantOf(scene->id()), !options.only_update, absl::Now()));
  options.watcher.account = caller.memory;
  const std::shared_ptr<SceneStream> stream(new SceneStream(env, std::move(scene), options, sink));
  const uint64_t bytes = MostMessageBytes(*stream->scene_->State(), options.watcher.view.key);
  LATTICED_ASSIGN_OR_RETURN(auto room,
                            env->memory->Reserve("the stream's messages", bytes, caller.memory));
  options.watcher.evaluator =
      env->evaluator + " " + env->backend().Arithmetic(stream->scene_->pipeline());
  options.watcher.run = env->boot_id;
  LATTICED_ASSIGN_OR_RETURN(auto watcher, Watcher::Create(stream->scene_, options.watcher));
  const MutexLock lock(&stream->mutex_);
  stream->room_ = std::move(room);
  stream->place_ = std::move(place);
  stream->watcher_ = std::move(watcher);
  return stream;
}

void SceneStream::Start() {
  const std::weak_ptr<SceneStream> weak = weak_from_this();
  if (!only_update_) Greet();
  scene_->AddListener(weak);
  if (!only_update_) env_->scenes->AddWatch(TenantKey(TenantOf(scene_->id()), watch_id_), weak);
  {
    const MutexLock lock(&drain_mutex_);
    if (!closed_) {
      on_drain_.emplace(env_->drain.get_token(), [weak] {
        if (const auto stream = weak.lock(); stream != nullptr) stream->GoAway();
      });
    }
  }
  OnSceneChanged();
}

void SceneStream::Greet() {
  const MutexLock lock(&mutex_);
  if (state_ == StreamState::kFinished) return;
  v1::SceneEvent event;
  v1::Hello& hello = *event.mutable_hello();
  hello.set_watch_id(watch_id_);
  hello.set_boot_id(env_->boot_id);
  hello.set_head_revision(scene_->State()->revision);
  hello.set_resumed(watcher_->resumed());
  SetDuration(env_->options.heartbeat_interval, *hello.mutable_heartbeat());
  small_.push_back(EncodeEvent(event));
  ScheduleHeartbeat();
}

void SceneStream::Pump() {
  if (state_ != StreamState::kIdle) return;
  if (AtEnd()) return FinishLocked(grpc::Status::OK);
  if (small_.empty() && absl::Now() < open_at_) return WakeAt(open_at_);
  auto buffer = CatchBadAlloc(
      "the stream", [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return NextBuffer(); });
  if (!buffer.ok()) return FinishLocked(ToGrpcStatus(buffer.status()));
  if (!buffer->has_value()) return;
  state_ = StreamState::kWriting;
  writing_ = **std::move(buffer);
  open_at_ = env_->quotas.TakeBytes(TenantOf(scene_->id()), writing_.Length(), absl::Now());
  sink_->Write(&writing_);
}

bool SceneStream::AtEnd() const {
  if (!small_.empty() || watcher_->update_in_progress() || due_.size() > 0) return false;
  // An answer may have said that the scene has moved: the client is to resume, and to send the edit again.
  if (!only_update_ && scene_->is_lost()) return false;
  // After goaway, GetUpdate still sends a revision that exists, but does not wait for a later one.
  const bool on_its_way = only_update_ && *finish_at_ <= scene_->State()->revision;
  if (going_away_ && !on_its_way && absl::Now() >= refusals_end_) return true;
  return finish_at_.has_value() && watcher_->covered().has_value() &&
         *watcher_->covered() >= *finish_at_ && watcher_->has_full_detail();
}

absl::StatusOr<std::optional<grpc::ByteBuffer>> SceneStream::NextBuffer() {
  if (!small_.empty()) {
    grpc::ByteBuffer buffer = small_.front();  // shares the slices
    small_.pop_front();
    return buffer;
  }
  if (auto presence = NextPresence(); presence.has_value()) return presence;
  LATTICED_ASSIGN_OR_RETURN(const auto event, watcher_->Next(absl::Now()));
  if (event.has_value()) return EncodeEvent(*event);
  WakeAt(std::min(watcher_->wake_at(), presence_.wake_at()));
  return std::nullopt;
}

std::optional<grpc::ByteBuffer> SceneStream::NextPresence() {
  if (only_update_ || !watcher_->has_lattice()) return std::nullopt;
  const auto presence = presence_.Next(absl::Now(), shared_from_this());
  if (presence == nullptr) return std::nullopt;
  v1::SceneEvent event;
  *event.mutable_presence() = ToProto(*presence);
  return EncodeEvent(event);
}

std::unique_ptr<grpc::Alarm> SceneStream::AlarmAt(absl::Time time, void (SceneStream::*what)()) {
  // A new Alarm each time: an Alarm runs once, and must not be set again from its own callback.
  auto alarm = std::make_unique<grpc::Alarm>();
  alarm->Set(absl::ToChronoTime(time), [weak = weak_from_this(), what](bool expired) {
    if (!expired) return;  // a later alarm replaced this one
    if (const auto stream = weak.lock(); stream != nullptr) ((*stream).*what)();
  });
  return alarm;
}

void SceneStream::WakeAt(absl::Time time) {
  // An alarm for the same time stays. Otherwise every message of a busy client would make a new one.
  if (time == absl::InfiniteFuture() || time == pace_time_) return;
  pace_time_ = time;
  pace_ = AlarmAt(time, &SceneStream::OnPace);
}

void SceneStream::OnPace() {
  const MutexLock lock(&mutex_);
  pace_time_ = absl::InfiniteFuture();
  if (going_away_ && absl::Now() < refusals_end_) {  // the alarm is a little early
    heartbeat_ = AlarmAt(refusals_end_, &SceneStream::OnPace);
  }
  Pump();
}

void SceneStream::FinishLocked(const grpc::Status& status) {
  if (state_ == StreamState::kFinished) return;
  const bool writing = state_ == StreamState::kWriting;
  state_ = StreamState::kFinished;
  watcher_.reset();
  small_.clear();
  heartbeat_.reset();
  pace_.reset();
  // An in-process call that is finished while a message is written may never end: gRPC forgets the message.
  if (writing) {
    end_ = status;
  } else {
    sink_->Finish(status);
  }
}

void SceneStream::OnSceneChanged() {
  const MutexLock lock(&mutex_);
  Pump();
}

void SceneStream::OnWriteDone(bool ok) {
  const MutexLock lock(&mutex_);
  writing_.Clear();
  if (end_.has_value()) return sink_->Finish(*end_);
  state_ = StreamState::kIdle;
  if (!ok) {
    return FinishLocked(grpc::Status(grpc::StatusCode::CANCELLED, "the client has gone"));
  }
  Pump();
}

void SceneStream::OnCancel() {
  const MutexLock lock(&mutex_);
  FinishLocked(grpc::Status(grpc::StatusCode::CANCELLED, "the client cancelled"));
}

void SceneStream::Hear() {
  last_heard_ = absl::Now();
  watcher_->SetSilent(false);
}

void SceneStream::Touch() {
  const MutexLock lock(&mutex_);
  if (state_ == StreamState::kFinished) return;
  Hear();
  Pump();
}

absl::Status SceneStream::Control(const WatchCommand& command) {
  PresenceBoard::Waiting waiting;
  auto status = Steer(command, waiting);
  // Locks other streams, so this stream's lock must not be held.
  Wake(waiting);
  return status;
}

absl::Status SceneStream::CheckPresence(const Presence& presence) const {
  if (editor_id_.empty()) {
    return error::InvalidField("presence", "the watch has no editor_id, which says whose it is");
  }
  if (!presence.editor_id.empty() && presence.editor_id != editor_id_) {
    return error::InvalidField("presence.editor_id", "is not the editor of the watch");
  }
  if (presence.following == editor_id_) {
    return error::InvalidField("presence.following", "is the editor of the watch itself");
  }
  return absl::OkStatus();
}

absl::Status SceneStream::Steer(const WatchCommand& command, PresenceBoard::Waiting& waiting) {
  const MutexLock lock(&mutex_);
  if (state_ == StreamState::kFinished) return error::NotFound("watch", watch_id_);
  Hear();
  // Steps that may fail come first, so that a refused command changes nothing.
  if (command.presence.has_value()) {
    LATTICED_RETURN_IF_ERROR(CheckPresence(*command.presence));
    if (presence_room_.bytes() == 0) {
      LATTICED_ASSIGN_OR_RETURN(
          presence_room_, env_->memory->Reserve("the stream's presence", kPresenceBytes, account_));
    }
  }
  if (command.view.has_value()) {
    LATTICED_RETURN_IF_ERROR(watcher_->CheckAck(command.acked_update_id.value_or(0)));
    const uint64_t bytes = MostMessageBytes(*scene_->State(), command.view->key);
    if (bytes > room_.bytes()) {
      LATTICED_RETURN_IF_ERROR(room_.Resize("the stream's messages", bytes));
    }
    LATTICED_RETURN_IF_ERROR(watcher_->SetView(*command.view));
  }
  if (command.acked_update_id.has_value()) {
    LATTICED_RETURN_IF_ERROR(watcher_->Ack(*command.acked_update_id));
  }
  if (command.pause.has_value()) watcher_->SetPaused(*command.pause);
  if (command.presence.has_value()) {
    Presence presence = *command.presence;
    presence.editor_id = editor_id_;
    waiting = scene_->presence().Show(this, std::move(presence));
  }
  Pump();
  return absl::OkStatus();
}

uint64_t SceneStream::ExpectAnswer() {
  const MutexLock lock(&mutex_);
  return due_.Expect();
}

void SceneStream::BeginEdit() {
  const MutexLock lock(&mutex_);
  // While an earlier answer is due, its ceiling holds.
  if (state_ == StreamState::kFinished || due_.size() > 1) return;
  watcher_->SetCeiling(scene_->State()->revision);
}

void SceneStream::Answer(uint64_t number, const v1::SceneEvent& result) {
  const MutexLock lock(&mutex_);
  due_.Fill(number, EncodeEvent(result), result.edit_result().revision());
  const size_t before = due_.size();
  while (auto event = due_.Take()) small_.push_back(*std::move(event));
  if (due_.size() == before || state_ == StreamState::kFinished) return;
  // The next answer is of a revision that nobody has seen yet.
  watcher_->SetCeiling(due_.size() == 0 ? std::nullopt : due_.highest_revision());
  if (half_closed_) finish_at_ = std::max(*finish_at_, *due_.highest_revision());
  Pump();
}

void SceneStream::HalfClose() {
  const MutexLock lock(&mutex_);
  if (state_ == StreamState::kFinished) return;
  half_closed_ = true;
  const auto answered = due_.highest_revision();
  finish_at_ = answered.has_value() ? *answered : scene_->State()->revision;
  // The client sends nothing more, so updates wait for no acknowledgement and no heartbeat.
  watcher_->StopAcks();
  watcher_->WantFullDetail();
  watcher_->SetPaused(false);
  watcher_->SetSilent(false);
  Pump();
}

void SceneStream::Fail(const absl::Status& status) {
  const MutexLock lock(&mutex_);
  FinishLocked(ToGrpcStatus(status));
}

void SceneStream::Close() {
  // Not in the destructor: a drain callback that holds the last reference must not wait for itself.
  {
    const MutexLock lock(&drain_mutex_);
    closed_ = true;
    on_drain_.reset();
  }
  // The stream has finished, so it shows no presence any more.
  Wake(scene_->presence().Leave(this, editor_id_));
}

bool SceneStream::ended() const {
  const MutexLock lock(&mutex_);
  return state_ == StreamState::kFinished;
}

size_t SceneStream::backlog() const {
  const MutexLock lock(&mutex_);
  return small_.size() + due_.size();
}

void SceneStream::ScheduleHeartbeat() {
  heartbeat_ = AlarmAt(absl::Now() + env_->options.heartbeat_interval, &SceneStream::OnHeartbeat);
}

void SceneStream::OnHeartbeat() {
  const MutexLock lock(&mutex_);
  if (state_ == StreamState::kFinished || going_away_) return;
  ScheduleHeartbeat();
  const absl::Duration silence = absl::Now() - last_heard_;
  if (!half_closed_ && silence > kSilentHeartbeats * env_->options.heartbeat_interval) {
    watcher_->SetSilent(true);
  }
  // While a write is outstanding, the client has something to read, and heartbeats must not queue up.
  if (state_ != StreamState::kIdle || !small_.empty()) return;
  v1::SceneEvent event;
  event.mutable_heartbeat()->set_head_revision(scene_->State()->revision);
  small_.push_back(EncodeEvent(event));
  Pump();
}

void SceneStream::GoAway() {
  const MutexLock lock(&mutex_);
  if (state_ == StreamState::kFinished) return;
  const bool moves = env_->store != nullptr && env_->store->shared();
  small_.push_back(DrainMessage(moves));
  going_away_ = true;
  if (!half_closed_) {
    refusals_end_ = absl::Now() + kRefusalTime;
    heartbeat_ = AlarmAt(refusals_end_, &SceneStream::OnPace);  // in place of heartbeats
  }
  Pump();
}

}  // namespace latticed
