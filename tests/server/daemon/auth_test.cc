// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/auth/authenticator.h"

#include <set>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "latticed/v1/backup.grpc.pb.h"
#include "latticed/v1/points.pb.h"
#include "latticed/v1/share.pb.h"
#include "server/base/auth/tenant.h"
#include "tests/server/support/raw_call.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

std::string TokenLines() {
  return fmt::format("# people\n{} read rita\n\n{} edit  ed\r\n{}\tadmin\tada\n",
                     Sha256Hex("token-r"), Sha256Hex("token-e"), Sha256Hex("token-a"));
}

TEST(AuthenticatorTest, WithoutTokensEveryoneIsAdmin) {
  const auto caller = Authenticator().Authenticate("");

  ASSERT_OK(caller);
  EXPECT_EQ(caller->role, Role::kAdmin);
  EXPECT_EQ(caller->name, "");
}

TEST(AuthenticatorTest, TokensNameTheirCaller) {
  const auto authenticator = Authenticator::FromText(TokenLines());
  ASSERT_OK(authenticator);

  EXPECT_EQ(authenticator->Authenticate("Bearer token-r")->name, "rita");
  EXPECT_EQ(authenticator->Authenticate("bearer token-e")->role, Role::kEdit);
  EXPECT_EQ(authenticator->Authenticate("Bearer token-a")->role, Role::kAdmin);
}

TEST(AuthenticatorTest, TheLastLineOfATokenCounts) {
  const auto authenticator =
      Authenticator::FromText(fmt::format("{0} admin rita\n{0} read rita\n", Sha256Hex("token-r")));
  ASSERT_OK(authenticator);

  EXPECT_EQ(authenticator->Authenticate("Bearer token-r")->role, Role::kRead);
}

TEST(AuthenticatorTest, ALineMayNameATenant) {
  const auto authenticator =
      Authenticator::FromText(fmt::format("{} edit ed acme\n", Sha256Hex("token-e")));
  ASSERT_OK(authenticator);

  EXPECT_EQ(authenticator->Authenticate("Bearer token-e")->tenant, "acme");
  for (const char* tenant : {"Acme", "a/b", "a.b", "a_b", "acme x"}) {
    EXPECT_THAT(
        Authenticator::FromText(fmt::format("{} edit ed {}\n", Sha256Hex("token-e"), tenant)),
        StatusIs(absl::StatusCode::kInvalidArgument))
        << tenant;
  }
}

// Nothing that a caller sends as an id is the key of another tenant's scene.
TEST(TenantTest, KeysOfTwoTenantsNeverMeet) {
  EXPECT_EQ(TenantKey("", "cow"), "cow");
  EXPECT_EQ(TenantKey("acme", "cow"), "acme/cow");
  EXPECT_EQ(TenantOf("acme/cow"), "acme");
  EXPECT_EQ(IdOf("acme/cow"), "cow");
  EXPECT_EQ(TenantOf("cow"), "");
  EXPECT_EQ(IdOf("cow"), "cow");

  EXPECT_NE(TenantKey("", "acme/cow"), TenantKey("acme", "cow"));
  for (const char* id : {"acme/cow", "/acme/cow", "/cow", "../acme/cow", "//", "/"}) {
    for (const char* tenant : {"", "beta"}) {
      EXPECT_NE(TenantKey(tenant, id), TenantKey("acme", "cow")) << tenant << " " << id;
      EXPECT_EQ(TenantOf(TenantKey(tenant, id)), tenant) << id;
    }
  }
}

TEST(TenantTest, NamesAreShortAndPlain) {
  for (const std::string& name : {std::string("a"), std::string("7-"), std::string(63, 'z')}) {
    EXPECT_TRUE(IsTenantName(name)) << name;
  }
  for (const std::string& name :
       {std::string(), std::string("A"), std::string("a/"), std::string("\xc3\xa4"),
        std::string("a\0", 2), std::string(64, 'z')}) {
    EXPECT_FALSE(IsTenantName(name)) << name;
  }
}

