// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Callers who know every id of another tenant, and try each call with them: over gRPC, gRPC-Web, a WebSocket, and downloads.
#include <gmock/gmock.h>

#include "absl/strings/escaping.h"
#include "absl/strings/str_replace.h"
#include "tests/server/support/raw_call.h"
#include "tests/server/web/web_fixture.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int kNotFound = 5;  // of gRPC
constexpr char kOwner[] = "of-acme", kBeta[] = "of-beta", kOperator[] = "of-the-operator";

std::string Bearer(const std::string& token) { return "Bearer " + token; }
Metadata As(const std::string& token) { return {{"authorization", Bearer(token)}}; }

// A request as bytes, for any transport.
struct Try {
  std::string rpc;
  std::string bytes;
};
template <typename Request>
Try With(const std::string& rpc, const Request& request) {
  return {"latticed.v1." + rpc, request.SerializeAsString()};
}
template <typename Request>
Try OfScene(const std::string& rpc, const std::string& scene) {
  return With("SceneService/" + rpc, For<Request>(scene));
}
template <typename Request>
Try OfMesh(const std::string& rpc, const std::string& mesh) {
  Request request;
  request.set_mesh(mesh);
  return With("MeshService/" + rpc, request);
}

// In memory, and with a folder.
class TenantsTest : public WebTest, public ::testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    WebTest::SetUp();
    if (GetParam()) options_.data_dir = folder_.Path("data");
    std::string tokens;
    for (const auto& [token, tenant] :
         {std::pair(kOwner, "acme"), {kBeta, "beta"}, {kOperator, ""}}) {
      tokens += fmt::format("{} admin ada {}\n", Sha256Hex(token), tenant);
    }
    options_.token_file = folder_.Write("tokens", tokens);
    options_.caller_share = 1;
    Serve();
    const std::string obj = WavyGridObj(8);
    v1::Mesh mesh;
    ASSERT_OK(Upload(ObjHeader(obj), obj, &mesh, As(kOwner)));
    mesh_ = mesh.id();
    ASSERT_OK(Call(&Scenes::CreateScene, SceneRequest(), nullptr, As(kOwner)));
    v1::BeginUploadRequest begin;
    *begin.mutable_header() = ObjHeader(obj);
    v1::BeginUploadResponse begun;
    ASSERT_OK(Call(&Meshes::BeginUpload, begin, &begun, As(kOwner)));
    upload_ = begun.upload_id();
    watcher_ = std::make_unique<WatchClient>(*scenes_, Watch(), As(kOwner));
    ASSERT_TRUE(watcher_->Read());
    watch_ = watcher_->log.hello.watch_id();
    ASSERT_THAT(watch_, Not(IsEmpty()));
  }
  void TearDown() override {
    watcher_.reset();
    WebTest::TearDown();
  }

  // Every call that names something of the owner's. `before` is put before each id.
  std::vector<Try> Tries(const std::string& before = "") const {
    const std::string scene = before + kScene, mesh = before + mesh_;
    v1::CreateSceneRequest create = SceneRequest("scene-of-a-thief");
    create.set_mesh(mesh);
    v1::EditBatch edit = MoveOne("thief", 1, 3, {1, 0, 0});
    edit.set_scene(scene);
    v1::ControlWatchRequest control;
    control.set_watch_id(before + watch_);
    control.set_pause(true);
    v1::AppendUploadRequest append;
    append.set_upload_id(before + upload_);
    append.set_data("v 0 0 0\n");
    v1::FinishUploadRequest finish;
    finish.set_upload_id(before + upload_);
    v1::DeleteMeshRequest force;
    force.set_mesh(mesh);
    force.set_force(true);
    return {OfScene<v1::GetSceneRequest>("GetScene", scene),
            OfScene<v1::GetLatticeRequest>("GetLattice", scene),
            With("SceneService/ApplyEdits", edit),
            OfScene<v1::EvaluatePointsRequest>("EvaluatePoints", scene),
            OfScene<v1::PickRequest>("Pick", scene),
            OfScene<v1::CertifyFoldsRequest>("CertifyFolds", scene),
            OfScene<v1::GetTopologyRequest>("GetTopology", scene),
            OfScene<v1::GetPatchPlanRequest>("GetPatchPlan", scene),
            OfScene<v1::ExportRequest>("Export", scene),
            OfScene<v1::WatchRequest>("Watch", scene),
            OfScene<v1::GetUpdateRequest>("GetUpdate", scene),
            OfScene<v1::DeleteSceneRequest>("DeleteScene", scene),
            With("SceneService/ControlWatch", control),
            With("SceneService/CreateScene", create),
            OfMesh<v1::GetMeshRequest>("GetMesh", mesh),
            OfMesh<v1::DownloadMeshRequest>("DownloadMesh", mesh),
            OfMesh<v1::DeleteMeshRequest>("DeleteMesh", mesh),
            With("MeshService/DeleteMesh", force),
            With("MeshService/AppendUpload", append),
            With("MeshService/FinishUpload", finish)};
  }
  // Nothing that was tried has changed anything.
  void ExpectUntouched() {
    v1::Scene scene;
    EXPECT_OK(Call(&Scenes::GetScene, For<v1::GetSceneRequest>(), &scene, As(kOwner)));
    EXPECT_EQ(scene.id(), kScene);
    EXPECT_EQ(scene.mesh(), mesh_);
    EXPECT_EQ(scene.revision(), 0);
    v1::AppendUploadRequest append;
    append.set_upload_id(upload_);
    v1::AppendUploadResponse appended;
    EXPECT_OK(Call(&Meshes::AppendUpload, append, &appended, As(kOwner)));
    EXPECT_EQ(appended.committed(), 0);
  }
  std::vector<std::string> ScenesOf(const std::string& token) {
    v1::ListScenesResponse list;
    EXPECT_OK(Call(&Scenes::ListScenes, {}, &list, As(token)));
    std::vector<std::string> ids;
    for (const auto& scene : list.scenes()) ids.push_back(scene.id());
    return ids;
  }
  std::vector<std::string> MeshesOf(const std::string& token) {
    v1::ListMeshesResponse list;
    EXPECT_OK(Call(&Meshes::ListMeshes, {}, &list, As(token)));
    std::vector<std::string> ids;
    for (const auto& mesh : list.meshes()) ids.push_back(mesh.id());
    return ids;
  }

  std::string upload_, watch_;
  std::unique_ptr<WatchClient> watcher_;
};

