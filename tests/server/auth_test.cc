// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/auth.h"

#include <grpcpp/generic/generic_stub.h>

#include <set>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "tests/server/test_env.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed {
namespace {

using ::latticed::testing::Reason;
using ::latticed::testing::StatusIs;
using ::latticed::testing::TemporaryFolder;
using ::latticed::testing::TestEnv;
using ::latticed::testing::TestOptions;
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

TEST(AuthenticatorTest, AnythingElseIsUnauthenticated) {
  const auto authenticator = Authenticator::FromText(TokenLines());
  ASSERT_OK(authenticator);

  for (const std::string text : {"", "Bearer ", "Bearer token-x", "Basic token-r", "token-r"}) {
    EXPECT_THAT(authenticator->Authenticate(text), StatusIs(absl::StatusCode::kUnauthenticated))
        << text;
  }
  // The hash is not the token.
  EXPECT_THAT(authenticator->Authenticate("Bearer " + Sha256Hex("token-r")),
              StatusIs(absl::StatusCode::kUnauthenticated));
}

TEST(AuthenticatorTest, BadFilesAreRefusedByLine) {
  const std::string hash = Sha256Hex("t");
  for (const std::string& line :
       std::vector<std::string>{hash, hash + " read", hash + " root x", "abc read x",
                                std::string(64, 'g') + " read x", hash + " read x y"}) {
    EXPECT_THAT(Authenticator::FromText("# first\n" + line),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("line 2")))
        << line;
  }
  EXPECT_THAT(Authenticator::FromText("# none\n"), StatusIs(absl::StatusCode::kInvalidArgument));
}

class TokenServerTest : public ::testing::Test {
 protected:
  TokenServerTest() : env_(WithTokens()) {}

  Options WithTokens() const {
    Options options = TestOptions();
    options.token_file = folder_.Write("tokens", TokenLines());
    return options;
  }

  static void SetToken(grpc::ClientContext& context, const std::string& token) {
    if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
  }

  // Any rpc by its full method name, with an empty message: enough to be refused.
  grpc::Status CallEmpty(const std::string& method, const std::string& token) {
    grpc::ClientContext context;
    SetToken(context, token);
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
    grpc::Slice slice("");
    const grpc::ByteBuffer request(&slice, 1);
    grpc::ByteBuffer response;
    grpc::Status status;
    grpc::CompletionQueue queue;
    grpc::GenericStub stub(env_.channel());
    const auto call = stub.PrepareUnaryCall(&context, method, request, &queue);
    call->StartCall();
    call->Finish(&response, &status, &status);
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    queue.Shutdown();
    return status;
  }

  static std::vector<const google::protobuf::MethodDescriptor*> AllMethods() {
    std::vector<const google::protobuf::MethodDescriptor*> methods;
    for (const auto* file : {v1::MeshHeader::descriptor()->file(), v1::Scene::descriptor()->file(),
                             v1::ServerInfo::descriptor()->file()}) {
      for (int s = 0; s < file->service_count(); ++s) {
        for (int m = 0; m < file->service(s)->method_count(); ++m) {
          methods.push_back(file->service(s)->method(m));
        }
      }
    }
    return methods;
  }

  TemporaryFolder folder_;
  TestEnv env_;
};

TEST_F(TokenServerTest, NoRpcIsOpen) {
  ASSERT_EQ(AllMethods().size(), 23u);
  for (const auto* method : AllMethods()) {
    const std::string path = fmt::format("/{}/{}", method->service()->full_name(), method->name());

    EXPECT_EQ(CallEmpty(path, "").error_code(), grpc::StatusCode::UNAUTHENTICATED) << path;
    EXPECT_EQ(CallEmpty(path, "wrong").error_code(), grpc::StatusCode::UNAUTHENTICATED) << path;
  }
}

// Each refusal names the rpc: what a handler's row says is what was called.
TEST_F(TokenServerTest, ReaderCannotEdit) {
  const std::set<std::string> edits = {"MeshService/UploadMesh",   "MeshService/BeginUpload",
                                       "MeshService/AppendUpload", "MeshService/FinishUpload",
                                       "MeshService/DeleteMesh",   "SceneService/CreateScene",
                                       "SceneService/DeleteScene", "SceneService/ApplyEdits"};
  for (const auto* method : AllMethods()) {
    const std::string rpc = fmt::format("{}/{}", method->service()->name(), method->name());
    const grpc::Status status =
        CallEmpty(fmt::format("/{}/{}", method->service()->full_name(), method->name()), "token-r");

    const bool refused = status.error_code() == grpc::StatusCode::PERMISSION_DENIED;
    EXPECT_EQ(refused, edits.contains(rpc)) << rpc << ": " << status.error_message();
    if (refused) {
      EXPECT_EQ(Reason(status), "PERMISSION_DENIED");
      EXPECT_THAT(status.error_message(), HasSubstr(rpc + " needs the role 'edit'"));
      EXPECT_THAT(status.error_message(), HasSubstr("rita"));
    }
  }
}

