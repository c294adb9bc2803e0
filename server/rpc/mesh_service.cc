// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/mesh_service.h"

#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/base/labels.h"
#include "server/rpc/call.h"
#include "server/rpc/file_parts.h"
#include "server/rpc/part_stream.h"
#include "server/rpc/store_upload.h"
#include "server/rpc/unary_call.h"
#include "server/rpc/upload_stream.h"
#include "server/stores/scene_registry.h"
#include "server/stores/upload_store.h"
#include "server/wire/mesh_header.h"
#include "server/wire/time_converters.h"

namespace latticed {
namespace {

// Ids of meshes are hashes, and tokens are ids.
bool IsSha256Hex(std::string_view text) {
  constexpr size_t kDigits = 64;
  return text.size() == kDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

absl::Status DeleteMeshNow(ServerEnv& env, const CallInfo& call,
                           const v1::DeleteMeshRequest& request) {
  if (request.force() && call.caller.role < Role::kAdmin) {
    return error::PermissionDenied(
        "force: deletes the scenes of others as well, so it needs the role 'admin'",
        RoleName(Role::kAdmin));
  }
  LATTICED_ASSIGN_OR_RETURN(
      const auto mesh,
      env.meshes.Find(request.mesh()));  // and held, to be destroyed after the locks
  return env.scenes->DeleteMesh(request.mesh(), request.force(),
                                [&] { return env.meshes.Remove(request.mesh()); });
}

absl::Status ListMeshesNow(ServerEnv& env, const v1::ListMeshesRequest& request,
                           v1::ListMeshesResponse& response) {
  LATTICED_ASSIGN_OR_RETURN(const size_t page_size, PageSize(request.page_size()));
  LATTICED_ASSIGN_OR_RETURN(const LabelFilter filter, LabelFilter::Parse(request.filter()));
  if (!request.page_token().empty() && !IsSha256Hex(request.page_token())) {
    return error::InvalidField("page_token", "is none that this server gave out");
  }
  const auto accept = [&filter](const StoredMesh& mesh) { return filter.Matches(mesh.labels); };
  // A page token is the last id of the page before; one more mesh than asked tells whether another
  // page follows.
  PageRoom room(page_size);
  for (const auto& mesh : env.meshes.List(request.page_token(), page_size + 1, accept)) {
    v1::Mesh item = ToProto(*mesh, env.scenes->UseOfMesh(mesh->id), false);
    if (!room.Take(item.ByteSizeLong())) {
      response.set_next_page_token(response.meshes().rbegin()->id());
      break;
    }
    *response.add_meshes() = std::move(item);
  }
  return absl::OkStatus();
}

using Download = PartStream<v1::DownloadMeshResponse>;

absl::StatusOr<Download::Next> OpenDownload(ServerEnv& env,
                                            const v1::DownloadMeshRequest& request) {
  LATTICED_ASSIGN_OR_RETURN(auto mesh, env.meshes.Find(request.mesh()));
  const size_t size = mesh->bytes->size();
  if (request.offset() > size) {
    return error::OutOfRange("offset", static_cast<double>(request.offset()), 0,
                             static_cast<double>(size));
  }
  return FileParts<v1::DownloadMeshResponse>(HeaderOf(*mesh), {mesh, mesh->bytes.get()},
                                             request.offset());
}

}  // namespace

grpc::ServerReadReactor<v1::UploadMeshRequest>* MeshService::UploadMesh(
    grpc::CallbackServerContext* context, v1::Mesh* response) {
  return NewUploadStream(env_, context, response);
}

grpc::ServerUnaryReactor* MeshService::BeginUpload(grpc::CallbackServerContext* context,
                                                   const v1::BeginUploadRequest* request,
                                                   v1::BeginUploadResponse* response) {
  return RunUnary(env_, context, "MeshService/BeginUpload", *request, response,
                  [=, this](const CallInfo& call) {
                    LATTICED_ASSIGN_OR_RETURN(
                        UploadHeader header,
                        FromProto(request->header(), env_->options.max_mesh_bytes));
                    header.mesh.owner = call.caller.name;
                    LATTICED_ASSIGN_OR_RETURN(auto upload, env_->uploads->Admit(std::move(header)));
                    response->set_upload_id(env_->uploads->Keep(std::move(upload)));
                    SetTime(env_->uploads->ExpireTime(), *response->mutable_expire_time());
                    return absl::OkStatus();
                  });
}

grpc::ServerUnaryReactor* MeshService::AppendUpload(grpc::CallbackServerContext* context,
                                                    const v1::AppendUploadRequest* request,
                                                    v1::AppendUploadResponse* response) {
  return RunUnary(
      env_, context, "MeshService/AppendUpload", *request, response, [=, this](const CallInfo&) {
        LATTICED_ASSIGN_OR_RETURN(const auto upload, env_->uploads->Find(request->upload_id()));
        LATTICED_ASSIGN_OR_RETURN(const auto committed,
                                  upload->AppendAt(request->offset(), request->data()));
        response->set_committed(committed);
        SetTime(env_->uploads->ExpireTime(), *response->mutable_expire_time());
        return absl::OkStatus();
      });
}

grpc::ServerUnaryReactor* MeshService::FinishUpload(grpc::CallbackServerContext* context,
                                                    const v1::FinishUploadRequest* request,
                                                    v1::Mesh* response) {
  return RunUnary(
      env_, context, "MeshService/FinishUpload", *request, response,
      [=, this](const CallInfo&, ReplyRoom& room) {
        LATTICED_ASSIGN_OR_RETURN(const auto upload, env_->uploads->Take(request->upload_id()));
        return StoreUpload(
            *env_, *upload, [context] { return context->IsCancelled(); }, room, *response);
      });
}

grpc::ServerUnaryReactor* MeshService::GetMesh(grpc::CallbackServerContext* context,
                                               const v1::GetMeshRequest* request,
                                               v1::Mesh* response) {
  return RunUnary(env_, context, "MeshService/GetMesh", *request, response,
                  [=, this](const CallInfo&) {
                    LATTICED_ASSIGN_OR_RETURN(const auto mesh, env_->meshes.Find(request->mesh()));
                    *response = ToProto(*mesh, env_->scenes->UseOfMesh(mesh->id), true);
                    return absl::OkStatus();
                  });
}

grpc::ServerUnaryReactor* MeshService::ListMeshes(grpc::CallbackServerContext* context,
                                                  const v1::ListMeshesRequest* request,
                                                  v1::ListMeshesResponse* response) {
  return RunUnary(env_, context, "MeshService/ListMeshes", *request, response,
                  [=, this](const CallInfo&) { return ListMeshesNow(*env_, *request, *response); });
}

grpc::ServerUnaryReactor* MeshService::DeleteMesh(grpc::CallbackServerContext* context,
                                                  const v1::DeleteMeshRequest* request,
                                                  v1::DeleteMeshResponse* response) {
  return RunUnary(env_, context, "MeshService/DeleteMesh", *request, response,
                  [=, this](const CallInfo& call) { return DeleteMeshNow(*env_, call, *request); });
}

grpc::ServerWriteReactor<v1::DownloadMeshResponse>* MeshService::DownloadMesh(
    grpc::CallbackServerContext* context, const v1::DownloadMeshRequest* request) {
  return new Download(env_, context, "MeshService/DownloadMesh", *request, "",
                      [=, this](const auto&) { return OpenDownload(*env_, *request); });
}

}  // namespace latticed
