// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The server enforces the limits that GetServerInfo publishes, and gRPC's own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "core/base/limits.h"
#include "core/cpu/cpu_backend.h"
#include "tests/server/support/server_test.h"
#include "tests/server/support/unfinished_calls.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class ServerLimitsTest : public SceneFixture {
 protected:
  v1::ServerLimits Limits() { return Info().limits(); }
};

TEST_F(ServerLimitsTest, OneSceneTooMany) {
  StartServer({.max_scenes = 2});
  EXPECT_EQ(Limits().max_scenes(), 2);
  ASSERT_OK(Create(SceneRequest("scene-one")));
  ASSERT_OK(Create(SceneRequest("scene-two")));

  ExpectRefused(Create(SceneRequest("scene-three")), absl::StatusCode::kResourceExhausted,
                "LIMIT_EXCEEDED");

  EXPECT_OK(Create(SceneRequest("scene-two"))) << "the same again is no other scene";
  ASSERT_OK(DeleteScene());
  EXPECT_OK(Create(SceneRequest("scene-three")));
}

TEST_F(ServerLimitsTest, OneWatcherTooMany) {
  StartServer({.max_watchers = 1});
  EXPECT_EQ(Limits().max_watchers_per_scene(), 1);
  ASSERT_OK(Create(SceneRequest()));
  WatchClient first(*scenes_, For<v1::WatchRequest>());
  ASSERT_TRUE(first.Read());

  std::vector<v1::SceneEvent> events;
  ExpectRefused(ReadAll(&Scenes::Watch, For<v1::WatchRequest>(), &events),
                absl::StatusCode::kResourceExhausted, "LIMIT_EXCEEDED");
  EXPECT_TRUE(events.empty());
  EXPECT_TRUE(first.Read()) << "the first goes on";
}

TEST_F(ServerLimitsTest, ARequestThatIsLargerInMemoryThanAllThatMayWait) {
  StartServer({.memory_bytes = uint64_t{64} << 20});
  ASSERT_OK(Create(SceneRequest()));
  v1::EditBatch batch = Move("alice", 1, 0, 0.5);
  for (int i = 0; i < 250'000; ++i) batch.add_edits();  // two bytes each on the wire

  const absl::Status status = Apply(batch);

  ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_EQ(error::DetailsOf(status).free_bytes, uint64_t{8} << 20) << "an eighth of --memory";
  EXPECT_OK(Apply(Move("alice", 1, 0, 0.5)));
}

TEST_F(ServerLimitsTest, AMessageThatGrpcRefusesHasNoDetails) {
  v1::EditBatch batch = Move("alice", 1, 0, 0.5);
  batch.set_scene(std::string(size_t{1} << 20, 'x'));

  grpc::ClientContext context;
  v1::EditResult result;
  const grpc::Status status = scenes_->ApplyEdits(&context, batch, &result);

  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(status.error_details(), "");
  EXPECT_THAT(status.error_message(), HasSubstr("1048576")) << "but says what is allowed";
}

// gRPC decompresses a message before it checks the size: 1 MB of gzip may become 1 GB.
TEST_F(ServerLimitsTest, ACompressedRequestIsRefused) {
  v1::EditBatch batch = Move("alice", 1, 0, 0.5);
  batch.set_scene(std::string(size_t{64} << 20, 'x'));
  for (const auto algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
    grpc::ClientContext unary_context, stream_context;
    unary_context.set_compression_algorithm(algorithm);
    stream_context.set_compression_algorithm(algorithm);
    v1::EditResult result;

    const grpc::Status unary = scenes_->ApplyEdits(&unary_context, batch, &result);
    const auto stream = scenes_->Deform(&stream_context);
    v1::DeformRequest request;
    *request.mutable_edit() = batch;
    stream->Write(request);

    EXPECT_EQ(unary.error_code(), grpc::StatusCode::UNIMPLEMENTED);
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNIMPLEMENTED);
  }
}

