// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Clients call and do not read. Their replies may take a share of --memory, on top of it, and no more. The
// tests use TCP and stock gRPC, whose windows hold 65,535 bytes of a reply.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/base/limits.h"
#include "fmt/format.h"
#include "tests/server/support/server_test.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

// A reply takes 1.5 MiB in these tests, as message and as bytes. Five fit in an eighth of kMemory.
constexpr uint64_t kMemory = uint64_t{64} << 20;
constexpr int kCalls = 12, kRoomFor = 5;

// A call whose reply the client has not asked gRPC for.
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
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);  // else the windows grow on a fast link
    const auto channel = grpc::CreateCustomChannel(server_->address(),
                                                   grpc::InsecureChannelCredentials(), arguments);
    slow_scenes_ = v1::SceneService::NewStub(channel);
    slow_meshes_ = v1::MeshService::NewStub(channel);
  }

  void CreateLargeLattice() {
    v1::CreateSceneRequest request = SceneRequest();
    SetAxes(*request.add_lattices()->mutable_fit()->mutable_size(), 32, 32, 32);
    ASSERT_OK(Create(request));
  }
  std::unique_ptr<LatticeCall> AskForLattice() {
    auto call = std::make_unique<LatticeCall>();
    call->reader =
        slow_scenes_->AsyncGetLattice(&call->context, For<v1::GetLatticeRequest>(), &queue_);
    call->reader->ReadInitialMetadata(call.get());  // comes with the reply or a refusal
    ExpectTag(call.get());
    return call;
  }
  absl::Status Take(LatticeCall& call, v1::LatticeState* reply) {
    grpc::Status status;
    call.reader->Finish(reply, &status, &call);
    ExpectTag(&call);
    return client::FromGrpc(status);
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
    call->reader = slow_meshes_->DownloadMesh(&call->context, request);
    return call;
  }
  // Starts a server with memory for `bytes` of replies beside those that `untaken_` holds.
  void StartWithRoomFor(uint64_t bytes) {
    CreateLargeLattice();
    for (int i = 0; i <= kRoomFor; ++i) untaken_.push_back(AskForLattice());
    v1::LatticeState reply;
    const absl::Status refused = Take(*untaken_.back(), &reply);
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
      EXPECT_OK(Take(*call, &reply));
    }
    untaken_.clear();
  }

  absl::Status UploadAtOnce(const std::string& obj) { return Upload(ObjHeader(obj), obj); }
  absl::Status UploadInCalls(const std::string& obj) {
    v1::BeginUploadRequest request;
    *request.mutable_header() = ObjHeader(obj);
    v1::BeginUploadResponse begun;
    EXPECT_OK(Call(&Meshes::BeginUpload, request, &begun));
    v1::AppendUploadRequest part;
    part.set_upload_id(begun.upload_id());
    part.set_data(obj);
    EXPECT_OK(Call(&Meshes::AppendUpload, part));
    v1::FinishUploadRequest end;
    end.set_upload_id(begun.upload_id());
    return Call(&Meshes::FinishUpload, end);
  }
  double Finished(const std::string& method, const std::string& code) const {
    return Metric(
        fmt::format("latticed_rpc_finished_total{{method=\"{}\",code=\"{}\"}}", method, code));
  }

  std::vector<std::unique_ptr<LatticeCall>> untaken_;
  grpc::CompletionQueue queue_;
  // Stubs of a connection whose replies nobody reads.
  std::unique_ptr<Scenes> slow_scenes_;
  std::unique_ptr<Meshes> slow_meshes_;
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
    const absl::Status status = Take(*call, &reply);
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
    EXPECT_THAT(Take(*call, &reply), StatusIs(absl::StatusCode::kCancelled));
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
    std::string bytes;
    for (v1::DownloadMeshResponse part; call->reader->Read(&part);) bytes += part.data();
    const absl::Status status = client::FromGrpc(call->reader->Finish());
    if (status.ok()) {
      ++whole;
      EXPECT_EQ(bytes, obj);
    } else {
      ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
    }
  }
  EXPECT_EQ(whole, kRoomFor);
}

// A call that is refused for its reply has changed nothing.
TEST_F(UntakenRepliesTest, NoSceneIsMadeWhoseReplyHasNoRoom) {
  StartWithRoomFor(16'384);
  v1::CreateSceneRequest request = SceneRequest("scene-two");
  AddLongLabels(*request.mutable_labels());
  const uint64_t reserved = Info().reserved_host_bytes();

  ExpectRefused(Create(request), absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");

  v1::Scene scene;
  EXPECT_THAT(Call(&Scenes::GetScene, For<v1::GetSceneRequest>("scene-two"), &scene),
              StatusIs(absl::StatusCode::kNotFound));
  EXPECT_TRUE(Becomes(2000, [&] { return Info().reserved_host_bytes() == reserved; }));
  EXPECT_OK(Create(SceneRequest("scene-tre"))) << "small replies need no room";
  TakeAll();
  EXPECT_OK(OnceIdle([&] { return Create(request, &scene); }));
  EXPECT_EQ(scene.labels_size(), static_cast<int>(limits::kMaxLabels));
}

TEST_F(UntakenRepliesTest, NoMeshIsStoredWhoseReplyHasNoRoom) {
  StartWithRoomFor(16'384);
  const std::string obj = GroupsObj(200, std::string(80, 'g'));  // a reply of more than 16 KiB
  const int meshes = MeshCount();
  const uint64_t reserved = Info().reserved_host_bytes();

  for (const absl::Status& status : {UploadAtOnce(obj), UploadInCalls(obj)}) {
    ExpectRefused(status, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  }

  EXPECT_EQ(MeshCount(), meshes);
  EXPECT_TRUE(Becomes(2000, [&] { return Info().reserved_host_bytes() == reserved; }));
  TakeAll();
  EXPECT_OK(OnceIdle([&] { return UploadAtOnce(obj); }));
  EXPECT_OK(OnceIdle([&] { return UploadInCalls(obj); }));
  EXPECT_EQ(MeshCount(), meshes + 1);
}

}  // namespace
}  // namespace latticed::testing
