// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/upload_stream.h"

#include <memory>
#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/base/auth/tenant.h"
#include "server/rpc/access/audit.h"
#include "server/rpc/access/quota_access.h"
#include "server/rpc/access/token_end.h"
#include "server/rpc/call_reactor.h"
#include "server/rpc/first_message.h"
#include "server/rpc/server_env.h"
#include "server/stores/scene_registry.h"
#include "server/wire/mesh_header.h"
#include "server/wire/message_bytes.h"
#include "server/wire/stored_mesh.h"

namespace latticed {
namespace {

// The most bytes that a mesh's reply grows by when the mesh is stored: its creation time, and counts of scenes
// that may have been made since.
constexpr uint64_t kStillToCome = 256;

class UploadStream final : public CallReactor<grpc::ServerReadReactor<grpc::ByteBuffer>> {
 public:
  UploadStream(const Rpc& rpc, ServerEnv* env, grpc::CallbackServerContext* context,
               grpc::ByteBuffer* reply)
      : env_(env), reply_(reply) {
    if (!Begin(*env, context, rpc)) return;
    reply_room_.Open(*env, call_);
    first_message_.Await(env->options.first_message_timeout, "the header",
                         [this](const absl::Status& late) { End(late); });
    StartRead(&bytes_);
  }

  void OnReadDone(bool ok) override {
    if (!first_message_.Arrive()) return;
    if (!ok) return OnAllRead();
    const absl::Status status = CatchBadAlloc("the upload", [this] { return Take(); });
    if (!status.ok()) return End(status);
    StartRead(&bytes_);
  }

 private:
  absl::Status Take() {
    LATTICED_RETURN_IF_ERROR(CheckTokenTime(call_.caller, absl::Now()));
    v1::UploadMeshRequest request;
    LATTICED_RETURN_IF_ERROR(TakeMessage(bytes_, &request));
    if (upload_ == nullptr) return TakeHeader(request);
    if (request.has_data()) return upload_->Append(request.data());
    return error::InvalidField("header", "must be the first message and must not be repeated");
  }

  absl::Status TakeHeader(const v1::UploadMeshRequest& request) {
    if (!request.has_header()) return NotOpened();
    LATTICED_ASSIGN_OR_RETURN(UploadHeader header,
                              FromProto(request.header(), env_->options.max_mesh_bytes));
    header.mesh.owner = call_.caller.name;
    header.mesh.tenant = call_.caller.tenant;
    LATTICED_RETURN_IF_ERROR(CheckUploadQuota(*env_, header));
    LATTICED_ASSIGN_OR_RETURN(upload_, env_->uploads->Admit(std::move(header), *call_.account));
    StartSendInitialMetadata();  // a client may wait for it before it sends its bytes
    return absl::OkStatus();
  }

  // The client has half-closed the stream, or has gone.
  void OnAllRead() {
    if (call_.context->IsCancelled()) return End(absl::CancelledError("the caller cancelled"));
    if (upload_ == nullptr) return End(NotOpened());
    env_->Post(WorkerLanes::Lane::kLong, *call_.account,
               [this] { End(CatchBadAlloc("the upload", [this] { return Store(); })); });
  }

  absl::Status Store() {
    LATTICED_RETURN_IF_ERROR(CheckTokenTime(call_.caller, absl::Now()));
    v1::Mesh mesh;
    LATTICED_RETURN_IF_ERROR(StoreUpload(*env_, call_, *upload_, reply_room_, mesh));
    *reply_ = ToBytes(mesh);
    return absl::OkStatus();
  }

  void End(const absl::Status& result) {
    upload_.reset();  // its memory is free before the client gets the status
    FinishCall(result);
  }

  static absl::Status NotOpened() {
    return error::FailedPrecondition("STREAM_NOT_OPENED", "the first message must be the header");
  }

  ServerEnv* const env_;
  grpc::ByteBuffer* const reply_;
  FirstMessage first_message_;
  grpc::ByteBuffer bytes_;          // of the message that comes next
  std::shared_ptr<Upload> upload_;  // null until the header is admitted
  ReplyRoom reply_room_;
};

}  // namespace

absl::Status StoreUpload(ServerEnv& env, const CallInfo& call, Upload& upload, ReplyRoom& room,
                         v1::Mesh& reply) {
  const auto describe = [&env](const StoredMesh& mesh) {
    return ToProto(mesh, env.scenes->UseOfMesh(mesh.id), true);
  };
  LATTICED_ASSIGN_OR_RETURN(CompleteUpload complete, upload.Take());
  LATTICED_ASSIGN_OR_RETURN(
      StoredMesh made,
      ReadStoredMesh(std::move(complete.header), std::move(complete.bytes), complete.reservation,
                     [&call] { return CheckCancelled(call); }));
  LATTICED_RETURN_IF_ERROR(room.Hold(ReplyBytes(describe(made)) + kStillToCome));
  bool is_new = false;
  const auto admit = [&env, &is_new, tenant = made.tenant,
                      bytes = made.bytes->size()](const MeshStore::Arriving& arriving) {
    is_new = true;
    return CheckMeshQuota(env, tenant, arriving, bytes);
  };
  LATTICED_ASSIGN_OR_RETURN(
      const auto mesh, env.meshes.Add(std::move(made), std::move(complete.reservation), admit));
  if (is_new) {
    Audit(env, call, "mesh_created", {{"mesh", std::string(IdOf(mesh->id))}, {"name", mesh->name}});
  }
  reply = describe(*mesh);
  // This needs more memory only if the mesh was stored before, with other labels.
  return room.Hold(ReplyBytes(reply));
}

grpc::ServerReadReactor<grpc::ByteBuffer>* NewUploadStream(const Rpc& rpc, ServerEnv* env,
                                                           grpc::CallbackServerContext* context,
                                                           grpc::ByteBuffer* reply) {
  return new UploadStream(rpc, env, context, reply);
}

}  // namespace latticed