TEST_F(TokenServerTest, EditorUploadsAndOwns) {
  const std::string obj = testing::CubeObj();
  grpc::ClientContext context;
  SetToken(context, "token-e");
  v1::Mesh mesh;
  const auto writer = env_.meshes().UploadMesh(&context, &mesh);
  v1::UploadMeshRequest request;
  *request.mutable_header() = testing::ObjHeader(obj);
  writer->Write(request);
  request.set_data(obj);
  writer->Write(request);
  writer->WritesDone();

  const grpc::Status status = writer->Finish();

  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(mesh.owner(), "ed");
}

TEST_F(TokenServerTest, ReaderWatchesThroughDeformAndItsEditsAreRefused) {
  const std::string obj = testing::CubeObj();
  grpc::ClientContext upload, create, deform, get;
  for (grpc::ClientContext* context : {&upload, &create}) SetToken(*context, "token-e");
  for (grpc::ClientContext* context : {&deform, &get}) SetToken(*context, "token-r");
  deform.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
  v1::Mesh mesh;
  {
    const auto writer = env_.meshes().UploadMesh(&upload, &mesh);
    v1::UploadMeshRequest request;
    *request.mutable_header() = testing::ObjHeader(obj);
    writer->Write(request);
    request.set_data(obj);
    writer->Write(request);
    writer->WritesDone();
    ASSERT_TRUE(writer->Finish().ok());
  }
  v1::CreateSceneRequest scene_request;
  scene_request.set_scene_id("scene-of-ed");
  scene_request.set_mesh(mesh.id());
  v1::Scene scene;
  ASSERT_TRUE(env_.scenes().CreateScene(&create, scene_request, &scene).ok());

  const auto stream = env_.scenes().Deform(&deform);
  v1::DeformRequest request;
  request.mutable_watch()->set_scene(scene.id());
  request.mutable_watch()->set_editor_id("rita");
  ASSERT_TRUE(stream->Write(request));
  v1::EditBatch& edit = *request.mutable_edit();
  edit.set_sequence(1);
  edit.set_structure_id(1);
  edit.add_edits()->mutable_move_control_points()->add_indices(0);
  edit.mutable_edits(0)->mutable_move_control_points()->mutable_offset()->set_x(1);
  ASSERT_TRUE(stream->Write(request));
  v1::SceneEvent event;
  bool updated = false;  // before the result or after it
  while (stream->Read(&event) && !event.has_edit_result()) {
    updated = updated || event.has_update_end();
  }

  EXPECT_EQ(event.edit_result().sequence(), 1u);
  EXPECT_EQ(event.edit_result().status().code(), int{grpc::StatusCode::PERMISSION_DENIED});
  EXPECT_EQ(event.edit_result().revision(), 0u);
  request.mutable_heartbeat();
  EXPECT_TRUE(stream->Write(request)) << "the stream goes on";
  stream->WritesDone();
  while (stream->Read(&event)) updated = updated || event.has_update_end();
  const grpc::Status status = stream->Finish();
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_TRUE(updated);
  v1::GetSceneRequest get_request;
  get_request.set_scene(scene.id());
  ASSERT_TRUE(env_.scenes().GetScene(&get, get_request, &scene).ok());
  EXPECT_EQ(scene.revision(), 0u);

  grpc::ClientContext shown;
  SetToken(shown, "token-r");
  shown.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(60));
  const auto presence = env_.scenes().Deform(&shown);
  request.mutable_watch()->set_scene(scene.id());
  request.mutable_watch()->set_editor_id("rita");
  ASSERT_TRUE(presence->Write(request));
  request.mutable_presence()->set_name("Rita");
  ASSERT_TRUE(presence->Write(request));
  while (presence->Read(&event)) continue;
  EXPECT_EQ(presence->Finish().error_code(), grpc::StatusCode::PERMISSION_DENIED);
}

TEST_F(TokenServerTest, ForcedDeleteNeedsAdmin) {
  v1::DeleteMeshRequest request;
  request.set_mesh("none");
  request.set_force(true);
  v1::DeleteMeshResponse response;
  grpc::ClientContext editor, admin;
  SetToken(editor, "token-e");
  SetToken(admin, "token-a");

  EXPECT_EQ(env_.meshes().DeleteMesh(&editor, request, &response).error_code(),
            grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_EQ(env_.meshes().DeleteMesh(&admin, request, &response).error_code(),
            grpc::StatusCode::NOT_FOUND);
}

TEST(TokenFileTest, MissingFileStopsTheStart) {
  Options options = TestOptions();
  options.token_file = "/no/such/tokens";

  EXPECT_THAT(InProcessServer::Start(options),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--token-file")));
}

}  // namespace
}  // namespace latticed
