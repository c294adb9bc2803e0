// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/deform_stream.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "absl/time/time.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/mutex.h"
#include "core/base/status_macros.h"
#include "server/base/auth/tenant.h"
#include "server/rpc/access/audit.h"
#include "server/rpc/access/tenant_access.h"
#include "server/rpc/access/token_end.h"
#include "server/rpc/call_counts.h"
#include "server/rpc/call_reactor.h"
#include "server/rpc/farewell.h"
#include "server/rpc/first_message.h"
#include "server/rpc/scene_stream.h"
#include "server/rpc/server_env.h"
#include "server/rpc/watch_request.h"
#include "server/wire/converters.h"
#include "server/wire/edit_converters.h"
#include "server/wire/grpc_status.h"
#include "server/wire/message_bytes.h"
#include "server/wire/time_converters.h"

namespace latticed {
namespace {

// Whether the edited lattice keeps a volume.
bool KeepsVolume(const SceneState& state, const v1::EditBatch& batch) {
  const size_t place = PlaceOf(state.lattices, batch.lattice());
  return place < state.lattices.size() && state.lattices[place].constraints->volume.has_value();
}

using Clock = std::chrono::steady_clock;

// Reads and writes run at the same time. The next message is read when the one before was handled.
class DeformStream final
    : public CallReactor<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>>,
      public StreamSink,
      public std::enable_shared_from_this<DeformStream> {
 public:
  DeformStream(const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context) : env_(env) {
    if (const absl::Status begun = BeginCall(*env, context, rpc, call_); !begun.ok()) {
      Finish(ToGrpcStatus(begun));
      return;
    }
    first_message_.Await(env->options.first_message_timeout, "watch",
                         [this](const absl::Status& late) { End(late); });
    const MutexLock lock(&mutex_);
    StartReading();
  }

  // Keeps gRPC's reference until OnDone.
  void HoldUntilDone() { self_ = shared_from_this(); }

  void Write(const grpc::ByteBuffer* buffer) override {
    BeginWrite();
    StartWrite(buffer);
  }
  void Finish(const grpc::Status& status) override;

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override {
    EndWrite();
    if (farewell_.begun()) return OnFarewellWritten(ok);
    const auto stream = Stream();
    stream->OnWriteDone(ok);
    MaybeRead();
  }
  void OnCancel() override;
  void OnDone() override {
    Done();
    if (const auto stream = Stream(); stream != nullptr) stream->Close();
    self_ = nullptr;  // deletes this, unless a worker still applies an edit
  }

 private:
  std::shared_ptr<SceneStream> Stream() const ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    return stream_;
  }
  void MaybeRead() ABSL_LOCKS_EXCLUDED(mutex_);
  void StartReading() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    reading_ = read_pending_ = true;
    StartRead(&bytes_);
  }
  // A read that starts after Finish would outlive the call.
  void StopReading() ABSL_LOCKS_EXCLUDED(mutex_) {
    const MutexLock lock(&mutex_);
    ended_ = true;
  }
  void FinishedReading() ABSL_LOCKS_EXCLUDED(mutex_);
  // Notes the end of a read, and takes its message. Returns whether it came after the farewell, and is handled.
  bool IsOfFarewell(bool ok, grpc::ByteBuffer& bytes) ABSL_LOCKS_EXCLUDED(mutex_);
  // Whether the client must be told how the call ends before it ends.
  bool NeedsFarewell(const grpc::Status& status) const ABSL_LOCKS_EXCLUDED(mutex_);
  void OnFarewellWritten(bool ok) ABSL_LOCKS_EXCLUDED(mutex_);
  // After a farewell: the client has half-closed, is gone, or is late.
  void Leave() ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends the call, with or without a stream.
  void End(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Open(const v1::DeformRequest& request);
  absl::Status Handle(const v1::DeformRequest& request, SceneStream& stream);
  absl::Status Control(const v1::ControlWatchRequest& request, SceneStream& stream);
  void OpenOnWorker(v1::DeformRequest request);
  void HandOver(v1::DeformRequest request, uint64_t number);
  // Applies the edit if it was admitted. It is answered, with this number, when it is durable.
  void HandleEdit(v1::EditBatch batch, uint64_t number, Clock::time_point arrival,
                  const absl::Status& admitted);
  absl::Status Apply(const v1::EditBatch& batch, Scene::EditDone done);
  // What an answer must know of its edit.
  struct EditToAnswer {
    uint64_t number = 0;  // of SceneStream::ExpectAnswer
    uint64_t sequence = 0;
    Clock::time_point arrival;
    Clock::time_point begun;  // when its turn came
  };
  void Answer(const EditToAnswer& edit, const absl::StatusOr<EditSummary>& summary);

  std::shared_ptr<DeformStream> self_;
  ServerEnv* const env_;
  FirstMessage first_message_;
  Farewell farewell_;
  TokenEnd token_end_;
  std::atomic<bool> cancelled_ = false;  // the context's own flag ends with the call
  std::string editor_id_;  // used only while a message is handled; there is one at a time

  mutable Mutex mutex_;
  std::shared_ptr<SceneStream> stream_ ABSL_GUARDED_BY(mutex_);  // null before the first message
  bool reading_ ABSL_GUARDED_BY(mutex_) = false;                 // or handling the message
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;                   // nothing more will be read
  bool read_pending_ ABSL_GUARDED_BY(mutex_) = false;            // gRPC will call OnReadDone
  bool half_closed_ ABSL_GUARDED_BY(mutex_) = false;             // by the client
  grpc::ByteBuffer bytes_ ABSL_GUARDED_BY(mutex_);               // gRPC reads into it
};

void DeformStream::OnReadDone(bool ok) {
  grpc::ByteBuffer bytes;
  if (IsOfFarewell(ok, bytes) || !first_message_.Arrive()) return;
  const auto stream = Stream();
  if (!ok) {
    if (stream == nullptr) {
      return End(error::FailedPrecondition("STREAM_NOT_OPENED",
                                           "the first message must be watch; none came"));
    }
    return stream->HalfClose();
  }
  if (stream != nullptr && stream->ended()) return;  // its end, or a farewell, says what comes next
  v1::DeformRequest request;
  absl::Status status = TakeMessage(bytes, &request);
  const auto takes_long = [&] {
    const Scene& scene = stream->scene();
    return MayTakeLong(request.edit(), scene.config().fold_watch) ||
           (request.has_edit() && KeepsVolume(*scene.State(), request.edit()));
  };
  if (status.ok() && stream != nullptr && takes_long()) {
    stream->Touch();
    return HandOver(std::move(request), stream->ExpectAnswer());
  }
  if (status.ok() && stream == nullptr && env_->IsAsleep(KeyFor(call_, request.watch().scene()))) {
    return OpenOnWorker(std::move(request));
  }
  if (status.ok()) status = stream == nullptr ? Open(request) : Handle(request, *stream);
  if (!status.ok()) return End(status);
  FinishedReading();
}

// As HandOver, for a scene that is asleep.
void DeformStream::OpenOnWorker(v1::DeformRequest request) {
  auto room = AdmitRequest(*env_, call_, request);
  if (!room.ok()) return End(room.status());
  env_->Post(WorkerLanes::Lane::kLong, *call_.account,
             [self = shared_from_this(), request = std::move(request),
              room = std::make_shared<MemoryReservation>(*std::move(room))] {
               const absl::Status opened =
                   CatchBadAlloc("the stream", [&] { return self->Open(request); });
               opened.ok() ? self->FinishedReading() : self->End(opened);
             });
}

// Gives the edit to a worker, which then asks for the next message. That message may come before Post returns,
// so nothing of this object may be used after Post.
void DeformStream::HandOver(v1::DeformRequest request, uint64_t number) {
  auto room = AdmitRequest(*env_, call_, request);
  if (!room.ok()) {
    HandleEdit(std::move(*request.mutable_edit()), number, Clock::now(), room.status());
    return FinishedReading();
  }
  // A std::function must be copyable, and a reservation is not.
  auto shared_room = std::make_shared<MemoryReservation>(*std::move(room));
  env_->Post(WorkerLanes::Lane::kLong, *call_.account,
             [self = shared_from_this(), request = std::move(request), number,
              room = std::move(shared_room), arrival = Clock::now()] {
               self->HandleEdit(request.edit(), number, arrival, absl::OkStatus());
               room->Release();
               self->FinishedReading();
             });
}

void DeformStream::FinishedReading() {
  {
    const MutexLock lock(&mutex_);
    reading_ = false;
  }
  MaybeRead();
}

void DeformStream::MaybeRead() {
  // Asked before mutex_ is locked, because the stream's mutex comes first in the lock order.
  if (Stream()->backlog() >= limits::kMaxQueuedAnswers) return;
  const MutexLock lock(&mutex_);
  if (!reading_ && !read_pending_ && !ended_) StartReading();
}

void DeformStream::OnCancel() {
  cancelled_ = true;
  StopReading();
  // Without a stream, the pending read fails and ends the call.
  if (const auto stream = Stream(); stream != nullptr) stream->OnCancel();
  if (farewell_.begun()) Leave();
}

void DeformStream::Finish(const grpc::Status& status) {
  if (NeedsFarewell(status)) return Write(farewell_.Begin(status));
  StopReading();
  FinishCall(status);
}

bool DeformStream::NeedsFarewell(const grpc::Status& status) const {
  const grpc::StatusCode code = status.error_code();
  if (!call_.is_proxied || cancelled_) return false;
  if (code == grpc::StatusCode::OK || code == grpc::StatusCode::CANCELLED) return false;
  const MutexLock lock(&mutex_);
  return !half_closed_;
}

void DeformStream::OnFarewellWritten(bool ok) {
  const auto late = [weak = weak_from_this()] {
    if (const auto self = weak.lock(); self != nullptr) self->Leave();
  };
  if (farewell_.Written(ok, late)) {
    StopReading();
    return FinishCall(farewell_.status());
  }
  const MutexLock lock(&mutex_);
  if (!read_pending_ && !ended_) StartReading();
}

bool DeformStream::IsOfFarewell(bool ok, grpc::ByteBuffer& bytes) {
  {
    const MutexLock lock(&mutex_);
    bytes.Swap(&bytes_);  // after a farewell, the next read may begin while this message is handled
    read_pending_ = false;
    if (!ok) ended_ = half_closed_ = true;
    if (!farewell_.begun()) return false;
    if (!ended_) StartReading();  // what comes now is not taken
  }
  if (!ok) Leave();
  return true;
}

void DeformStream::Leave() {
  if (!farewell_.Over()) return;
  StopReading();
  FinishCall(farewell_.status());
}

void DeformStream::End(const absl::Status& status) {
  if (const auto stream = Stream(); stream != nullptr) return stream->Fail(status);
  Finish(ToGrpcStatus(status));
}

absl::Status DeformStream::Open(const v1::DeformRequest& request) {
  if (!request.has_watch()) {
    return error::FailedPrecondition("STREAM_NOT_OPENED", "the first message must be watch");
  }
  NoteScene(call_, request.watch().scene());
  LATTICED_ASSIGN_OR_RETURN(auto open, FromProto(env_, call_, request.watch()));
  editor_id_ = request.watch().editor_id();
  LATTICED_ASSIGN_OR_RETURN(
      auto stream, SceneStream::Open(env_, *call_.account, open.scene, open.options, this));
  {
    const MutexLock lock(&mutex_);
    stream_ = stream;
  }
  token_end_.EndWith(call_.caller, stream);
  stream->Start();
  return absl::OkStatus();
}

absl::Status DeformStream::Handle(const v1::DeformRequest& request, SceneStream& stream) {
  stream.Touch();
  switch (request.message_case()) {
    case v1::DeformRequest::kEdit:
      HandleEdit(request.edit(), stream.ExpectAnswer(), Clock::now(), absl::OkStatus());
      return absl::OkStatus();
    case v1::DeformRequest::kControl:
      return Control(request.control(), stream);
    case v1::DeformRequest::kHeartbeat:
      return absl::OkStatus();
    case v1::DeformRequest::kPresence: {
      v1::ControlWatchRequest control;
      *control.mutable_presence() = request.presence();
      return Control(control, stream);
    }
    case v1::DeformRequest::kWatch:
      return error::InvalidField("watch", "the stream is open already");
    case v1::DeformRequest::MESSAGE_NOT_SET:
      break;
  }
  if (HoldsUnknown(request)) return error::Unsupported("message", "this kind of message");
  return error::InvalidField("message", "one of edit, control, heartbeat and presence must be set");
}

absl::Status DeformStream::Control(const v1::ControlWatchRequest& request, SceneStream& stream) {
  if (request.has_presence()) {
    LATTICED_RETURN_IF_ERROR(CheckRole(call_.caller, kApplyEditsRpc));
  }
  LATTICED_ASSIGN_OR_RETURN(const auto command, FromProto(request, stream.scene()));
  const absl::Status status = stream.Control(command);
  // A stream that has ended meanwhile already has its status.
  return absl::IsNotFound(status) ? absl::OkStatus() : status;
}

void DeformStream::HandleEdit(v1::EditBatch batch, uint64_t number, Clock::time_point arrival,
                              const absl::Status& admitted) {
  if (batch.editor_id().empty()) batch.set_editor_id(editor_id_);
  const EditToAnswer edit{number, batch.sequence(), arrival, Clock::now()};
  Stream()->BeginEdit();
  const absl::Status applied = CatchBadAlloc("the edit", [&]() -> absl::Status {
    LATTICED_RETURN_IF_ERROR(admitted);
    return Apply(batch, [self = shared_from_this(), edit](const auto& summary) {
      self->Answer(edit, summary);
    });
  });
  if (!applied.ok()) Answer(edit, applied);
}

void DeformStream::Answer(const EditToAnswer& edit, const absl::StatusOr<EditSummary>& summary) {
  const auto stream = Stream();
  auto applied = Clock::now();
  v1::SceneEvent event;
  v1::EditResult& result = *event.mutable_edit_result();
  if (summary.ok()) {
    AuditEdit(*env_, call_, stream->scene().id());
    result = ToProto(*summary);
    applied = summary->commit_time.value_or(applied);
  } else {
    env_->calls->NoteRefusal(error::DetailsOf(summary.status()).reason);
    const auto state = stream->scene().State();
    result.set_sequence(edit.sequence);
    *result.mutable_status() = ToRpcStatus(summary.status());
    result.set_revision(state->revision);
    result.set_structure_id(state->structure_id);
  }
  v1::EditTimings& timings = *result.mutable_timings();
  timings.set_queue_us(Microseconds(absl::FromChrono(edit.begun - edit.arrival)));
  timings.set_apply_us(Microseconds(absl::FromChrono(applied - edit.begun)));
  stream->Answer(edit.number, event);
  MaybeRead();
}

absl::Status DeformStream::Apply(const v1::EditBatch& batch, Scene::EditDone done) {
  LATTICED_RETURN_IF_ERROR(CheckRole(call_.caller, kApplyEditsRpc));
  LATTICED_RETURN_IF_ERROR(CheckTokenTime(call_.caller, absl::Now()));
  LATTICED_RETURN_IF_ERROR(CheckDraining(*env_));
  const auto stream = Stream();
  if (!batch.scene().empty() && batch.scene() != IdOf(stream->scene().id())) {
    return error::InvalidField("scene", "is not the scene of the stream", "SCENE_MISMATCH");
  }
  LATTICED_RETURN_IF_ERROR(env_->quotas.TakeEdit(call_.caller.tenant, absl::Now()));
  Scene& scene = stream->mutable_scene();
  const auto stop = [this] {
    return cancelled_ ? absl::CancelledError("the stream was cancelled") : absl::OkStatus();
  };
  scene.SubmitEdits(BatchFromProto(batch, *scene.State()->plan), stop, std::move(done));
  return absl::OkStatus();
}

}  // namespace

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* NewDeformStream(
    const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context) {
  const auto stream = std::make_shared<DeformStream>(rpc, env, context);
  stream->HoldUntilDone();
  return stream.get();
}

}  // namespace latticed
