// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// MeshService.DownloadMesh: header, then the uploaded bytes from the asked offset in parts.
#ifndef LATTICED_SERVER_RPC_DOWNLOAD_STREAM_H_
#define LATTICED_SERVER_RPC_DOWNLOAD_STREAM_H_

#include <grpcpp/grpcpp.h>

#include "latticed/v1/mesh.pb.h"

namespace latticed {

struct ServerEnv;

// The reactor of one call; it deletes itself when the call is done. `env` outlives the server.
[[nodiscard]] grpc::ServerWriteReactor<v1::DownloadMeshResponse>* NewDownloadStream(
    ServerEnv* env, grpc::CallbackServerContext* context, const v1::DownloadMeshRequest& request);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_DOWNLOAD_STREAM_H_
