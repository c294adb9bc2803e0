// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// ServerService: what this server is and can do.
#ifndef LATTICED_SERVER_RPC_SERVER_SERVICE_H_
#define LATTICED_SERVER_RPC_SERVER_SERVICE_H_

#include "latticed/v1/server.grpc.pb.h"
#include "server/rpc/server_env.h"

namespace latticed {

// All that it answers.
[[nodiscard]] v1::ServerInfo DescribeServer(ServerEnv& env);

class ServerService final : public v1::ServerService::CallbackService {
 public:
  explicit ServerService(ServerEnv* env) : env_(env) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest* request,
                                          v1::ServerInfo* response) override;

 private:
  ServerEnv* const env_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SERVER_SERVICE_H_
