// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// MeshService: uploads, lists, returns and deletes meshes. mesh.proto says what each rpc does and refuses;
// uploads by stream are in upload_stream.h.
//
// Threads  safe; the work of every rpc runs on env->workers
#ifndef LATTICED_SERVER_RPC_MESH_SERVICE_H_
#define LATTICED_SERVER_RPC_MESH_SERVICE_H_

#include <memory>

#include <grpcpp/impl/codegen/service_type.h>

namespace latticed {

struct ServerEnv;

// `env` outlives the server.
[[nodiscard]] std::unique_ptr<grpc::Service> MakeMeshService(ServerEnv* env);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_MESH_SERVICE_H_
