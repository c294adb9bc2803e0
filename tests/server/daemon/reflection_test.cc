// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Server reflection, called with the wire bytes of its messages, as grpcurl calls it.
#include <grpcpp/generic/generic_stub.h>

#include <filesystem>
#include <iterator>

#include "core/base/limits.h"
#include "tests/server/support/raw_call.h"
#include "tests/server/support/server_test.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

constexpr char kMethod[] = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo";

// A length-delimited field (wire type 2) of less than 128 bytes.
std::string Field(int number, const std::string& bytes) {
  return std::string{static_cast<char>(number << 3 | 2), static_cast<char>(bytes.size())} + bytes;
}

class ReflectionTest : public SmallServerTest {
 protected:
  // The server's list of services, as wire bytes; empty when the server does not answer.
  std::string List() {
    std::string response;
    RawCall(server_->channel(), kMethod, Field(7, "*"), &response);
    return response;
  }
};

TEST_F(ReflectionTest, ListsEveryService) {
  const std::string response = List();
  for (const char* service :
       {"latticed.v1.MeshService", "latticed.v1.SceneService", "latticed.v1.ServerService",
        "latticed.v1.BackupService", "latticed.v1.ShareService", "latticed.v1.PointSetService"}) {
    EXPECT_NE(response.find(Field(1, service)), std::string::npos) << service;
  }
}

TEST_F(ReflectionTest, AnOpenPortAnswersOnlyIfAsked) {
  Options options = TestOptions();
  options.listen = "0.0.0.0:0";
  options.insecure = true;
  for (const bool reflection : {false, true}) {
    options.reflection = reflection;
    ASSERT_OK_AND_ASSIGN(server_, InProcessServer::Serve(options));
    std::string response;
    const grpc::Status status = RawCall(server_->channel(), kMethod, Field(7, "*"), &response);
    EXPECT_EQ(status.error_code(),
              reflection ? grpc::StatusCode::OK : grpc::StatusCode::UNIMPLEMENTED);
  }
}

TEST_F(ReflectionTest, AnOpenHttpPortDoesNotAnswerItEither) {
  Options options = TestOptions();
  options.http = "0.0.0.0:0";
  options.insecure = true;
  StartServer(options);
  EXPECT_EQ(List(), "");
}

int Threads() {
  return static_cast<int>(
      std::distance(std::filesystem::directory_iterator("/proc/self/task"), {}));
}

// A reflection stream blocks one of gRPC's threads while it is open.
TEST_F(ReflectionTest, ManyStreamsTakeFewThreads) {
  constexpr int kStreams = 120;  // on one connection
  ASSERT_NE(List(), "");
  const int before = Threads();
  grpc::GenericStub stub(server_->channel());
  grpc::CompletionQueue queue;
  void* tag = nullptr;
  bool ok = false;
  struct Stream {
    grpc::ClientContext context;
    std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call;
  };
  std::vector<Stream> streams(kStreams);
  for (Stream& stream : streams) {
    stream.call = stub.PrepareCall(&stream.context, kMethod, &queue);
    stream.call->StartCall(nullptr);
    ASSERT_TRUE(queue.Next(&tag, &ok));
  }

  EXPECT_OK(Call(&Infos::GetServerInfo, {}));
  EXPECT_LE(Threads(), before + limits::kMaxGrpcThreads);

  for (Stream& stream : streams) stream.context.TryCancel();
  for (Stream& stream : streams) {
    grpc::Status status;
    stream.call->Finish(&status, nullptr);
    ASSERT_TRUE(queue.Next(&tag, &ok));
  }
  EXPECT_TRUE(Becomes(1'000, [&] { return !List().empty(); }));
}

}  // namespace
}  // namespace latticed::testing
