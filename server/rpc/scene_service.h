// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneService: scenes made, listed, edited, evaluated and exported. What each rpc does and refuses
// is in proto/latticed/v1/scene.proto; the streams that carry chunks are deform_stream.h,
// watch_stream.h and get_update.h.
//
// Threads  safe; the work of every rpc runs on env->workers
#ifndef LATTICED_SERVER_RPC_SCENE_SERVICE_H_
#define LATTICED_SERVER_RPC_SCENE_SERVICE_H_

#include <memory>

#include <grpcpp/impl/codegen/service_type.h>

namespace latticed {

struct ServerEnv;

// `env` outlives the server.
[[nodiscard]] std::unique_ptr<grpc::Service> MakeSceneService(ServerEnv* env);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SCENE_SERVICE_H_
