// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Replies that any client can take: valid UTF-8, and below 1 MiB whatever words are in them.
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <set>
#include <vector>

#include "client/cpp/library/status.h"
#include "core/base/limits.h"
#include "fmt/format.h"
#include "tests/server/test_env.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::CubeObj;
using ::latticed::testing::ObjHeader;
using ::latticed::testing::TestEnv;

constexpr char kReplacement[] = "\xEF\xBF\xBD";

// `count` triangles, each in a group with that name and its number.
std::string GroupsObj(int count, const std::string& name) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 1\n";
  for (int i = 0; i < count; ++i) text += fmt::format("g {}{}\nf 1 2 3\n", name, i);
  return text;
}

// Thirty-two labels of the most bytes that are allowed: 10 KB.
void AddLongLabels(google::protobuf::Map<std::string, std::string>& labels) {
  for (size_t i = 0; i < limits::kMaxLabels; ++i) {
    labels[fmt::format("k{:062}", i)] = std::string(limits::kMaxLabelValueBytes, 'v');
  }
}

class MeshRepliesTest : public ::testing::Test {
 protected:
  v1::Mesh Upload(const std::string& obj) {
    v1::Mesh mesh;
    const grpc::Status status = env_.Upload(ObjHeader(obj), obj, &mesh);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return mesh;
  }
  static void ExpectRefused(const grpc::Status& status, const std::string& field) {
    const auto details = error::DetailsOf(client::FromGrpc(status));
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << status.error_message();
    EXPECT_EQ(details.reason, "INVALID_FIELD");
    EXPECT_EQ(details.field, field);
  }

  TestEnv env_;
};

TEST_F(MeshRepliesTest, GroupNamesThatAreNotUtf8AreMended) {
  // Latin-1 and Shift-JIS, as old exporters write.
  const v1::Mesh uploaded =
      Upload("v 0 0 0\nv 1 0 0\nv 0 1 1\ng K\xF6rper\nf 1 2 3\nusemtl \x83\x7D\nf 1 2 3\n");
  grpc::ClientContext context;
  v1::GetMeshRequest request;
  request.set_mesh(uploaded.id());
  v1::Mesh mesh;

  ASSERT_TRUE(env_.meshes().GetMesh(&context, request, &mesh).ok());

  ASSERT_EQ(mesh.groups_size(), 2);
  EXPECT_EQ(mesh.groups(0).name(), std::string("K") + kReplacement + "rper");
  EXPECT_EQ(mesh.groups(1).name(), std::string(kReplacement) + "}");
  EXPECT_EQ(mesh.SerializeAsString(), uploaded.SerializeAsString());
}

TEST_F(MeshRepliesTest, LongGroupNamesAreCutBetweenCharacters) {
  std::string name = "x";
  for (int i = 0; i < 1000; ++i) name += "\xC3\xA4";

  const v1::Mesh mesh = Upload(GroupsObj(1, name));

  ASSERT_EQ(mesh.groups_size(), 1);
  EXPECT_EQ(mesh.groups(0).name(), name.substr(0, 255));
}

TEST_F(MeshRepliesTest, ManyGroupsAreCutToWhatAMessageHolds) {
  constexpr int kGroups = 20'000;

  const v1::Mesh mesh = Upload(GroupsObj(kGroups, std::string(80, 'g')));

  EXPECT_LT(mesh.ByteSizeLong(), limits::kMaxMessageBytes);
  EXPECT_EQ(mesh.faces(), uint64_t{kGroups});
  EXPECT_GT(mesh.groups_size(), 5'000);
  EXPECT_LT(mesh.groups_size(), kGroups);
  EXPECT_EQ(mesh.groups(5).name(), std::string(80, 'g').append("5"));
}

TEST_F(MeshRepliesTest, PagesOfMeshesAreCutByBytes) {
  constexpr int kMeshes = 110;
  for (int i = 0; i < kMeshes; ++i) {
    const std::string obj = CubeObj(1 + i);
    v1::MeshHeader header = ObjHeader(obj);
    AddLongLabels(*header.mutable_labels());
    v1::Mesh mesh;
    ASSERT_TRUE(env_.Upload(header, obj, &mesh).ok());
  }

  std::set<std::string> ids;
  int pages = 0;
  v1::ListMeshesRequest request;
  request.set_page_size(1'000);
  do {
    grpc::ClientContext context;
    v1::ListMeshesResponse response;
    ASSERT_TRUE(env_.meshes().ListMeshes(&context, request, &response).ok());
    EXPECT_LT(response.ByteSizeLong(), limits::kMaxMessageBytes);
    for (const v1::Mesh& mesh : response.meshes()) EXPECT_TRUE(ids.insert(mesh.id()).second);
    request.set_page_token(response.next_page_token());
    ++pages;
  } while (!request.page_token().empty());

  EXPECT_EQ(ids.size(), size_t{kMeshes});
  EXPECT_EQ(pages, 2);
}

TEST_F(MeshRepliesTest, PagesOfScenesAreCutByBytes) {
  constexpr int kScenes = 90;
  const std::string mesh = env_.UploadCube().id();
  for (int i = 0; i < kScenes; ++i) {
    grpc::ClientContext context;
    v1::CreateSceneRequest request;
    request.set_scene_id(fmt::format("scene-{:03}", i));
    request.set_mesh(mesh);
    AddLongLabels(*request.mutable_labels());
    v1::Scene scene;
    const grpc::Status status = env_.scenes().CreateScene(&context, request, &scene);
    ASSERT_TRUE(status.ok()) << status.error_message();
  }

  std::vector<std::string> ids;
  v1::ListScenesRequest request;
  request.set_page_size(1'000);
  do {
    grpc::ClientContext context;
    v1::ListScenesResponse response;
    ASSERT_TRUE(env_.scenes().ListScenes(&context, request, &response).ok());
    EXPECT_LT(response.ByteSizeLong(), limits::kMaxMessageBytes);
    for (const v1::Scene& scene : response.scenes()) ids.push_back(scene.id());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());

  ASSERT_EQ(ids.size(), size_t{kScenes});
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
}

TEST_F(MeshRepliesTest, PageTokensOfOthersAreRefused) {
  for (const std::string& token :
       std::vector<std::string>{"x", std::string(63, 'a'), std::string(64, 'A'), "1.scene"}) {
    grpc::ClientContext context;
    v1::ListMeshesRequest request;
    request.set_page_token(token);
    v1::ListMeshesResponse response;
    ExpectRefused(env_.meshes().ListMeshes(&context, request, &response), "page_token");
  }
}

TEST_F(MeshRepliesTest, RefusedWordsAreShownInWholeCharacters) {
  // The 64th byte lies within a character.
  std::string word = "x";
  for (int i = 0; i < 50; ++i) word += "\xC3\xA4";
  grpc::ClientContext list;
  v1::ListMeshesRequest request;
  request.set_filter(word);
  v1::ListMeshesResponse response;
  const std::string obj = CubeObj();
  v1::MeshHeader header = ObjHeader(obj);
  (*header.mutable_labels())[word] = "value";
  v1::Mesh mesh;

  ExpectRefused(env_.meshes().ListMeshes(&list, request, &response), "filter");
  ExpectRefused(env_.Upload(header, obj, &mesh), "header.labels");
}

}  // namespace
}  // namespace latticed