TEST(AuthenticatorTest, AnythingElseIsUnauthenticated) {
  const auto authenticator = Authenticator::FromText(TokenLines());
  ASSERT_OK(authenticator);

  for (const std::string text : {"", "Bearer ", "Bearer token-x", "Basic token-r", "token-r"}) {
    EXPECT_THAT(authenticator->Authenticate(text), StatusIs(absl::StatusCode::kUnauthenticated))
        << text;
  }
  // The hash of a token is no token.
  EXPECT_THAT(authenticator->Authenticate("Bearer " + Sha256Hex("token-r")),
              StatusIs(absl::StatusCode::kUnauthenticated));
}

TEST(AuthenticatorTest, BadFilesAreRefusedByLine) {
  const std::string hash = Sha256Hex("t");
  for (const std::string& line : std::vector<std::string>{
           hash, hash + " read", hash + " root x", "abc read x", std::string(64, 'g') + " read x",
           hash + " read x y z", hash + " read x a/b", hash + " read x " + std::string(64, 't')}) {
    EXPECT_THAT(Authenticator::FromText("# first\n" + line),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("line 2")))
        << line;
  }
  EXPECT_THAT(Authenticator::FromText("# none\n"), StatusIs(absl::StatusCode::kInvalidArgument));
}

Metadata Bearer(const std::string& token) { return {{"authorization", "Bearer " + token}}; }

class TokenServerTest : public ServerTest {
 protected:
  void SetUp() override {
    Options options = TestOptions();
    options.token_file = folder_.Write("tokens", TokenLines());
    StartServer(options);
  }

  // Sends an empty message: the role is checked before the message.
  absl::Status CallEmpty(const google::protobuf::MethodDescriptor& method,
                         const std::string& authorization) {
    const std::string path = fmt::format("/{}/{}", method.service()->full_name(), method.name());
    return client::FromGrpc(RawCall(server_->channel(), path, "", nullptr, authorization));
  }

  static std::vector<const google::protobuf::MethodDescriptor*> AllMethods() {
    std::vector<const google::protobuf::MethodDescriptor*> methods;
    for (const auto* file :
         {v1::MeshHeader::descriptor()->file(), v1::Scene::descriptor()->file(),
          v1::ServerInfo::descriptor()->file(), v1::BackupPart::descriptor()->file(),
          v1::Share::descriptor()->file(), v1::PointSet::descriptor()->file()}) {
      for (int s = 0; s < file->service_count(); ++s) {
        for (int m = 0; m < file->service(s)->method_count(); ++m) {
          methods.push_back(file->service(s)->method(m));
        }
      }
    }
    return methods;
  }

  TemporaryFolder folder_;
};

TEST_F(TokenServerTest, NoRpcIsOpen) {
  ASSERT_EQ(AllMethods().size(), 37u);
  for (const auto* method : AllMethods()) {
    EXPECT_THAT(CallEmpty(*method, ""), StatusIs(absl::StatusCode::kUnauthenticated))
        << method->full_name();
    // After some of them, the address must wait.
    EXPECT_THAT(CallEmpty(*method, "Bearer wrong").code(),
                AnyOf(absl::StatusCode::kUnauthenticated, absl::StatusCode::kResourceExhausted))
        << method->full_name();
  }
}

