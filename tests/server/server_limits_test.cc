// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The limits that GetServerInfo publishes are those that are enforced.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "core/base/limits.h"
#include "core/cpu/cpu_backend.h"
#include "latticed/v1/server.grpc.pb.h"
#include "tests/server/scene_fixture.h"
#include "tests/server/unfinished_calls.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class ServerLimitsTest : public SceneFixture {
 protected:
  v1::ServerLimits Limits() { return Info().limits(); }
};

TEST_F(ServerLimitsTest, NoLimitIsZero) {
  const v1::ServerLimits limits = Limits();
  EXPECT_EQ(limits.max_scenes(), 10'000);
  EXPECT_EQ(limits.max_watchers_per_scene(), 1'000);
  EXPECT_EQ(limits.max_evaluate_points(), 4'096);
}

TEST_F(ServerLimitsTest, OneSceneTooMany) {
  Options options;
  options.max_scenes = 2;
  StartServer(options);
  EXPECT_EQ(Limits().max_scenes(), 2);
  ASSERT_OK(Create(SceneRequest("scene-one")));
  ASSERT_OK(Create(SceneRequest("scene-two")));

  ExpectRefused(Create(SceneRequest("scene-three")), absl::StatusCode::kResourceExhausted,
                "LIMIT_EXCEEDED");

  EXPECT_OK(Create(SceneRequest("scene-two"))) << "the same again is no other scene";
  v1::DeleteSceneRequest request;
  request.set_scene("scene-one");
  v1::DeleteSceneResponse response;
  ASSERT_OK(Call(&v1::SceneService::Stub::DeleteScene, request, &response));
  EXPECT_OK(Create(SceneRequest("scene-three")));
}

TEST_F(ServerLimitsTest, OneWatcherTooMany) {
  Options options;
  options.max_watchers = 1;
  StartServer(options);
  EXPECT_EQ(Limits().max_watchers_per_scene(), 1);
  ASSERT_OK(Create(SceneRequest()));
  v1::WatchRequest request;
  request.set_scene("scene-one");
  grpc::ClientContext first_context, second_context;
  const auto first = stub_->Watch(&first_context, request);
  v1::SceneEvent event;
  ASSERT_TRUE(first->Read(&event));

  std::vector<v1::SceneEvent> events;
  ExpectRefused(ReadAll(*stub_->Watch(&second_context, request), events),
                absl::StatusCode::kResourceExhausted, "LIMIT_EXCEEDED");
  EXPECT_TRUE(events.empty());
  EXPECT_TRUE(first->Read(&event)) << "the first goes on";
  first_context.TryCancel();
}

TEST_F(ServerLimitsTest, PointsOfOneEvaluation) {
  ASSERT_OK(Create(SceneRequest()));
  v1::EvaluatePointsRequest request;
  request.set_scene("scene-one");
  for (int i = 0; i <= limits::kMaxEvaluatePoints; ++i)
    request.mutable_surface_points()->add_points();
  v1::EvaluatePointsResponse response;

  const absl::Status status = Call(&v1::SceneService::Stub::EvaluatePoints, request, &response);

  ExpectRefused(status, absl::StatusCode::kInvalidArgument, "OUT_OF_RANGE",
                "surface_points.points");
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

  const grpc::Status status = stub_->ApplyEdits(&context, batch, &result);

  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(status.error_details(), "");
  EXPECT_THAT(status.error_message(), HasSubstr("1048576")) << "but says what is allowed";
}

// gRPC inflates a message before it looks at its size: 1 MB of gzip may become 1 GB.
TEST_F(ServerLimitsTest, ACompressedRequestIsRefused) {
  v1::EditBatch batch = Move("alice", 1, 0, 0.5);
  batch.set_scene(std::string(size_t{64} << 20, 'x'));
  for (const auto algorithm : {GRPC_COMPRESS_GZIP, GRPC_COMPRESS_DEFLATE}) {
    grpc::ClientContext unary_context, stream_context;
    unary_context.set_compression_algorithm(algorithm);
    stream_context.set_compression_algorithm(algorithm);
    v1::EditResult result;

    const grpc::Status unary = stub_->ApplyEdits(&unary_context, batch, &result);
    const auto stream = stub_->Deform(&stream_context);
    v1::DeformRequest request;
    *request.mutable_edit() = batch;
    stream->Write(request);

    EXPECT_EQ(unary.error_code(), grpc::StatusCode::UNIMPLEMENTED) << unary.error_message();
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNIMPLEMENTED);
  }
}

TEST_F(ServerLimitsTest, HeadersThatAreTooLongAreRefused) {
  const auto call = [this](size_t bytes) {
    grpc::ClientContext context;
    context.AddMetadata("x", std::string(bytes, 'x'));
    v1::ServerInfo info;
    return v1::ServerService::NewStub(server_->channel())->GetServerInfo(&context, {}, &info);
  };

  EXPECT_EQ(call(7'000).error_code(), grpc::StatusCode::OK);
  EXPECT_EQ(call(limits::kMaxHeaderBytes).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
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
  constexpr uint32_t kEnhanceYourCalm = 11;  // which clients know as RESOURCE_EXHAUSTED
  EXPECT_THAT(calls->reset_codes(), Contains(kEnhanceYourCalm));
  EXPECT_EQ(Limits().max_scenes(), 10'000) << "and new ones are answered";
}

class ConnectionsTest : public ServerLimitsTest {
 protected:
  // One that begins nothing; those of calls that have ended may be in its way for a moment.
  std::unique_ptr<UnfinishedCalls> Connect() {
    std::unique_ptr<UnfinishedCalls> connection;
    const bool connected = testing::Becomes(2'000, [&] {
      connection = std::make_unique<UnfinishedCalls>(server_->address(), "", 0, 0);
      return connection->Run([&] { return connection->max_calls() > 0; });
    });
    if (connected) return connection;
    ADD_FAILURE() << "no connection";
    return nullptr;
  }
  // What a metric says of the port.
  double Metric(const std::string& name) {
    const std::string metrics = server_->metrics(), line = name + "{port=\"grpc\"} ";
    const size_t at = metrics.find("\n" + line);
    return at == std::string::npos ? -1 : std::stod(metrics.substr(at + 1 + line.size()));
  }
  // A call on a connection of its own.
  grpc::Status Ask(bool wait) {
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
    return v1::ServerService::NewStub(channel)->GetServerInfo(&context, {}, &info);
  }
};

TEST_F(ConnectionsTest, OneTooManyIsClosed) {
  StartServer({.max_connections = 3});
  EXPECT_EQ(Limits().max_connections(), 3);
  auto first = Connect(), second = Connect(), third = Connect();
  const double refused_before = Metric("latticed_connections_refused_total");

  const grpc::Status refused = Ask(/*wait=*/false);

  EXPECT_EQ(refused.error_code(), grpc::StatusCode::UNAVAILABLE) << refused.error_message();
  EXPECT_EQ(Metric("latticed_connections"), 3);
  EXPECT_EQ(Metric("latticed_connections_limit"), 3);
  EXPECT_GT(Metric("latticed_connections_refused_total"), refused_before);
  third.reset();
  EXPECT_OK(client::FromGrpc(Ask(/*wait=*/true))) << "one has left";
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
    calls.push_back(stub_->Deform(contexts.back().get()));
  }
  const auto get = [this](std::chrono::milliseconds patience) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + patience);
    v1::ServerInfo info;
    return v1::ServerService::NewStub(server_->channel())
        ->GetServerInfo(&context, {}, &info)
        .error_code();
  };

  EXPECT_EQ(get(std::chrono::milliseconds(300)), grpc::StatusCode::DEADLINE_EXCEEDED);

  contexts.front()->TryCancel();
  EXPECT_EQ(get(std::chrono::minutes(1)), grpc::StatusCode::OK);
  for (const auto& context : contexts) context->TryCancel();
  for (const auto& call : calls) call->Finish();
}

class FirstMessageTest : public ServerLimitsTest {
 protected:
  // The server ends calls whose first message has not come within so long. It has no mesh: an upload
  // may be late.
  void Await(absl::Duration timeout) {
    StartServerOn(MakeCpuBackend({.threads = 1}), {.first_message_timeout = timeout});
  }
};

TEST_F(FirstMessageTest, ADeformThatSaysNothingEnds) {
  Await(absl::Milliseconds(100));
  grpc::ClientContext context;
  const auto stream = stub_->Deform(&context);

  const absl::Status status = client::FromGrpc(stream->Finish());

  ExpectRefused(status, absl::StatusCode::kFailedPrecondition, "STREAM_NOT_OPENED");
  EXPECT_EQ(status.message(), "the first message must be watch; none came within 100ms");
}

TEST_F(FirstMessageTest, AnUploadThatSaysNothingEnds) {
  Await(absl::Milliseconds(100));
  grpc::ClientContext context;
  v1::Mesh mesh;
  const auto writer = v1::MeshService::NewStub(server_->channel())->UploadMesh(&context, &mesh);

  const absl::Status status = client::FromGrpc(writer->Finish());

  ExpectRefused(status, absl::StatusCode::kFailedPrecondition, "STREAM_NOT_OPENED");
  EXPECT_EQ(status.message(), "the first message must be the header; none came within 100ms");
}

TEST_F(FirstMessageTest, OneThatHasSpokenMayBeSilent) {
  const absl::Duration timeout = absl::Seconds(3);
  Await(timeout);
  mesh_ = Upload(kGridObj);
  ASSERT_OK(Create(SceneRequest()));
  grpc::ClientContext deform_context, upload_context;
  const auto stream = stub_->Deform(&deform_context);
  v1::DeformRequest watch;
  watch.mutable_watch()->set_scene("scene-one");
  ASSERT_TRUE(stream->Write(watch));
  v1::Mesh mesh;
  const auto writer =
      v1::MeshService::NewStub(server_->channel())->UploadMesh(&upload_context, &mesh);
  v1::UploadMeshRequest part;
  part.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
  part.mutable_header()->set_total_bytes(sizeof(kGridObj) - 1);
  ASSERT_TRUE(writer->Write(part));
  writer->WaitForInitialMetadata();

  std::this_thread::sleep_for(absl::ToChronoMilliseconds(timeout + absl::Milliseconds(500)));

  part.set_data(kGridObj, sizeof(kGridObj) - 1);
  EXPECT_TRUE(writer->Write(part));
  writer->WritesDone();
  EXPECT_OK(client::FromGrpc(writer->Finish()));
  EXPECT_TRUE(stream->WritesDone());
  v1::SceneEvent event;
  while (stream->Read(&event)) continue;
  EXPECT_OK(client::FromGrpc(stream->Finish()));
}

TEST_F(ServerLimitsTest, ASceneSaysWhatItsHistoryHolds) {
  v1::Scene before, after;
  ASSERT_OK(Create(SceneRequest(), &before));
  ASSERT_OK(Apply(Move("alice", 1, 0, 0.5)));
  ASSERT_OK(Create(SceneRequest(), &after));

  ASSERT_TRUE(before.bytes().contains("history"));
  EXPECT_GT(after.bytes().at("history"), before.bytes().at("history"));
}

}  // namespace
}  // namespace latticed::testing
