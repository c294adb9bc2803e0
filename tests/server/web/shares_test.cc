// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shares of scenes: what their tokens open, over every transport, and when they end.
#include <gmock/gmock.h>

#include <filesystem>
#include <set>

#include "absl/strings/escaping.h"
#include "core/base/read_file.h"
#include "latticed/v1/share.grpc.pb.h"
#include "server/base/auth/caller.h"
#include "tests/server/support/raw_call.h"
#include "tests/server/web/web_fixture.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr char kAdmin[] = "of-the-admin", kEditor[] = "of-the-editor", kReader[] = "of-the-reader";
constexpr char kOther[] = "scene-two";

Metadata WithToken(const std::string& token) { return {{"authorization", "Bearer " + token}}; }

// In memory, and with a folder. The tenant "acme" has two scenes of one mesh, and another mesh.
class SharesTest : public WebTest, public ::testing::WithParamInterface<bool> {
 protected:
  using Shares = v1::ShareService::Stub;

  void SetUp() override {
    WebTest::SetUp();
    if (GetParam()) options_.data_dir = folder_.Path("data");
    options_.token_file = folder_.Write(
        "tokens", fmt::format("{} admin op acme\n{} edit ada acme\n{} read rita acme\n",
                              Sha256Hex(kAdmin), Sha256Hex(kEditor), Sha256Hex(kReader)));
    options_.audit_log = folder_.Path("audit");
    options_.caller_share = 1;
    Start();
    const std::string obj = WavyGridObj(8);
    v1::Mesh mesh;
    ASSERT_OK(Upload(ObjHeader(CubeObj()), CubeObj(), &mesh, WithToken(kEditor)));
    other_mesh_ = mesh.id();
    ASSERT_OK(Upload(ObjHeader(obj), obj, &mesh, WithToken(kEditor)));
    mesh_ = mesh.id();
    for (const char* scene : {kScene, kOther}) {
      ASSERT_OK(
          StreamTest::Call(&Scenes::CreateScene, SceneRequest(scene), nullptr, WithToken(kEditor)));
    }
  }
  void Start() {
    Serve();
    shares_ = v1::ShareService::NewStub(server_->channel());
  }

  template <class Request, class Response>
  absl::Status Ask(grpc::Status (Shares::*method)(grpc::ClientContext*, const Request&, Response*),
                   const std::type_identity_t<Request>& request,
                   std::type_identity_t<Response>* response = nullptr,
                   const std::string& token = kEditor) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token);
    Response ignored;
    return client::FromGrpc(
        (*shares_.*method)(&context, request, response != nullptr ? response : &ignored));
  }
  v1::CreateShareResponse Share(v1::ShareRole role, int64_t seconds = 0,
                                const std::string& scene = kScene) {
    auto request = For<v1::CreateShareRequest>(scene);
    request.set_role(role);
    if (seconds != 0) request.mutable_ttl()->set_seconds(seconds);
    v1::CreateShareResponse made;
    EXPECT_OK(Ask(&Shares::CreateShare, request, &made));
    return made;
  }
  std::vector<std::string> Listed(const std::string& scene = kScene) {
    v1::ListSharesResponse list;
    EXPECT_OK(Ask(&Shares::ListShares, For<v1::ListSharesRequest>(scene), &list));
    std::vector<std::string> ids;
    for (const auto& share : list.shares()) ids.push_back(share.share_id());
    return ids;
  }
  absl::Status Revoke(const std::string& share, const std::string& scene = kScene) {
    auto request = For<v1::RevokeShareRequest>(scene);
    request.set_share_id(share);
    return Ask(&Shares::RevokeShare, request);
  }
  absl::Status GetAs(const std::string& token, const std::string& scene = kScene) {
    return StreamTest::Call(&Scenes::GetScene, For<v1::GetSceneRequest>(scene), nullptr,
                            WithToken(token));
  }
  absl::Status EditAs(const std::string& token, uint64_t sequence) {
    return StreamTest::Call(&Scenes::ApplyEdits, MoveOne("guest", sequence, 3, {1, 0, 0}), nullptr,
                            WithToken(token));
  }

  std::unique_ptr<Shares> shares_;
  std::string other_mesh_;
};

INSTANTIATE_TEST_SUITE_P(Stores, SharesTest, ::testing::Bool(), [](const auto& info) {
  return std::string(info.param ? "Folder" : "Memory");
});

