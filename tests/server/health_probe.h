// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the standard health service says, as a balancer asks it.
#ifndef LATTICED_TESTS_SERVER_HEALTH_PROBE_H_
#define LATTICED_TESTS_SERVER_HEALTH_PROBE_H_

#include <chrono>
#include <memory>
#include <string>

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include "fmt/format.h"

namespace latticed::testing {

inline constexpr const char* kHealthNames[] = {
    "", "latticed.v1.MeshService", "latticed.v1.SceneService", "latticed.v1.ServerService"};

// grpc.health.v1.Health/Check by its wire bytes: request {string service = 1}, response
// {enum status = 1}, 1 = SERVING, 2 = NOT_SERVING. Returns "1", "2", or the code of the error.
inline std::string Health(const std::shared_ptr<grpc::Channel>& channel,
                          const std::string& service) {
  std::string bytes;
  if (!service.empty()) bytes = fmt::format("\n{}{}", static_cast<char>(service.size()), service);
  grpc::Slice slice(bytes);
  const grpc::ByteBuffer request(&slice, 1);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
  grpc::ByteBuffer response;
  grpc::Status status;
  grpc::CompletionQueue queue;
  grpc::GenericStub stub(channel);
  const auto call =
      stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", request, &queue);
  call->StartCall();
  call->Finish(&response, &status, &status);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  queue.Shutdown();
  if (!status.ok()) return fmt::format("code {}", static_cast<int>(status.error_code()));
  grpc::Slice answer;
  (void)response.DumpToSingleSlice(&answer);
  return answer.size() == 2 ? fmt::format("{}", answer.begin()[1]) : "malformed";
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_HEALTH_PROBE_H_