INSTANTIATE_TEST_SUITE_P(Stores, TenantsTest, ::testing::Bool(), [](const auto& info) {
  return std::string(info.param ? "Folder" : "Memory");
});

TEST_P(TenantsTest, StrangersFindNothingOverGrpc) {
  const auto channel = grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials());
  for (const char* stranger : {kBeta, kOperator}) {
    for (const char* before : {"", "acme/", "/acme/", "../acme/", "/"}) {
      for (const Try& attempt : Tries(before)) {
        const grpc::Status status =
            RawCall(channel, "/" + attempt.rpc, attempt.bytes, nullptr, Bearer(stranger));
        EXPECT_EQ(status.error_code(), kNotFound)
            << stranger << " " << before << " " << attempt.rpc << ": " << status.error_message();
        if (std::string(before).empty()) {
          EXPECT_THAT(status.error_message(), Not(HasSubstr("acme")));
        }
      }
    }
    DeformClient deform(*scenes_, For<v1::WatchRequest>(), As(stranger));
    EXPECT_FALSE(deform.Read());
    EXPECT_THAT(deform.Finish(), StatusIs(absl::StatusCode::kNotFound));
    EXPECT_THAT(ScenesOf(stranger), IsEmpty());
    EXPECT_THAT(MeshesOf(stranger), IsEmpty());
  }
  ExpectUntouched();
}

// The same id finds the same whether another tenant has it or nobody.
TEST_P(TenantsTest, RefusalsTellNothing) {
  const auto refusal = [&](const std::string& scene) {
    const absl::Status status =
        Call(&Scenes::GetScene, For<v1::GetSceneRequest>(scene), nullptr, As(kBeta));
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kNotFound));
    return absl::StrReplaceAll(std::string(status.message()), {{scene, "ID"}});
  };
  EXPECT_EQ(refusal(kScene), refusal("nobody-has-this"));
}

TEST_P(TenantsTest, StrangersFindNothingOverGrpcWeb) {
  for (const char* stranger : {kBeta, kOperator}) {
    for (const char* before : {"", "acme/"}) {
      for (const Try& attempt : Tries(before)) {
        WebClient client(http());
        const GrpcWebAnswer answer = CallGrpcWeb(client, attempt.rpc, Frame(attempt.bytes),
                                                 {{"authorization", Bearer(stranger)}});
        EXPECT_EQ(answer.code, kNotFound) << stranger << " " << before << " " << attempt.rpc;
        EXPECT_THAT(answer.messages, IsEmpty());
      }
    }
  }
  ExpectUntouched();
}

