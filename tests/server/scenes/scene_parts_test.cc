// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// GetTopology and Export through the stub.
#include "core/base/limits.h"
#include "core/codec/draco_decode.h"
#include "core/mesh/mesh_io.h"
#include "server/engine/scene/topology_id.h"
#include "server/wire/converters.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

class ScenePartsTest : public SceneFixture {
 protected:
  void SetUp() override {
    SceneFixture::SetUp();
    v1::CreateSceneRequest request = SceneRequest();
    request.mutable_default_view()->set_segments(2);
    ASSERT_OK(Create(request, &scene_));
  }
  absl::Status Topology(const std::string& id, std::vector<v1::TopologyPart>& parts) {
    auto request = For<v1::GetTopologyRequest>();
    request.set_topology_id(id);
    return ReadAll(&Scenes::GetTopology, request, &parts);
  }
  absl::Status Export(v1::ExportRequest request, std::vector<v1::ExportResponse>& parts) {
    if (request.scene().empty()) request.set_scene(kScene);
    return ReadAll(&Scenes::Export, request, &parts);
  }
  std::string TopologyIdNow() {
    return TopologyId(mesh_, *StructureFromProto(Lattice().lattice(), "lattice"), 2);
  }
  v1::Scene scene_;
};

TEST_F(ScenePartsTest, TopologyNamesEveryPatchsSource) {
  std::vector<v1::TopologyPart> parts;
  ASSERT_OK(Topology(TopologyIdNow(), parts));

  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].patch_count(), scene_.patches());
  EXPECT_EQ(static_cast<uint64_t>(parts[0].faces_size()), scene_.patches());
}

TEST_F(ScenePartsTest, TopologyOfAnotherStructureIsNotFound) {
  const std::string before = TopologyIdNow();
  ASSERT_OK(Apply(Knot("ann", 1)));

  std::vector<v1::TopologyPart> parts;
  ExpectRefused(Topology(before, parts), Code::kNotFound, "NOT_FOUND");
  ExpectRefused(Topology("", parts), Code::kNotFound, "NOT_FOUND");
  EXPECT_TRUE(parts.empty());
  EXPECT_OK(Topology(TopologyIdNow(), parts));
}

TEST_F(ScenePartsTest, ExportsAreNamedByTheSceneInLettersThatFileSystemsTake) {
  v1::CreateSceneRequest named = SceneRequest("c");
  named.set_name("../Kuh: Ä");
  ASSERT_OK(Create(named));
  v1::ExportRequest request;
  request.set_scene("c");
  std::vector<v1::ExportResponse> parts;
  ASSERT_OK(Export(request, parts));
  EXPECT_EQ(parts[0].header().file_name(), "_._Kuh_ Ä-deformed.ply");
}

TEST_F(ScenePartsTest, ExportsEveryForm) {
  for (int f = v1::EXPORT_FORMAT_UNSPECIFIED; f <= v1::EXPORT_FORMAT_CONTROL_NETS; ++f) {
    SCOPED_TRACE(f);
    v1::ExportRequest request;
    request.set_format(static_cast<v1::ExportFormat>(f));
    std::vector<v1::ExportResponse> parts;
    ASSERT_OK(Export(request, parts));
    ASSERT_GE(parts.size(), 2u);
    ASSERT_TRUE(parts[0].has_header());
    const v1::ExportHeader header = parts[0].header();
    EXPECT_EQ(header.revision(), 0u);
    EXPECT_THAT(header.file_name(), ::testing::StartsWith("cube-deformed."));
    EXPECT_THAT(header.media_type(), ::testing::HasSubstr("/"));
    std::string bytes;
    for (size_t i = 1; i < parts.size(); ++i) {
      ASSERT_LE(parts[i].data().size(), limits::kMaxPartBytes);
      bytes += parts[i].data();
    }
    ASSERT_EQ(bytes.size(), header.bytes());
    if (f == v1::EXPORT_FORMAT_CONTROL_NETS) {
      EXPECT_EQ(bytes.size(), 32 + scene_.patches() * 28 * 24);
      continue;
    }
    const auto format = MeshFormatFromFileName(header.file_name());
    ASSERT_OK(format);
    const auto mesh =
        *format == MeshFormat::kDraco ? ReadDracoMesh(bytes) : ReadMesh(*format, bytes);
    ASSERT_OK(mesh);
    EXPECT_EQ(mesh->face_count(), scene_.patches() * 4);
  }
}

TEST_F(ScenePartsTest, LargeExportsComeInParts) {
  v1::CreateSceneRequest finer = SceneRequest("scene-two");
  SetAxes(*finer.add_lattices()->mutable_fit()->mutable_size(), 9, 9, 3);
  ASSERT_OK(Create(finer));
  auto request = For<v1::ExportRequest>("scene-two");
  request.set_format(v1::EXPORT_FORMAT_OBJ);
  request.mutable_view()->set_segments(12);
  std::vector<v1::ExportResponse> parts;
  ASSERT_OK(Export(request, parts));
  EXPECT_GT(parts.size(), 2u);
}

TEST_F(ScenePartsTest, ExportRefusals) {
  std::vector<v1::ExportResponse> parts;
  v1::ExportRequest request;
  request.set_revision(7);
  ExpectRefused(Export(request, parts), Code::kAborted, "REVISION_CHANGED");
  request.set_revision(0);
  request.set_format(static_cast<v1::ExportFormat>(99));
  ExpectRefused(Export(request, parts), Code::kInvalidArgument, "UNSUPPORTED", "format");
  request.clear_format();
  request.mutable_view()->set_segments(99);
  ExpectRefused(Export(request, parts), Code::kInvalidArgument, "OUT_OF_RANGE", "view.segments");
  request.clear_view();
  request.set_scene("no-such-scene");
  ExpectRefused(Export(request, parts), Code::kNotFound, "NOT_FOUND");
  EXPECT_TRUE(parts.empty());
}

TEST_F(ScenePartsTest, AClientThatLeavesStopsTheExport) {
  auto request = For<v1::ExportRequest>();
  request.mutable_view()->set_segments(32);
  {
    grpc::ClientContext context;
    auto reader = scenes_->Export(&context, request);
    v1::ExportResponse first;
    ASSERT_TRUE(reader->Read(&first));
    context.TryCancel();
    EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  std::vector<v1::ExportResponse> parts;
  ASSERT_OK(Export({}, parts));  // the server still answers
}

}  // namespace
}  // namespace latticed::testing
