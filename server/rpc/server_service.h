// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// ServerService: what this server is and can do.
//
// Threads  safe
#ifndef LATTICED_SERVER_RPC_SERVER_SERVICE_H_
#define LATTICED_SERVER_RPC_SERVER_SERVICE_H_

#include <memory>

#include <grpcpp/impl/codegen/service_type.h>

#include "latticed/v1/server.pb.h"

namespace latticed {

struct ServerEnv;

// The whole answer of GetServerInfo.
[[nodiscard]] v1::ServerInfo DescribeServer(ServerEnv& env);

// `env` outlives the server.
[[nodiscard]] std::unique_ptr<grpc::Service> MakeServerService(ServerEnv* env);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SERVER_SERVICE_H_
