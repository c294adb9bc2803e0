// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The services of latticed.v1. What each rpc does and refuses is in proto/latticed/v1; each service's
// file ends with the table of its rpcs.
//
// Threads  safe; handlers run on the workers of ServerEnv
#ifndef LATTICED_SERVER_RPC_SERVICES_H_
#define LATTICED_SERVER_RPC_SERVICES_H_

#include <memory>

#include <grpcpp/impl/codegen/service_type.h>

#include "latticed/v1/server.pb.h"

namespace latticed {

struct ServerEnv;

// `env` outlives the server.
[[nodiscard]] std::unique_ptr<grpc::Service> MakeMeshService(ServerEnv* env);
[[nodiscard]] std::unique_ptr<grpc::Service> MakeSceneService(ServerEnv* env);
[[nodiscard]] std::unique_ptr<grpc::Service> MakeServerService(ServerEnv* env);
[[nodiscard]] std::unique_ptr<grpc::Service> MakeBackupService(ServerEnv* env);
[[nodiscard]] std::unique_ptr<grpc::Service> MakeShareService(ServerEnv* env);
[[nodiscard]] std::unique_ptr<grpc::Service> MakePointSetService(ServerEnv* env);

// The whole answer of GetServerInfo.
[[nodiscard]] v1::ServerInfo DescribeServer(ServerEnv& env);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SERVICES_H_
