// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/download_stream.h"

#include <algorithm>
#include <memory>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "server/rpc/call.h"
#include "server/rpc/server_env.h"
#include "server/wire/grpc_status.h"
#include "server/wire/mesh_header.h"

namespace latticed {
namespace {

class DownloadStream final : public grpc::ServerWriteReactor<v1::DownloadMeshResponse> {
 public:
  DownloadStream(ServerEnv* env, grpc::CallbackServerContext* context,
                 const v1::DownloadMeshRequest& request) {
    absl::StatusOr<CallInfo> call = BeginCall(*env, context, "MeshService/DownloadMesh");
    if (!call.ok()) {
      Finish(ToGrpcStatus(call.status()));
      return;
    }
    call_ = *std::move(call);
    if (const absl::Status status = Open(*env, request); !status.ok()) {
      End(status);
      return;
    }
    *response_.mutable_header() = HeaderOf(*mesh_);
    StartWrite(&response_);
  }

  void OnWriteDone(bool ok) override {
    if (!ok) return End(absl::CancelledError("the caller is gone"));
    const std::string& bytes = *mesh_->bytes;
    if (next_ == bytes.size()) return End(absl::OkStatus());
    const size_t count = std::min(limits::kMaxPartBytes, bytes.size() - next_);
    response_.set_data(bytes.data() + next_, count);
    next_ += count;
    StartWrite(&response_);
  }

  void OnDone() override { delete this; }

 private:
  absl::Status Open(ServerEnv& env, const v1::DownloadMeshRequest& request) {
    auto mesh = env.meshes.Find(request.mesh());
    if (!mesh.ok()) return mesh.status();
    mesh_ = *std::move(mesh);
    if (request.offset() > mesh_->bytes->size()) {
      return error::OutOfRange("offset", static_cast<double>(request.offset()), 0,
                               static_cast<double>(mesh_->bytes->size()));
    }
    next_ = request.offset();
    return absl::OkStatus();
  }

  void End(const absl::Status& result) {
    const grpc::Status status = ToGrpcStatus(result);
    LogFinished(call_, status);
    Finish(status);
  }

  CallInfo call_;
  std::shared_ptr<const StoredMesh> mesh_;
  size_t next_ = 0;  // first byte not sent
  v1::DownloadMeshResponse response_;
};

}  // namespace

grpc::ServerWriteReactor<v1::DownloadMeshResponse>* NewDownloadStream(
    ServerEnv* env, grpc::CallbackServerContext* context, const v1::DownloadMeshRequest& request) {
  return new DownloadStream(env, context, request);
}

}  // namespace latticed
