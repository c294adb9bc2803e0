// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Replies are valid UTF-8 and below 1 MiB, whatever text the client sent.
#include <algorithm>
#include <set>
#include <vector>

#include "core/base/limits.h"
#include "fmt/format.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr char kReplacement[] = "\xEF\xBF\xBD";

class MeshRepliesTest : public SmallServerTest {
 protected:
  static void ExpectInvalid(const absl::Status& status, const std::string& field) {
    ExpectRefused(status, absl::StatusCode::kInvalidArgument, "INVALID_FIELD", field);
  }
};

TEST_F(MeshRepliesTest, GroupNamesThatAreNotUtf8AreMended) {
  // Latin-1 and Shift-JIS, as old exporters write them.
  const v1::Mesh uploaded =
      UploadObj("v 0 0 0\nv 1 0 0\nv 0 1 1\ng K\xF6rper\nf 1 2 3\nusemtl \x83\x7D\nf 1 2 3\n");
  v1::GetMeshRequest request;
  request.set_mesh(uploaded.id());
  v1::Mesh mesh;

  ASSERT_OK(Call(&Meshes::GetMesh, request, &mesh));

  ASSERT_EQ(mesh.groups_size(), 2);
  EXPECT_EQ(mesh.groups(0).name(), std::string("K") + kReplacement + "rper");
  EXPECT_EQ(mesh.groups(1).name(), std::string(kReplacement) + "}");
  EXPECT_EQ(mesh.SerializeAsString(), uploaded.SerializeAsString());
}

TEST_F(MeshRepliesTest, LongGroupNamesAreCutBetweenCharacters) {
  std::string name = "x";
  for (int i = 0; i < 1000; ++i) name += "\xC3\xA4";

  const v1::Mesh mesh = UploadObj(GroupsObj(1, name));

  ASSERT_EQ(mesh.groups_size(), 1);
  EXPECT_EQ(mesh.groups(0).name(), name.substr(0, 255));
}

TEST_F(MeshRepliesTest, ManyGroupsAreCutToWhatAMessageHolds) {
  constexpr int kGroups = 20'000;

  const v1::Mesh mesh = UploadObj(GroupsObj(kGroups, std::string(80, 'g')));

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
    ASSERT_OK(Upload(header, obj));
  }

  std::set<std::string> ids;
  int pages = 0;
  v1::ListMeshesRequest request;
  request.set_page_size(1'000);
  do {
    v1::ListMeshesResponse response;
    ASSERT_OK(Call(&Meshes::ListMeshes, request, &response));
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
  mesh_ = Upload(CubeObj());
  for (int i = 0; i < kScenes; ++i) {
    v1::CreateSceneRequest request = SceneRequest(fmt::format("scene-{:03}", i));
    AddLongLabels(*request.mutable_labels());
    ASSERT_OK(Create(request));
  }

  std::vector<std::string> ids;
  v1::ListScenesRequest request;
  request.set_page_size(1'000);
  do {
    v1::ListScenesResponse response;
    ASSERT_OK(Call(&Scenes::ListScenes, request, &response));
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
    v1::ListMeshesRequest request;
    request.set_page_token(token);
    ExpectInvalid(Call(&Meshes::ListMeshes, request), "page_token");
  }
}

TEST_F(MeshRepliesTest, RefusedWordsAreShownInWholeCharacters) {
  // The 64th byte lies within a character.
  std::string word = "x";
  for (int i = 0; i < 50; ++i) word += "\xC3\xA4";
  v1::ListMeshesRequest request;
  request.set_filter(word);
  const std::string obj = CubeObj();
  v1::MeshHeader header = ObjHeader(obj);
  (*header.mutable_labels())[word] = "value";

  ExpectInvalid(Call(&Meshes::ListMeshes, request), "filter");
  ExpectInvalid(Upload(header, obj), "header.labels");
}

}  // namespace
}  // namespace latticed::testing