TEST_F(ServerLimitsTest, HeadersThatAreTooLongAreRefused) {
  const auto call = [this](size_t bytes) {
    return Call(&Infos::GetServerInfo, {}, nullptr, {{"x", std::string(bytes, 'x')}});
  };

  EXPECT_OK(call(7'000));
  EXPECT_THAT(call(limits::kMaxHeaderBytes), StatusIs(absl::StatusCode::kResourceExhausted));
}

class TransportMemoryTest : public ServerLimitsTest {
 protected:
  static constexpr int kCalls = 64;
  static constexpr size_t kBytes = 1'000'000;

  std::unique_ptr<UnfinishedCalls> Calls(uint64_t transport_memory_bytes) {
    StartServer({.transport_memory_bytes = transport_memory_bytes});
    return std::make_unique<UnfinishedCalls>(
        server_->address(), "/latticed.v1.SceneService/ApplyEdits", kCalls, kBytes);
  }
};

TEST_F(TransportMemoryTest, HoldsMessagesThatHaveNotEndedWhereThereIsRoom) {
  const auto calls = Calls(uint64_t{256} << 20);

  EXPECT_TRUE(calls->Run([&] { return calls->sent() == kCalls; })) << calls->sent();

  EXPECT_EQ(calls->held_bytes(), kCalls * (kBytes - 1));
  EXPECT_EQ(calls->ended(), 0u);
}

TEST_F(TransportMemoryTest, EndsCallsWhoseMessagesTakeMore) {
  const auto calls = Calls(limits::kMinTransportBytes);

  EXPECT_TRUE(calls->Run([&] {
    return calls->sent() + calls->ended() == kCalls &&
           calls->held_bytes() <= limits::kMinTransportBytes;
  })) << calls->held_bytes()
      << " bytes are held, " << calls->ended() << " calls ended";

  EXPECT_GT(calls->ended(), 0u);
  EXPECT_GT(calls->sent(), 0u) << "the others go on";
  constexpr uint32_t kEnhanceYourCalm = 11;  // clients see RESOURCE_EXHAUSTED
  EXPECT_THAT(calls->reset_codes(), Contains(kEnhanceYourCalm));
  EXPECT_EQ(Limits().max_scenes(), 10'000) << "and new ones are answered";
}

class ConnectionsTest : public ServerLimitsTest {
 protected:
  // A connection that begins no call. It retries: connections that have closed may still count.
  std::unique_ptr<UnfinishedCalls> Connect() {
    std::unique_ptr<UnfinishedCalls> connection;
    const bool connected = Becomes(2'000, [&] {
      connection = std::make_unique<UnfinishedCalls>(server_->address(), "", 0, 0);
      return connection->Run([&] { return connection->max_calls() > 0; });
    });
    if (connected) return connection;
    ADD_FAILURE() << "no connection";
    return nullptr;
  }
  // The value of a metric for the gRPC port.
  double Metric(const std::string& name) const {
    return ServerLimitsTest::Metric(name + "{port=\"grpc\"}");
  }
  // A call on its own connection. With `wait` it waits until the server accepts the connection.
  absl::Status Ask(bool wait) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
    arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 100);
    const auto channel = grpc::CreateCustomChannel(server_->address(),
                                                   grpc::InsecureChannelCredentials(), arguments);
    grpc::ClientContext context;
    context.set_wait_for_ready(wait);
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    v1::ServerInfo info;
    return client::FromGrpc(
        v1::ServerService::NewStub(channel)->GetServerInfo(&context, {}, &info));
  }
};

TEST_F(ConnectionsTest, OneTooManyIsClosed) {
  StartServer({.max_connections = 4});  // the fixture's stubs use one
  EXPECT_EQ(Limits().max_connections(), 4);
  auto first = Connect(), second = Connect(), third = Connect();
  const double refused_before = Metric("latticed_connections_refused_total");

  EXPECT_THAT(Ask(/*wait=*/false), StatusIs(absl::StatusCode::kUnavailable));

  EXPECT_EQ(Metric("latticed_connections"), 4);
  EXPECT_EQ(Metric("latticed_connections_limit"), 4);
  EXPECT_GT(Metric("latticed_connections_refused_total"), refused_before);
  third.reset();
  EXPECT_OK(Ask(/*wait=*/true)) << "one has left";
}