TEST_P(TenantsTest, StrangersFindNothingOverAWebSocketOrADownload) {
  for (const char* stranger : {kBeta, kOperator}) {
    // The name of the scene in the address is for proxies.
    for (const char* routed : {"", "?latticed-scene=scene-one"}) {
      WebSocketClient socket(http(), std::string("/ws/latticed.v1.SceneService/Deform") + routed,
                             "latticed.v1, bearer." + absl::WebSafeBase64Escape(stranger));
      ASSERT_EQ(socket.status(), 101);
      v1::DeformRequest open;
      *open.mutable_watch() = For<v1::WatchRequest>();
      ASSERT_TRUE(socket.Send(open.SerializeAsString()));
      while (socket.Read().has_value()) continue;
      EXPECT_EQ(socket.close_code(), 4000 + kNotFound) << socket.close_reason();
    }
    for (const char* path : {"/export/scene-one.ply", "/export/acme%2Fscene-one.ply"}) {
      const WebAnswer file = Get(path, {{"authorization", Bearer(stranger)}});
      EXPECT_EQ(file.status, 404) << path;
      EXPECT_THAT(file.body, Not(HasSubstr("element vertex"))) << path;
    }
  }
  EXPECT_EQ(Get("/export/scene-one.ply", {{"authorization", Bearer(kOwner)}}).status, 200);
  ExpectUntouched();
}

TEST_P(TenantsTest, EachTenantHasIdsOfItsOwn) {
  const std::string obj = WavyGridObj(8);
  v1::Mesh mesh;
  for (const char* other : {kBeta, kOperator}) {
    ASSERT_OK(Upload(ObjHeader(obj), obj, &mesh, As(other)));
    EXPECT_EQ(mesh.id(), mesh_) << "the same bytes have the same hash";
    EXPECT_EQ(mesh.scenes(), 0) << "scenes of others are not counted";
    ASSERT_OK(Call(&Scenes::CreateScene, SceneRequest(), nullptr, As(other)));
    EXPECT_THAT(ScenesOf(other), ::testing::ElementsAre(kScene));
    EXPECT_THAT(MeshesOf(other), ::testing::ElementsAre(mesh_));
  }
  EXPECT_OK(Call(&Scenes::ApplyEdits, MoveOne("ed", 1, 3, {1, 0, 0}), nullptr, As(kBeta)));
  ExpectUntouched();

  v1::DeleteMeshRequest request;
  request.set_mesh(mesh_);
  request.set_force(true);
  EXPECT_OK(Call(&Meshes::DeleteMesh, request, nullptr, As(kBeta)));
  EXPECT_THAT(ScenesOf(kBeta), IsEmpty());
  EXPECT_THAT(ScenesOf(kOperator), ::testing::ElementsAre(kScene));
  ExpectUntouched();
}

TEST_P(TenantsTest, ATokenToResumeIsGoodForItsSceneOnly) {
  const std::string obj = WavyGridObj(8);
  ASSERT_OK(Upload(ObjHeader(obj), obj, nullptr, As(kBeta)));
  ASSERT_OK(Call(&Scenes::CreateScene, SceneRequest(), nullptr, As(kBeta)));
  watcher_->ReadUpdates(1);
  v1::WatchRequest request = Watch();
  request.set_resume_token(watcher_->log.ends.back().resume_token());

  WatchClient own(*scenes_, request, As(kOwner));
  own.ReadUpdates(1);
  EXPECT_TRUE(own.log.hello.resumed());
  WatchClient stranger(*scenes_, request, As(kBeta));
  stranger.ReadUpdates(1);
  EXPECT_FALSE(stranger.log.hello.resumed());
}

TEST_P(TenantsTest, ARestartKeepsTenantsApart) {
  if (!GetParam()) return;  // nothing is kept
  watcher_.reset();
  server_.reset();
  Serve();
  for (const char* stranger : {kBeta, kOperator}) {
    EXPECT_THAT(ScenesOf(stranger), IsEmpty());
    EXPECT_THAT(MeshesOf(stranger), IsEmpty());
    EXPECT_THAT(Call(&Scenes::GetScene, For<v1::GetSceneRequest>(), nullptr, As(stranger)),
                StatusIs(absl::StatusCode::kNotFound));
  }
  EXPECT_THAT(ScenesOf(kOwner), ::testing::ElementsAre(kScene));
  EXPECT_THAT(MeshesOf(kOwner), ::testing::ElementsAre(mesh_));
  v1::Scene scene;
  EXPECT_OK(Call(&Scenes::GetScene, For<v1::GetSceneRequest>(), &scene, As(kOwner)));
  EXPECT_EQ(scene.mesh(), mesh_);
}

}  // namespace
}  // namespace latticed::testing