TEST_P(SharesTest, AReaderOfAShareWatchesAndDoesNotEdit) {
  const auto made = Share(v1::SHARE_ROLE_READ);
  const std::string& token = made.token();

  EXPECT_EQ(made.share().scene(), kScene);
  EXPECT_EQ(made.share().creator(), "ada");
  EXPECT_EQ(made.share().expire_time().seconds() - made.share().create_time().seconds(),
            7 * 24 * 3600);
  EXPECT_OK(GetAs(token));
  WatchClient watcher(*scenes_, Watch(), WithToken(token));
  watcher.ReadUpdates(1);
  v1::GetMeshRequest mesh;
  mesh.set_mesh(mesh_);
  v1::Mesh shown;
  EXPECT_OK(StreamTest::Call(&Meshes::GetMesh, mesh, &shown, WithToken(token)));
  EXPECT_EQ(shown.scenes(), 0) << "of other scenes nothing is told";
  v1::DownloadMeshRequest download;
  download.set_mesh(mesh_);
  EXPECT_OK(ReadAll(&Meshes::DownloadMesh, download, nullptr, WithToken(token)));
  EXPECT_EQ(Get("/export/scene-one.ply", {{"authorization", "Bearer " + token}}).status, 200);

  ExpectRefused(EditAs(token, 1), absl::StatusCode::kPermissionDenied, "PERMISSION_DENIED");
  DeformClient deform(*scenes_, Watch("guest"), WithToken(token));
  ASSERT_TRUE(deform.Send(MoveOne("guest", 1, 3, {1, 0, 0})));
  deform.ReadUntil([&] { return deform.log.results.size() == 1; });
  EXPECT_EQ(deform.log.results[0].status().code(),
            static_cast<int>(absl::StatusCode::kPermissionDenied));
}

TEST_P(SharesTest, AnEditorOfAShareEditsAndDoesNotShareOrDelete) {
  const std::string token = Share(v1::SHARE_ROLE_EDIT).token();

  EXPECT_OK(EditAs(token, 1));
  DeformClient deform(*scenes_, Watch("guest"), WithToken(token));
  ASSERT_TRUE(deform.Send(MoveOne("guest", 2, 3, {1, 0, 0})));
  deform.ReadUntilRevision(2);
  const absl::Status deleted = StreamTest::Call(&Scenes::DeleteScene, For<v1::DeleteSceneRequest>(),
                                                nullptr, WithToken(token));
  EXPECT_THAT(deleted, StatusIs(absl::StatusCode::kPermissionDenied,
                                HasSubstr("the token of a share is for one scene alone")));
  auto again = For<v1::CreateShareRequest>();
  again.set_role(v1::SHARE_ROLE_EDIT);
  EXPECT_THAT(Ask(&Shares::CreateShare, again, nullptr, token),
              StatusIs(absl::StatusCode::kPermissionDenied));
  EXPECT_EQ(Listed().size(), 1U);
}

TEST_P(SharesTest, TheServerTellsAGuestWhatIsSharedAndNoMore) {
  v1::ServerInfo info;
  ASSERT_OK(StreamTest::Call(&Infos::GetServerInfo, {}, &info,
                             WithToken(Share(v1::SHARE_ROLE_READ).token())));

  EXPECT_EQ(info.role(), "read");
  EXPECT_EQ(info.shared_scene(), kScene);
  EXPECT_EQ(info.tenant(), "");
  ASSERT_OK(StreamTest::Call(&Infos::GetServerInfo, {}, &info, WithToken(kEditor)));
  EXPECT_EQ(info.role(), "edit");
  EXPECT_EQ(info.shared_scene(), "");
  EXPECT_EQ(info.tenant(), "acme");
}

