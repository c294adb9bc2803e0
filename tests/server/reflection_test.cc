// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reflection, asked by the wire bytes of its messages, as grpcurl asks it.
#include <grpcpp/generic/generic_stub.h>

#include <filesystem>
#include <iterator>

#include "core/base/limits.h"
#include "tests/server/test_env.h"
#include "tests/support/becomes.h"

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

int Threads() {
  return static_cast<int>(
      std::distance(std::filesystem::directory_iterator("/proc/self/task"), {}));
}

// A stream of reflection blocks a thread of gRPC's for as long as it is open.
TEST(ReflectionTest, ManyStreamsTakeFewThreads) {
  constexpr int kStreams = 120;  // on one connection
  TestEnv env;
  std::string response;
  const std::string method = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo";
  ASSERT_TRUE(Ask(env, method, Field(7, "*"), &response).ok());
  const int before = Threads();
  grpc::GenericStub stub(env.channel());
  grpc::CompletionQueue queue;
  void* tag = nullptr;
  bool ok = false;
  struct Stream {
    grpc::ClientContext context;
    std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call;
  };
  std::vector<Stream> streams(kStreams);
  for (Stream& stream : streams) {
    stream.call = stub.PrepareCall(&stream.context, method, &queue);
    stream.call->StartCall(nullptr);
    ASSERT_TRUE(queue.Next(&tag, &ok));
  }

  v1::ServerInfo info;
  grpc::ClientContext context;
  EXPECT_TRUE(env.info().GetServerInfo(&context, {}, &info).ok());
  EXPECT_LE(Threads(), before + limits::kMaxGrpcThreads);

  for (Stream& stream : streams) stream.context.TryCancel();
  for (Stream& stream : streams) {
    grpc::Status status;
    stream.call->Finish(&status, nullptr);
    ASSERT_TRUE(queue.Next(&tag, &ok));
  }
  EXPECT_TRUE(Becomes(1'000, [&] { return Ask(env, method, Field(7, "*"), &response).ok(); }));
}

}  // namespace
}  // namespace latticed::testing
