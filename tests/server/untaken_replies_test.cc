// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Clients that ask and do not read: their replies have a share of --memory, beside it, and no more.
// Through TCP and stock gRPC, whose windows hold 65,535 bytes of a reply.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/base/limits.h"
#include "fmt/format.h"
#include "tests/server/scene_fixture.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

// The replies of these tests take 1.5 MiB each, message and bytes: five fit in an eighth of this.
constexpr uint64_t kMemory = uint64_t{64} << 20;
constexpr int kCalls = 12, kRoomFor = 5;

// A call whose reply nobody has asked gRPC for.
template <class Reader>
struct UntakenCall {
  grpc::ClientContext context;
  std::unique_ptr<Reader> reader;
};

class UntakenRepliesTest : public SceneFixture {
 protected:
  using LatticeCall = UntakenCall<grpc::ClientAsyncResponseReader<v1::LatticeState>>;
  using DownloadCall = UntakenCall<grpc::ClientReader<v1::DownloadMeshResponse>>;

  void SetUp() override { Start(kMemory); }
  void Start(uint64_t memory_bytes) {
    StartServer({.memory_bytes = memory_bytes});
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);  // or windows grow on a fast link
    channel_ = grpc::CreateCustomChannel(server_->address(), grpc::InsecureChannelCredentials(),
                                         arguments);
    scenes_ = v1::SceneService::NewStub(channel_);
    meshes_ = v1::MeshService::NewStub(channel_);
  }

  void CreateLargeLattice() {
    v1::CreateSceneRequest request = SceneRequest();
    v1::LatticeAxes& size = *request.add_lattices()->mutable_fit()->mutable_size();
    size.set_u(32);
    size.set_v(32);
    size.set_w(32);
    ASSERT_OK(Create(request));
  }
  std::unique_ptr<LatticeCall> AskForLattice() {
    auto call = std::make_unique<LatticeCall>();
    v1::GetLatticeRequest request;
    request.set_scene("scene-one");
    call->reader = scenes_->AsyncGetLattice(&call->context, request, &queue_);
    call->reader->ReadInitialMetadata(call.get());  // which comes with the reply, or a refusal
    ExpectTag(call.get());
    return call;
  }
  grpc::Status Take(LatticeCall& call, v1::LatticeState* reply) {
    grpc::Status status;
    call.reader->Finish(reply, &status, &call);
    ExpectTag(&call);
    return status;
  }
  void ExpectTag(void* expected) {
    void* tag = nullptr;
    bool ok = false;
    EXPECT_TRUE(queue_.Next(&tag, &ok));
    EXPECT_EQ(tag, expected);
  }
  std::unique_ptr<DownloadCall> AskForMesh(const std::string& mesh) {
    auto call = std::make_unique<DownloadCall>();
    v1::DownloadMeshRequest request;
    request.set_mesh(mesh);
    call->reader = meshes_->DownloadMesh(&call->context, request);
    return call;
  }
  static void AddLongLabels(google::protobuf::Map<std::string, std::string>& labels) {
    for (size_t i = 0; i < limits::kMaxLabels; ++i) {
      labels[fmt::format("k{:062}", i)] = std::string(limits::kMaxLabelValueBytes, 'v');
    }
  }
  // A server with room for `bytes` of replies beside those that `untaken_` holds.
  void StartWithRoomFor(uint64_t bytes) {
    CreateLargeLattice();
    for (int i = 0; i <= kRoomFor; ++i) untaken_.push_back(AskForLattice());
    v1::LatticeState reply;
    const absl::Status refused = client::FromGrpc(Take(*untaken_.back(), &reply));
    ExpectRefused(refused, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
    const uint64_t one = error::DetailsOf(refused).asked_bytes;
    untaken_.pop_back();
    TakeAll();
    Start((kRoomFor * one + bytes) * limits::kUntakenRepliesShare);
    CreateLargeLattice();
    for (int i = 0; i < kRoomFor; ++i) untaken_.push_back(AskForLattice());
    ASSERT_EQ(Finished("SceneService/GetLattice", "OK"), kRoomFor);
  }
  void TakeAll() {
    for (const auto& call : untaken_) {
      v1::LatticeState reply;
      EXPECT_OK(client::FromGrpc(Take(*call, &reply)));
    }
    untaken_.clear();
  }

  // Two hundred groups of long names: a reply of more than 16 KiB.
  static std::string GroupsObj() {
    std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 1\n";
    for (int i = 0; i < 200; ++i) obj += fmt::format("g {:080}\nf 1 2 3\n", i);
    return obj;
  }
  absl::Status UploadAtOnce(const std::string& obj) {
    grpc::ClientContext context;
    v1::Mesh mesh;
    const auto writer = meshes_->UploadMesh(&context, &mesh);
    v1::UploadMeshRequest request;
    request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
    request.mutable_header()->set_total_bytes(obj.size());
    writer->Write(request);
    request.set_data(obj);
    writer->Write(request);
    writer->WritesDone();
    return client::FromGrpc(writer->Finish());
  }
  absl::Status UploadInCalls(const std::string& obj) {
    grpc::ClientContext begin, append, finish;
    v1::BeginUploadRequest request;
    request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
    request.mutable_header()->set_total_bytes(obj.size());
    v1::BeginUploadResponse begun;
    EXPECT_OK(client::FromGrpc(meshes_->BeginUpload(&begin, request, &begun)));
    v1::AppendUploadRequest part;
    part.set_upload_id(begun.upload_id());
    part.set_data(obj);
    v1::AppendUploadResponse appended;
    EXPECT_OK(client::FromGrpc(meshes_->AppendUpload(&append, part, &appended)));
    v1::FinishUploadRequest end;
    end.set_upload_id(begun.upload_id());
    v1::Mesh mesh;
    return client::FromGrpc(meshes_->FinishUpload(&finish, end, &mesh));
  }
  int Meshes() {
    grpc::ClientContext context;
    v1::ListMeshesResponse meshes;
    EXPECT_OK(client::FromGrpc(meshes_->ListMeshes(&context, {}, &meshes)));
    return meshes.meshes_size();
  }

  int Finished(const std::string& method, const std::string& code) {
    const std::string metrics = server_->metrics();
    const std::string series =
        fmt::format("\nlatticed_rpc_finished_total{{method=\"{}\",code=\"{}\"}} ", method, code);
    const size_t at = metrics.find(series);
    return at == std::string::npos ? 0 : std::stoi(metrics.substr(at + series.size()));
  }

  std::vector<std::unique_ptr<LatticeCall>> untaken_;
  grpc::CompletionQueue queue_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SceneService::Stub> scenes_;
  std::unique_ptr<v1::MeshService::Stub> meshes_;
};