// Every rpc, with the ids of what is not shared, over gRPC and gRPC-Web.
TEST_P(SharesTest, NothingElseOfTheTenantIsOpen) {
  const std::string token = Share(v1::SHARE_ROLE_EDIT).token();
  WatchClient watcher(*scenes_, For<v1::WatchRequest>(kOther), WithToken(kEditor));
  ASSERT_TRUE(watcher.Read());
  v1::ControlWatchRequest control;
  control.set_watch_id(watcher.log.hello.watch_id());
  v1::EditBatch edit = MoveOne("guest", 1, 3, {1, 0, 0});
  edit.set_scene(kOther);
  v1::GetMeshRequest mesh;
  mesh.set_mesh(other_mesh_);
  const std::string scene = For<v1::GetSceneRequest>(kOther).SerializeAsString();  // field 1 of all
  std::map<std::string, std::string> requests = {
      {"SceneService/ApplyEdits", edit.SerializeAsString()},
      {"SceneService/ControlWatch", control.SerializeAsString()},
      {"MeshService/GetMesh", mesh.SerializeAsString()},
      {"MeshService/DownloadMesh", mesh.SerializeAsString()}};
  for (const char* rpc : {"GetScene", "GetLattice", "EvaluatePoints", "Pick", "CertifyFolds",
                          "GetTopology", "GetPatchPlan", "Export", "Watch", "GetUpdate"}) {
    requests[std::string("SceneService/") + rpc] = scene;
  }
  const auto expect = [&](const std::string& rpc, const std::string& request, int code) {
    const grpc::Status native =
        RawCall(server_->channel(), "/latticed.v1." + rpc, request, nullptr, "Bearer " + token);
    EXPECT_EQ(native.error_code(), code) << rpc << " " << native.error_message();
    const auto web =
        Call("latticed.v1." + rpc, Frame(request), {{"authorization", "Bearer " + token}});
    EXPECT_EQ(web.code, code) << rpc;
    EXPECT_THAT(web.messages, IsEmpty()) << rpc;
  };
  for (const auto& [rpc, request] : requests) expect(rpc, request, grpc::StatusCode::NOT_FOUND);
  for (const char* rpc :
       {"SceneService/CreateScene",       "SceneService/ListScenes",
        "SceneService/DeleteScene",       "MeshService/ListMeshes",
        "MeshService/DeleteMesh",         "MeshService/UploadMesh",
        "MeshService/BeginUpload",        "MeshService/AppendUpload",
        "MeshService/FinishUpload",       "BackupService/Backup",
        "BackupService/Restore",          "ShareService/CreateShare",
        "ShareService/ListShares",        "ShareService/RevokeShare",
        "PointSetService/ListPointSets",  "PointSetService/DeletePointSet",
        "PointSetService/DeformPointSet", "PointSetService/ApplyJacobian",
        "PointSetService/CreatePointSet", "PointSetService/ApplyJacobianTranspose"}) {
    const std::set<std::string> client_streams = {"MeshService/UploadMesh", "BackupService/Restore",
                                                  "PointSetService/CreatePointSet",
                                                  "PointSetService/ApplyJacobianTranspose"};
    if (!client_streams.contains(rpc)) {
      expect(rpc, scene, grpc::StatusCode::PERMISSION_DENIED);
    }
    EXPECT_EQ(RawCall(server_->channel(), std::string("/latticed.v1.") + rpc, scene, nullptr,
                      "Bearer " + token)
                  .error_code(),
              grpc::StatusCode::PERMISSION_DENIED)
        << rpc;
  }
  EXPECT_EQ(Get("/export/scene-two.ply", {{"authorization", "Bearer " + token}}).status, 404);
  WebSocketClient socket(http(), "/ws/latticed.v1.SceneService/Deform",
                         "latticed.v1, bearer." + absl::WebSafeBase64Escape(token));
  ASSERT_EQ(socket.status(), 101);
  v1::DeformRequest open;
  *open.mutable_watch() = For<v1::WatchRequest>(kOther);
  ASSERT_TRUE(socket.Send(open.SerializeAsString()));
  while (socket.Read().has_value()) continue;
  EXPECT_EQ(socket.close_code(), 4000 + grpc::StatusCode::NOT_FOUND);
}

