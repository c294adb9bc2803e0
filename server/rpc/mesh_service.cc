// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "latticed/v1/mesh.grpc.pb.h"
#include "server/base/auth/tenant.h"
#include "server/base/labels.h"
#include "server/rpc/access/audit.h"
#include "server/rpc/access/quota_access.h"
#include "server/rpc/access/tenant_access.h"
#include "server/rpc/method.h"
#include "server/rpc/server_env.h"
#include "server/rpc/services.h"
#include "server/rpc/upload_stream.h"
#include "server/stores/scene_registry.h"
#include "server/stores/upload_store.h"
#include "server/wire/mesh_header.h"
#include "server/wire/stored_mesh.h"
#include "server/wire/time_converters.h"

namespace latticed {
namespace {

using Context = grpc::CallbackServerContext;
using Bytes = grpc::ByteBuffer;
using UnaryReactor = grpc::ServerUnaryReactor;
using Writer = grpc::ServerWriteReactor<Bytes>;

absl::Status BeginUpload(const CallContext& context, const v1::BeginUploadRequest& request,
                         v1::BeginUploadResponse& response) {
  UploadStore& uploads = *context.env.uploads;
  LATTICED_ASSIGN_OR_RETURN(UploadHeader header,
                            FromProto(request.header(), context.env.options.max_mesh_bytes));
  header.mesh.owner = context.call.caller.name;
  header.mesh.tenant = context.call.caller.tenant;
  LATTICED_RETURN_IF_ERROR(CheckUploadQuota(context.env, header));
  LATTICED_ASSIGN_OR_RETURN(auto upload, uploads.Admit(std::move(header), *context.call.account));
  response.set_upload_id(uploads.Keep(std::move(upload), context.call.caller.tenant));
  SetTime(uploads.ExpireTime(), *response.mutable_expire_time());
  return absl::OkStatus();
}

absl::Status AppendUpload(const CallContext& context, const v1::AppendUploadRequest& request,
                          v1::AppendUploadResponse& response) {
  UploadStore& uploads = *context.env.uploads;
  LATTICED_ASSIGN_OR_RETURN(const auto upload,
                            uploads.Find(KeyFor(context.call, request.upload_id())));
  LATTICED_ASSIGN_OR_RETURN(const auto committed,
                            upload->AppendAt(request.offset(), request.data()));
  response.set_committed(committed);
  SetTime(uploads.ExpireTime(), *response.mutable_expire_time());
  return absl::OkStatus();
}

absl::Status FinishUpload(const CallContext& context, const v1::FinishUploadRequest& request,
                          v1::Mesh& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto upload,
                            context.env.uploads->Take(KeyFor(context.call, request.upload_id())));
  return StoreUpload(context.env, context.call, *upload, context.room, response);
}

absl::Status GetMesh(const CallContext& context, const v1::GetMeshRequest& request,
                     v1::Mesh& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, FindMesh(context.env, context.call, request.mesh()));
  // Of other scenes a guest is told nothing.
  const bool is_guest = context.call.caller.shared.has_value();
  response = ToProto(*mesh, is_guest ? MeshUse() : context.env.scenes->UseOfMesh(mesh->id), true);
  return absl::OkStatus();
}

absl::Status DeleteMesh(const CallContext& context, const v1::DeleteMeshRequest& request,
                        v1::DeleteMeshResponse&) {
  ServerEnv& env = context.env;
  if (request.force() && context.call.caller.role < Role::kAdmin) {
    return error::PermissionDenied(
        "force: deletes the scenes of others as well, so it needs the role 'admin'",
        RoleName(Role::kAdmin));
  }
  const std::string key = KeyFor(context.call, request.mesh());
  const auto held = env.meshes.InMemory(key);  // so that it is destroyed after the locks
  const absl::Status deleted =
      env.scenes->DeleteMesh(key, request.force(), [&] { return env.meshes.Remove(key); });
  if (deleted.ok()) {
    Audit(env, context.call, "mesh_deleted",
          {{"mesh", request.mesh()}, {"with_scenes", request.force() ? "true" : "false"}});
  }
  return ToldById(deleted, "mesh", request.mesh());
}

// Reads the mesh if its header does not tell enough. The errors of MeshStore::Find.
absl::StatusOr<v1::Mesh> Listed(ServerEnv& env, const ListedMesh& mesh, const MeshUse& use) {
  if (mesh.mesh != nullptr) return ToProto(*mesh.mesh, use, false);
  if (auto item = ListedFromStored(mesh.header); item.ok()) {
    item->set_scenes(use.scenes);
    return item;
  }
  LATTICED_ASSIGN_OR_RETURN(const auto found, env.meshes.Find(mesh.id));
  return ToProto(*found, use, false);
}

