// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reflection, asked by the wire bytes of its messages, as grpcurl asks it.
#include <grpcpp/generic/generic_stub.h>

#include "tests/server/test_env.h"

namespace latticed::testing {
namespace {

// One message there and one back; every call is a stream on the wire.
grpc::Status Ask(TestEnv& env, const std::string& method, const std::string& request,
                 std::string* response) {
  grpc::GenericStub stub(env.channel());
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30));
  grpc::CompletionQueue queue;
  const auto stream = stub.PrepareCall(&context, method, &queue);
  void* tag = nullptr;
  bool ok = false;
  const auto wait = [&] { queue.Next(&tag, &ok); };
  stream->StartCall(nullptr);
  wait();
  const grpc::Slice slice(request);
  stream->Write(grpc::ByteBuffer(&slice, 1), nullptr);
  wait();
  stream->WritesDone(nullptr);
  wait();
  grpc::ByteBuffer buffer;
  stream->Read(&buffer, nullptr);
  wait();
  std::vector<grpc::Slice> slices;
  EXPECT_TRUE(!ok || buffer.Dump(&slices).ok());
  for (const grpc::Slice& part : slices) {
    response->append(reinterpret_cast<const char*>(part.begin()), part.size());
  }
  grpc::Status status;
  stream->Finish(&status, nullptr);
  wait();
  return status;
}

// A field of wire type 2 of less than 128 bytes.
std::string Field(int number, const std::string& bytes) {
  return std::string{static_cast<char>(number << 3 | 2), static_cast<char>(bytes.size())} + bytes;
}

TEST(ReflectionTest, ListsTheThreeServices) {
  TestEnv env;
  std::string response;
  const grpc::Status status =
      Ask(env, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", Field(7, "*"),
          &response);

  EXPECT_TRUE(status.ok()) << status.error_message();
  for (const char* service :
       {"latticed.v1.MeshService", "latticed.v1.SceneService", "latticed.v1.ServerService"}) {
    EXPECT_NE(response.find(Field(1, service)), std::string::npos) << service;
  }
}

TEST(ReflectionTest, DescribesAMethodAndItsMessages) {
  TestEnv env;
  std::string response;
  const grpc::Status status =
      Ask(env, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
          Field(4, "latticed.v1.SceneService"), &response);

  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_NE(response.find("latticed/v1/scene.proto"), std::string::npos);
  EXPECT_NE(response.find("CreateSceneRequest"), std::string::npos);
}

}  // namespace
}  // namespace latticed::testing