TEST_F(UntakenRepliesTest, OfOneMessage) {
  CreateLargeLattice();
  std::vector<std::unique_ptr<LatticeCall>> calls;
  for (int i = 0; i < kCalls; ++i) calls.push_back(AskForLattice());
  const std::string method = "SceneService/GetLattice";
  EXPECT_EQ(Finished(method, "RESOURCE_EXHAUSTED"), kCalls - kRoomFor);
  EXPECT_EQ(Finished(method, "OK"), kRoomFor);

  EXPECT_EQ(Get().id(), "scene-one") << "small replies are given meanwhile";

  int taken = 0;
  for (const auto& call : calls) {
    v1::LatticeState reply;
    const absl::Status status = client::FromGrpc(Take(*call, &reply));
    if (status.ok()) {
      ++taken;
      EXPECT_EQ(reply.lattice().control_points_size(), 3 * 32 * 32 * 32);
    } else {
      ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
    }
  }
  EXPECT_EQ(taken, kRoomFor);
  EXPECT_TRUE(Becomes(2000, [&] {
    v1::LatticeState reply;
    return Take(*AskForLattice(), &reply).ok();
  })) << "what was taken makes room";
}

TEST_F(UntakenRepliesTest, OfCallersWhoGiveUp) {
  CreateLargeLattice();
  std::vector<std::unique_ptr<LatticeCall>> calls;
  for (int i = 0; i < kRoomFor; ++i) calls.push_back(AskForLattice());
  ASSERT_EQ(Finished("SceneService/GetLattice", "OK"), kRoomFor);

  for (const auto& call : calls) call->context.TryCancel();

  EXPECT_TRUE(Becomes(2000, [&] {
    v1::LatticeState reply;
    return Take(*AskForLattice(), &reply).ok();
  }));
  for (const auto& call : calls) {
    v1::LatticeState reply;
    EXPECT_EQ(Take(*call, &reply).error_code(), grpc::StatusCode::CANCELLED);
  }
}

