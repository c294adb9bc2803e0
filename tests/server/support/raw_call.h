// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Unary calls whose messages are plain bytes: to any method, and to the standard health service, as load
// balancers call it.
#ifndef LATTICED_TESTS_SERVER_SUPPORT_RAW_CALL_H_
#define LATTICED_TESTS_SERVER_SUPPORT_RAW_CALL_H_

#include <chrono>
#include <memory>
#include <string>

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include "fmt/format.h"

namespace latticed::testing {

inline constexpr const char* kHealthNames[] = {
    "", "latticed.v1.MeshService", "latticed.v1.SceneService", "latticed.v1.ServerService",
    "latticed.v1.PointSetService"};

// `method` is "/package.Service/Method". `authorization` is sent as metadata of that name, unless it is empty.
inline grpc::Status RawCall(const std::shared_ptr<grpc::Channel>& channel,
                            const std::string& method, const std::string& bytes,
                            std::string* answer = nullptr, const std::string& authorization = "") {
  const grpc::Slice slice(bytes);
  const grpc::ByteBuffer request(&slice, 1);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
  if (!authorization.empty()) context.AddMetadata("authorization", authorization);
  grpc::ByteBuffer response;
  grpc::Status status;
  grpc::CompletionQueue queue;
  grpc::GenericStub stub(channel);
  const auto call = stub.PrepareUnaryCall(&context, method, request, &queue);
  call->StartCall();
  call->Finish(&response, &status, &status);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  queue.Shutdown();
  grpc::Slice whole;
  if (status.ok() && answer != nullptr && response.DumpToSingleSlice(&whole).ok()) {
    *answer = {reinterpret_cast<const char*>(whole.begin()), whole.size()};
  }
  return status;
}

// grpc.health.v1.Health/Check: request {string service = 1}, response {enum status = 1}, 1 = SERVING,
// 2 = NOT_SERVING. Returns "1", "2", "code N" for an error, or "malformed".
inline std::string Health(const std::shared_ptr<grpc::Channel>& channel,
                          const std::string& service) {
  std::string bytes, answer;
  if (!service.empty()) bytes = fmt::format("\n{}{}", static_cast<char>(service.size()), service);
  const grpc::Status status = RawCall(channel, "/grpc.health.v1.Health/Check", bytes, &answer);
  if (!status.ok()) return fmt::format("code {}", static_cast<int>(status.error_code()));
  return answer.size() == 2 ? fmt::format("{}", answer[1] + 0) : "malformed";
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SUPPORT_RAW_CALL_H_
