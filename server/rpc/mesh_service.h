// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// MeshService: validate, fetch, act, convert. Uploads by stream are in upload_stream; what an rpc
// means is written in mesh.proto.
//
// Threads  handlers may run at the same time; the work is on env->workers
#ifndef LATTICED_SERVER_RPC_MESH_SERVICE_H_
#define LATTICED_SERVER_RPC_MESH_SERVICE_H_

#include "latticed/v1/mesh.grpc.pb.h"
#include "server/rpc/server_env.h"

namespace latticed {

class MeshService final : public v1::MeshService::CallbackService {
 public:
  explicit MeshService(ServerEnv* env) : env_(env) {}

  grpc::ServerReadReactor<v1::UploadMeshRequest>* UploadMesh(grpc::CallbackServerContext* context,
                                                             v1::Mesh* response) override;
  grpc::ServerUnaryReactor* BeginUpload(grpc::CallbackServerContext* context,
                                        const v1::BeginUploadRequest* request,
                                        v1::BeginUploadResponse* response) override;
  grpc::ServerUnaryReactor* AppendUpload(grpc::CallbackServerContext* context,
                                         const v1::AppendUploadRequest* request,
                                         v1::AppendUploadResponse* response) override;
  grpc::ServerUnaryReactor* FinishUpload(grpc::CallbackServerContext* context,
                                         const v1::FinishUploadRequest* request,
                                         v1::Mesh* response) override;
  grpc::ServerUnaryReactor* GetMesh(grpc::CallbackServerContext* context,
                                    const v1::GetMeshRequest* request, v1::Mesh* response) override;
  grpc::ServerUnaryReactor* ListMeshes(grpc::CallbackServerContext* context,
                                       const v1::ListMeshesRequest* request,
                                       v1::ListMeshesResponse* response) override;
  grpc::ServerUnaryReactor* DeleteMesh(grpc::CallbackServerContext* context,
                                       const v1::DeleteMeshRequest* request,
                                       v1::DeleteMeshResponse* response) override;
  grpc::ServerWriteReactor<v1::DownloadMeshResponse>* DownloadMesh(
      grpc::CallbackServerContext* context, const v1::DownloadMeshRequest* request) override;

 private:
  ServerEnv* const env_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_MESH_SERVICE_H_