// Each refusal names the called rpc, so every row of the handlers' table has the right name.
TEST_F(TokenServerTest, ReaderCannotEdit) {
  const std::set<std::string> edits = {
      "MeshService/UploadMesh",         "MeshService/BeginUpload",       "MeshService/AppendUpload",
      "MeshService/FinishUpload",       "MeshService/DeleteMesh",        "SceneService/CreateScene",
      "SceneService/DeleteScene",       "SceneService/ApplyEdits",       "BackupService/Restore",
      "ShareService/CreateShare",       "ShareService/ListShares",       "ShareService/RevokeShare",
      "PointSetService/CreatePointSet", "PointSetService/DeletePointSet"};
  for (const auto* method : AllMethods()) {
    const std::string rpc = fmt::format("{}/{}", method->service()->name(), method->name());
    if (rpc == "BackupService/Backup") continue;  // ReaderBacksUp
    const absl::Status status = CallEmpty(*method, "Bearer token-r");

    const bool refused = absl::IsPermissionDenied(status);
    EXPECT_EQ(refused, edits.contains(rpc)) << rpc << ": " << status.message();
    if (refused) {
      EXPECT_EQ(Reason(status), "PERMISSION_DENIED");
      EXPECT_THAT(status.message(), HasSubstr(rpc + " needs the role 'edit'"));
      EXPECT_THAT(status.message(), HasSubstr("rita"));
    }
  }
}

TEST_F(TokenServerTest, ReaderBacksUp) {
  grpc::ClientContext context;
  context.AddMetadata("authorization", "Bearer token-r");
  const auto stub = v1::BackupService::NewStub(server_->channel());
  const auto reader = stub->Backup(&context, v1::BackupRequest());
  v1::BackupPart part;
  while (reader->Read(&part)) continue;
  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_TRUE(part.has_end());
}

TEST_F(TokenServerTest, ReaderWatchesThroughDeformAndItsEditsAreRefused) {
  v1::Mesh mesh;
  ASSERT_OK(Upload(ObjHeader(CubeObj()), CubeObj(), &mesh, Bearer("token-e")));
  EXPECT_EQ(mesh.owner(), "ed");
  mesh_ = mesh.id();
  ASSERT_OK(Call(&Scenes::CreateScene, SceneRequest(), nullptr, Bearer("token-e")));
  auto watch = For<v1::WatchRequest>();
  watch.set_editor_id("rita");

  DeformClient client(*scenes_, watch, Bearer("token-r"));
  ASSERT_TRUE(client.Send(MoveOne("rita", 1, 0, {1, 0, 0})));
  client.ReadUntil([&] { return !client.log.results.empty(); });

  EXPECT_EQ(client.log.results[0].sequence(), 1u);
  EXPECT_EQ(client.log.results[0].status().code(), int{grpc::StatusCode::PERMISSION_DENIED});
  EXPECT_EQ(client.log.results[0].revision(), 0u);
  v1::DeformRequest request;
  request.mutable_heartbeat();
  EXPECT_TRUE(client.Send(request)) << "the stream goes on";
  client.HalfClose();
  EXPECT_OK(client.Finish());
  EXPECT_EQ(client.log.ends.size(), 1u);
  EXPECT_EQ(client.log.ends[0].head_revision(), 0u);

  DeformClient shown(*scenes_, watch, Bearer("token-r"));
  request.mutable_presence()->set_name("Rita");
  ASSERT_TRUE(shown.Send(request));
  EXPECT_THAT(shown.Finish(), StatusIs(absl::StatusCode::kPermissionDenied));
}

TEST_F(TokenServerTest, ForcedDeleteNeedsAdmin) {
  v1::DeleteMeshRequest request;
  request.set_mesh("none");
  request.set_force(true);
  EXPECT_THAT(Call(&Meshes::DeleteMesh, request, nullptr, Bearer("token-e")),
              StatusIs(absl::StatusCode::kPermissionDenied));
  EXPECT_THAT(Call(&Meshes::DeleteMesh, request, nullptr, Bearer("token-a")),
              StatusIs(absl::StatusCode::kNotFound));
}

TEST(TokenFileTest, MissingFileStopsTheStart) {
  Options options = TestOptions();
  options.token_file = "/no/such/tokens";

  EXPECT_THAT(InProcessServer::Start(options),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--token-file")));
}

}  // namespace
}  // namespace latticed::testing