TEST_P(SharesTest, ARevokedShareEndsItsStreamsAndNoOthers) {
  const auto revoked = Share(v1::SHARE_ROLE_READ), kept = Share(v1::SHARE_ROLE_READ);
  EXPECT_THAT(Listed(), ElementsAre(revoked.share().share_id(), kept.share().share_id()));
  WatchClient ended(*scenes_, Watch(), WithToken(revoked.token()));
  ended.ReadUpdates(1);
  WatchClient open(*scenes_, Watch(), WithToken(kept.token()));
  open.ReadUpdates(1);

  EXPECT_THAT(Revoke(revoked.share().share_id(), kOther), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_OK(GetAs(revoked.token()));
  ASSERT_OK(Revoke(revoked.share().share_id()));

  EXPECT_THAT(ended.Finish(), StatusIs(absl::StatusCode::kUnauthenticated, HasSubstr("share")));
  EXPECT_THAT(GetAs(revoked.token()),
              StatusIs(absl::StatusCode::kUnauthenticated, HasSubstr("revoked")));
  EXPECT_THAT(Revoke(revoked.share().share_id()), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(Listed(), ElementsAre(kept.share().share_id()));
  ASSERT_OK(EditAs(kEditor, 1));
  open.ReadUntilRevision(1);
}

TEST_P(SharesTest, AShareExpires) {
  const std::string token = Share(v1::SHARE_ROLE_READ, 1).token();
  WatchClient watcher(*scenes_, Watch(), WithToken(token));
  EXPECT_THAT(watcher.Finish(), StatusIs(absl::StatusCode::kUnauthenticated, HasSubstr("share")));
  EXPECT_THAT(GetAs(token), StatusIs(absl::StatusCode::kUnauthenticated));
  EXPECT_THAT(Listed(), IsEmpty());
}

TEST_P(SharesTest, ADeletedSceneTakesItsSharesAlong) {
  const std::string token = Share(v1::SHARE_ROLE_EDIT).token();
  const std::string other = Share(v1::SHARE_ROLE_EDIT, 0, kOther).token();
  WatchClient watcher(*scenes_, Watch(), WithToken(token));
  watcher.ReadUpdates(1);
  ASSERT_OK(StreamTest::Call(&Scenes::DeleteScene, For<v1::DeleteSceneRequest>(), nullptr,
                             WithToken(kEditor)));
  ASSERT_OK(StreamTest::Call(&Scenes::CreateScene, SceneRequest(), nullptr, WithToken(kEditor)));

  EXPECT_THAT(watcher.Finish(), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(GetAs(token), StatusIs(absl::StatusCode::kUnauthenticated));
  EXPECT_THAT(Listed(), IsEmpty());
  EXPECT_OK(GetAs(other, kOther));
}

TEST_P(SharesTest, ADeletedMeshTakesTheSharesOfItsScenesAlong) {
  const std::string token = Share(v1::SHARE_ROLE_EDIT).token();
  v1::DeleteMeshRequest request;
  request.set_mesh(mesh_);
  request.set_force(true);
  ASSERT_OK(StreamTest::Call(&Meshes::DeleteMesh, request, nullptr, WithToken(kAdmin)));
  const std::string obj = WavyGridObj(8);
  ASSERT_OK(Upload(ObjHeader(obj), obj, nullptr, WithToken(kEditor)));
  ASSERT_OK(StreamTest::Call(&Scenes::CreateScene, SceneRequest(), nullptr, WithToken(kEditor)));

  EXPECT_THAT(GetAs(token), StatusIs(absl::StatusCode::kUnauthenticated));
  EXPECT_THAT(Listed(), IsEmpty());
}

TEST_P(SharesTest, ForgedTokensAdmitNobody) {
  const std::string token = Share(v1::SHARE_ROLE_EDIT).token();
  std::string forged = token;
  forged.back() = forged.back() == '0' ? '1' : '0';
  std::string unknown = token;
  unknown[6] = unknown[6] == '0' ? '1' : '0';  // of the id
  for (const std::string& wrong :
       {forged, unknown, token.substr(1), token + "0", token.substr(0, token.size() - 1)}) {
    EXPECT_THAT(GetAs(wrong), StatusIs(absl::StatusCode::kUnauthenticated)) << wrong;
  }
}

// Behind one address many may open a link that has ended: they are told so, and nobody has to wait.
TEST_P(SharesTest, AnOldLinkIsNoGuess) {
  const auto made = Share(v1::SHARE_ROLE_READ);
  ASSERT_OK(Revoke(made.share().share_id()));
  for (int i = 0; i < 20; ++i) {
    EXPECT_THAT(GetAs(made.token()), StatusIs(absl::StatusCode::kUnauthenticated));
  }
}

TEST_P(SharesTest, ARestartKeepsSharesAndNoToken) {
  if (!GetParam()) return;  // nothing is kept
  const auto kept = Share(v1::SHARE_ROLE_EDIT), revoked = Share(v1::SHARE_ROLE_EDIT);
  ASSERT_OK(Revoke(revoked.share().share_id()));
  server_.reset();
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder_.path())) {
    if (!file.is_regular_file()) continue;
    const std::string bytes = ReadFile(file.path().string()).value();
    EXPECT_THAT(bytes, Not(HasSubstr(kept.token().substr(kept.token().size() - 64))))
        << file.path();
  }
  Start();

  EXPECT_OK(EditAs(kept.token(), 1));
  EXPECT_THAT(GetAs(revoked.token()), StatusIs(absl::StatusCode::kUnauthenticated));
  EXPECT_THAT(Listed(), ElementsAre(kept.share().share_id()));
}

TEST_P(SharesTest, TheAuditSaysWhoSharedAndRevoked) {
  const auto made = Share(v1::SHARE_ROLE_EDIT, 3600);
  ASSERT_OK(EditAs(made.token(), 1));
  ASSERT_OK(Revoke(made.share().share_id()));
  server_.reset();

  const std::string log = folder_.Read("audit"), id = made.share().share_id();
  EXPECT_THAT(log, HasSubstr("\"event\":\"scene_shared\""));
  EXPECT_THAT(log, HasSubstr("\"event\":\"share_revoked\""));
  EXPECT_THAT(log, HasSubstr("\"share\":\"" + id + "\""));
  EXPECT_THAT(log, HasSubstr("\"role\":\"edit\""));
  EXPECT_THAT(log, HasSubstr("\"caller\":\"share:" + id + "\"")) << "who edited";
  EXPECT_THAT(log, Not(HasSubstr(made.token())));
}

TEST_P(SharesTest, BadRequestsSayWhatIsWrong) {
  auto request = For<v1::CreateShareRequest>();
  const auto refused = [&] { return Ask(&Shares::CreateShare, request); };
  ExpectRefused(refused(), absl::StatusCode::kInvalidArgument, "INVALID_FIELD", "role");
  request.set_role(static_cast<v1::ShareRole>(9));
  ExpectRefused(refused(), absl::StatusCode::kInvalidArgument, "UNSUPPORTED", "role");
  request.set_role(v1::SHARE_ROLE_READ);
  for (const int64_t seconds : {int64_t{-1}, int64_t{0}, int64_t{367} * 24 * 3600}) {
    request.mutable_ttl()->set_seconds(seconds);
    ExpectRefused(refused(), absl::StatusCode::kInvalidArgument, "OUT_OF_RANGE", "ttl");
  }
  request.mutable_ttl()->set_seconds(1);
  request.mutable_ttl()->set_nanos(-2'000'000);
  ExpectRefused(refused(), absl::StatusCode::kInvalidArgument, "OUT_OF_RANGE", "ttl");
  request.clear_ttl();
  EXPECT_THAT(Ask(&Shares::CreateShare, request, nullptr, kReader),
              StatusIs(absl::StatusCode::kPermissionDenied));
  request.set_scene("no-such-scene");
  EXPECT_THAT(refused(), StatusIs(absl::StatusCode::kNotFound));
  request.set_scene(kScene);
  for (int i = 0; i < 100; ++i) ASSERT_OK(refused());
  ExpectRefused(refused(), absl::StatusCode::kResourceExhausted, "LIMIT_EXCEEDED");
}

// Everybody is admitted to the tenant's all, but who has a share's token asked for less.
TEST_F(WebTest, AShareCountsOnAnOpenServer) {
  ServeScene();
  const auto shares = v1::ShareService::NewStub(server_->channel());
  auto request = For<v1::CreateShareRequest>();
  request.set_role(v1::SHARE_ROLE_READ);
  v1::CreateShareResponse made;
  grpc::ClientContext context;
  ASSERT_TRUE(shares->CreateShare(&context, request, &made).ok());

  EXPECT_OK(StreamTest::Call(&Scenes::GetScene, For<v1::GetSceneRequest>(), nullptr,
                             WithToken(made.token())));
  EXPECT_THAT(StreamTest::Call(&Scenes::ListScenes, {}, nullptr, WithToken(made.token())),
              StatusIs(absl::StatusCode::kPermissionDenied));
}

}  // namespace
}  // namespace latticed::testing