TEST_F(UntakenRepliesTest, OfStreamsOfParts) {
  const std::string obj = PlaneObj(145);
  ASSERT_GT(obj.size(), size_t{700} << 10) << "of its part";
  ASSERT_LE(obj.size(), limits::kMaxPartBytes);
  const std::string mesh = Upload(obj);
  std::vector<std::unique_ptr<DownloadCall>> calls;
  for (int i = 0; i < kCalls; ++i) calls.push_back(AskForMesh(mesh));
  EXPECT_TRUE(Becomes(2000, [&] {
    return Finished("MeshService/DownloadMesh", "RESOURCE_EXHAUSTED") == kCalls - kRoomFor;
  }));

  int whole = 0;
  for (const auto& call : calls) {
    std::vector<v1::DownloadMeshResponse> parts;
    const absl::Status status = ReadAll(*call->reader, parts);
    if (status.ok()) {
      ++whole;
      std::string bytes;
      for (const auto& part : parts) bytes += part.data();
      EXPECT_EQ(bytes, obj);
    } else {
      ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
    }
  }
  EXPECT_EQ(whole, kRoomFor);
}

// What is refused for its reply has not happened.
TEST_F(UntakenRepliesTest, NoSceneIsMadeWhoseReplyHasNoRoom) {
  StartWithRoomFor(16'384);
  v1::CreateSceneRequest request = SceneRequest("scene-two");
  AddLongLabels(*request.mutable_labels());
  const uint64_t reserved = Info().reserved_host_bytes();

  ExpectRefused(Create(request), absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");

  v1::GetSceneRequest get;
  get.set_scene("scene-two");
  v1::Scene scene;
  EXPECT_THAT(Call(&v1::SceneService::Stub::GetScene, get, &scene),
              StatusIs(absl::StatusCode::kNotFound));
  EXPECT_EQ(Info().reserved_host_bytes(), reserved);
  EXPECT_OK(Create(SceneRequest("scene-tre"))) << "small replies need no room";
  TakeAll();
  EXPECT_OK(OnceIdle([&] { return Create(request, &scene); }));
  EXPECT_EQ(scene.labels_size(), static_cast<int>(limits::kMaxLabels));
}

TEST_F(UntakenRepliesTest, NoMeshIsStoredWhoseReplyHasNoRoom) {
  StartWithRoomFor(16'384);
  const std::string obj = GroupsObj();
  const int meshes = Meshes();
  const uint64_t reserved = Info().reserved_host_bytes();

  for (const absl::Status& status : {UploadAtOnce(obj), UploadInCalls(obj)}) {
    ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  }

  EXPECT_EQ(Meshes(), meshes);
  EXPECT_EQ(Info().reserved_host_bytes(), reserved);
  TakeAll();
  EXPECT_OK(OnceIdle([&] { return UploadAtOnce(obj); }));
  EXPECT_OK(OnceIdle([&] { return UploadInCalls(obj); }));
  EXPECT_EQ(Meshes(), meshes + 1);
}

}  // namespace
}  // namespace latticed::testing