TEST_F(ConnectionsTest, ThereAreAsManyAsTransportMemoryHasRoomFor) {
  StartServer({.transport_memory_bytes = uint64_t{16} << 20});

  EXPECT_EQ(Limits().max_connections(), 6) << "of 2.5 MiB";
}

TEST_F(ConnectionsTest, ACallTooManyWaitsForAnEnd) {
  ASSERT_EQ(Limits().max_calls_per_connection(), 128);
  EXPECT_EQ(Connect()->max_calls(), 128u);
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReaderWriter<v1::DeformRequest, v1::SceneEvent>>> calls;
  for (int i = 0; i < 128; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    calls.push_back(scenes_->Deform(contexts.back().get()));
  }
  const auto get = [this](std::chrono::milliseconds patience) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + patience);
    v1::ServerInfo info;
    return infos_->GetServerInfo(&context, {}, &info).error_code();
  };

  EXPECT_EQ(get(std::chrono::milliseconds(300)), grpc::StatusCode::DEADLINE_EXCEEDED);

  contexts.front()->TryCancel();
  EXPECT_EQ(get(std::chrono::minutes(1)), grpc::StatusCode::OK);
  for (const auto& context : contexts) context->TryCancel();
  for (const auto& call : calls) call->Finish();
}

class FirstMessageTest : public ServerLimitsTest {
 protected:
  // Starts a server that ends calls whose first message has not come within `timeout`. It has no mesh,
  // because uploading one might take longer.
  void Await(absl::Duration timeout) {
    StartServerOn(MakeCpuBackend({.threads = 1}), {.first_message_timeout = timeout});
  }
};

TEST_F(FirstMessageTest, OneThatSaysNothingEnds) {
  Await(absl::Milliseconds(100));
  DeformClient deform(*scenes_);
  grpc::ClientContext context;
  v1::Mesh mesh;
  const auto upload = meshes_->UploadMesh(&context, &mesh);

  ExpectRefusal(deform.Finish(), {absl::StatusCode::kFailedPrecondition, "STREAM_NOT_OPENED", "",
                                  "the first message must be watch; none came within 100ms"});
  ExpectRefusal(client::FromGrpc(upload->Finish()),
                {absl::StatusCode::kFailedPrecondition, "STREAM_NOT_OPENED", "",
                 "the first message must be the header; none came within 100ms"});
}

TEST_F(FirstMessageTest, OneThatHasSpokenMayBeSilent) {
  Await(absl::Seconds(5));  // a machine may stall before the first messages come
  mesh_ = Upload(kGridObj);
  ASSERT_OK(Create(SceneRequest()));
  DeformClient spoken(*scenes_, For<v1::WatchRequest>());
  grpc::ClientContext context;
  v1::Mesh mesh;
  const auto upload = meshes_->UploadMesh(&context, &mesh);
  v1::UploadMeshRequest part;
  *part.mutable_header() = ObjHeader(kGridObj);
  ASSERT_TRUE(upload->Write(part));
  upload->WaitForInitialMetadata();

  // A stream that began after these two has ended. Without a first message they would have ended too.
  EXPECT_THAT(DeformClient(*scenes_).Finish(), StatusIs(absl::StatusCode::kFailedPrecondition));

  part.set_data(kGridObj, sizeof(kGridObj) - 1);
  EXPECT_TRUE(upload->Write(part));
  upload->WritesDone();
  EXPECT_OK(client::FromGrpc(upload->Finish()));
  spoken.HalfClose();
  EXPECT_OK(spoken.Finish());
}

}  // namespace
}  // namespace latticed::testing