absl::Status ListMeshes(const CallContext& context, const v1::ListMeshesRequest& request,
                        v1::ListMeshesResponse& response) {
  ServerEnv& env = context.env;
  LATTICED_ASSIGN_OR_RETURN(const size_t page_size, PageSize(request.page_size()));
  LATTICED_ASSIGN_OR_RETURN(const LabelFilter filter, LabelFilter::Parse(request.filter()));
  // A page token is the last mesh id of the page before, and mesh ids are SHA-256 hashes.
  if (!request.page_token().empty() && !IsSha256Hex(request.page_token())) {
    return error::InvalidField("page_token", "was not issued by this server");
  }
  PageRoom room(page_size);
  LATTICED_ASSIGN_OR_RETURN(const auto meshes, env.meshes.List());
  LATTICED_ASSIGN_OR_RETURN(auto uses, env.scenes->UseOfMeshes());
  for (const ListedMesh& mesh : meshes) {
    if (TenantOf(mesh.id) != context.call.caller.tenant) continue;
    if (IdOf(mesh.id) <= request.page_token()) continue;
    auto item = Listed(env, mesh, uses[mesh.id]);
    // Damaged ones are left out.
    if (absl::IsDataLoss(item.status()) || absl::IsNotFound(item.status())) continue;
    LATTICED_RETURN_IF_ERROR(item.status());
    if (!filter.Matches({item->labels().begin(), item->labels().end()})) continue;
    if (!room.Take(item->ByteSizeLong())) {
      response.set_next_page_token(response.meshes().rbegin()->id());
      break;
    }
    *response.add_meshes() = *std::move(item);
  }
  return absl::OkStatus();
}

absl::StatusOr<NextPart<v1::DownloadMeshResponse>> OpenDownload(
    const CallContext& context, const v1::DownloadMeshRequest& request) {
  LATTICED_ASSIGN_OR_RETURN(auto mesh, FindMesh(context.env, context.call, request.mesh()));
  const size_t size = mesh->bytes->size();
  if (request.offset() > size) {
    return error::OutOfRange("offset", static_cast<double>(request.offset()), 0,
                             static_cast<double>(size));
  }
  return FileParts<v1::DownloadMeshResponse>(HeaderOf(*mesh), {mesh, mesh->bytes.get()},
                                             request.offset());
}

// Every rpc of the service: name, role, handler.
constexpr Rpc kUploadMesh{"MeshService/UploadMesh", Role::kEdit};
constexpr UnaryMethod kBeginUpload{Rpc{"MeshService/BeginUpload", Role::kEdit}, BeginUpload};
constexpr UnaryMethod kAppendUpload{Rpc{"MeshService/AppendUpload", Role::kEdit}, AppendUpload};
constexpr UnaryMethod kFinishUpload{Rpc{"MeshService/FinishUpload", Role::kEdit}, FinishUpload,
                                    Lane::kLong};
constexpr UnaryMethod kGetMesh{Rpc{"MeshService/GetMesh", Role::kRead, kForShares}, GetMesh};
constexpr UnaryMethod kListMeshes{Rpc{"MeshService/ListMeshes", Role::kRead}, ListMeshes,
                                  Lane::kLong};
constexpr UnaryMethod kDeleteMesh{Rpc{"MeshService/DeleteMesh", Role::kEdit}, DeleteMesh,
                                  Lane::kLong};
constexpr PartMethod kDownloadMesh{Rpc{"MeshService/DownloadMesh", Role::kRead, kForShares},
                                   OpenDownload, Parts::kCopied};

// Every rpc takes and gives bytes (server/wire/message_bytes.h).
using M = v1::MeshService;
using Uploads = M::WithRawCallbackMethod_UploadMesh<M::WithRawCallbackMethod_BeginUpload<
    M::WithRawCallbackMethod_AppendUpload<M::WithRawCallbackMethod_FinishUpload<M::Service>>>>;
using MeshServiceBase = M::WithRawCallbackMethod_GetMesh<M::WithRawCallbackMethod_ListMeshes<
    M::WithRawCallbackMethod_DeleteMesh<M::WithRawCallbackMethod_DownloadMesh<Uploads>>>>;

class MeshServiceImpl final : public MeshServiceBase {
 public:
  explicit MeshServiceImpl(ServerEnv* env) : env_(env) {}

  grpc::ServerReadReactor<Bytes>* UploadMesh(Context* context, Bytes* response) override {
    return NewUploadStream(kUploadMesh, env_, context, response);
  }
  UnaryReactor* BeginUpload(Context* context, const Bytes* request, Bytes* response) override {
    return kBeginUpload.Run(env_, context, request, response);
  }
  UnaryReactor* AppendUpload(Context* context, const Bytes* request, Bytes* response) override {
    return kAppendUpload.Run(env_, context, request, response);
  }
  UnaryReactor* FinishUpload(Context* context, const Bytes* request, Bytes* response) override {
    return kFinishUpload.Run(env_, context, request, response);
  }
  UnaryReactor* GetMesh(Context* context, const Bytes* request, Bytes* response) override {
    return kGetMesh.Run(env_, context, request, response);
  }
  UnaryReactor* ListMeshes(Context* context, const Bytes* request, Bytes* response) override {
    return kListMeshes.Run(env_, context, request, response);
  }
  UnaryReactor* DeleteMesh(Context* context, const Bytes* request, Bytes* response) override {
    return kDeleteMesh.Run(env_, context, request, response);
  }
  Writer* DownloadMesh(Context* context, const Bytes* request) override {
    return kDownloadMesh.Run(env_, context, request);
  }

 private:
  ServerEnv* const env_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeMeshService(ServerEnv* env) {
  return std::make_unique<MeshServiceImpl>(env);
}

}  // namespace latticed
