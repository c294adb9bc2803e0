// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// MeshService through a stub: uploads, replies, and every refusal with its reason.
#include <cmath>
#include <set>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "tests/server/support/server_test.h"
#include "tests/support/becomes.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

class MeshServiceTest : public SmallServerTest {
 protected:
  void ExpectBad(const v1::MeshHeader& header, const std::string& bytes, const char* reason,
                 const char* named) {
    const absl::Status status = Upload(header, bytes);
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(named)));
    EXPECT_EQ(Reason(status), reason);
    EXPECT_EQ(MeshCount(), 0);
  }

  absl::Status List(const v1::ListMeshesRequest& request,
                    v1::ListMeshesResponse* response = nullptr) {
    return Call(&Meshes::ListMeshes, request, response);
  }

  // Uploads these messages.
  absl::Status Send(const std::vector<v1::UploadMeshRequest>& messages) {
    grpc::ClientContext context;
    v1::Mesh mesh;
    const auto writer = meshes_->UploadMesh(&context, &mesh);
    for (const v1::UploadMeshRequest& message : messages) writer->Write(message);
    writer->WritesDone();
    return client::FromGrpc(writer->Finish());
  }
};

TEST_F(MeshServiceTest, UploadDescribesTheMesh) {
  const std::string obj = CubeObj(2);
  v1::MeshHeader header = ObjHeader(obj);
  header.set_sha256(Sha256Hex(obj));
  header.mutable_units()->set_up_axis(v1::UP_AXIS_Z);
  header.mutable_units()->set_meters_per_unit(0.001);
  (*header.mutable_labels())["project"] = "chair";
  v1::Mesh mesh;

  ASSERT_OK(Upload(header, obj, &mesh));

  EXPECT_EQ(mesh.id(), Sha256Hex(obj));
  EXPECT_EQ(mesh.name(), "cube");
  EXPECT_EQ(mesh.total_bytes(), obj.size());
  EXPECT_EQ(mesh.vertices(), 8u);
  EXPECT_EQ(mesh.faces(), 6u);
  EXPECT_EQ(mesh.corners(), 24u);
  EXPECT_EQ(mesh.bounds().max().y(), 2);
  EXPECT_EQ(mesh.up_axis(), v1::UP_AXIS_Z);
  EXPECT_EQ(mesh.meters_per_unit(), 0.001);
  EXPECT_EQ(mesh.labels().at("project"), "chair");
  EXPECT_FALSE(mesh.has_normals());
  EXPECT_FALSE(mesh.has_weights());
  EXPECT_GT(mesh.host_bytes(), obj.size());
  EXPECT_GT(mesh.create_time().seconds(), 0);
}

TEST_F(MeshServiceTest, SameBytesTwiceAreOneMesh) {
  const v1::Mesh first = UploadObj(CubeObj());
  const std::string obj = CubeObj();
  v1::MeshHeader header = ObjHeader(obj);
  header.set_name("another name");
  v1::Mesh second;

  ASSERT_OK(Upload(header, obj, &second));

  EXPECT_EQ(second.id(), first.id());
  EXPECT_EQ(second.name(), first.name());
  EXPECT_EQ(MeshCount(), 1);
}

TEST_F(MeshServiceTest, HeaderIsCheckedFieldByField) {
  const std::string obj = CubeObj();
  const auto refuse = [&](auto change, const char* reason, const char* named) {
    v1::MeshHeader header = ObjHeader(obj);
    change(header);
    ExpectBad(header, obj, reason, named);
  };
  refuse([](auto& h) { h.clear_format(); }, "INVALID_FIELD", "header.format");
  refuse([](auto& h) { h.set_format(static_cast<v1::MeshFormat>(77)); }, "UNSUPPORTED",
         "header.format");
  refuse([](auto& h) { h.set_total_bytes(0); }, "OUT_OF_RANGE", "header.total_bytes");
  refuse([](auto& h) { h.set_total_bytes(17u << 20); }, "OUT_OF_RANGE", "header.total_bytes");
  refuse([](auto& h) { h.set_name(std::string(256, 'x')); }, "OUT_OF_RANGE", "header.name");
  refuse([](auto& h) { h.set_sha256("abc"); }, "INVALID_FIELD", "header.sha256");
  refuse([](auto& h) { (*h.mutable_labels())["No Key"] = "x"; }, "INVALID_FIELD", "header.labels");
  refuse([](auto& h) { h.mutable_units()->set_meters_per_unit(-1); }, "OUT_OF_RANGE",
         "meters_per_unit: got -1, allowed is 0 to 1.797");
  refuse([](auto& h) { h.mutable_units()->set_meters_per_unit(NAN); }, "NOT_FINITE",
         "meters_per_unit");
  refuse([](auto& h) { h.mutable_units()->set_up_axis(static_cast<v1::UpAxis>(9)); }, "UNSUPPORTED",
         "up_axis");
  refuse([](auto& h) { h.mutable_raw_layout(); }, "INVALID_FIELD", "header.raw_layout");
}

TEST_F(MeshServiceTest, StreamMustBeginWithTheHeader) {
  v1::UploadMeshRequest data;
  data.set_data("v 0 0 0\n");
  ExpectRefused(Send({data}), absl::StatusCode::kFailedPrecondition, "STREAM_NOT_OPENED");
}

TEST_F(MeshServiceTest, PartAbove768KiBIsRefused) {
  v1::UploadMeshRequest header, data;
  data.set_data(std::string((size_t{768} << 10) + 1, '\n'));
  *header.mutable_header() = ObjHeader(data.data());
  const absl::Status status = Send({header, data});
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(Reason(status), "OUT_OF_RANGE");
}

TEST_F(MeshServiceTest, BudgetIsReservedAsBytesComeAndGivenBack) {
  // Four open uploads of 16 MiB, less a byte each, fill the budget of 64 MiB.
  v1::MeshHeader header = ObjHeader("");
  header.set_total_bytes(16u << 20);
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientWriter<v1::UploadMeshRequest>>> writers;
  std::vector<v1::Mesh> meshes(4);
  for (int i = 0; i < 4; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    writers.push_back(meshes_->UploadMesh(contexts.back().get(), &meshes[size_t(i)]));
    v1::UploadMeshRequest request;
    *request.mutable_header() = header;
    writers.back()->Write(request);
    writers.back()->WaitForInitialMetadata();  // the header is admitted
  }
  for (auto& writer : writers) {
    v1::UploadMeshRequest part;
    for (size_t left = (16u << 20) - 1; left > 0; left -= part.data().size()) {
      part.set_data(std::string(std::min(left, size_t{768} << 10), '\n'));
      ASSERT_TRUE(writer->Write(part));
    }
  }
  ASSERT_TRUE(Becomes(2'000, [&] { return Info().reserved_host_bytes() == (64u << 20) - 4; }));
  const std::string obj = CubeObj();
  ExpectRefused(Upload(ObjHeader(obj), obj), absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");

  for (auto& context : contexts) context->TryCancel();
  for (auto& writer : writers) {
    EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }

  // The server notices a cancellation a little later.
  EXPECT_TRUE(Becomes(2000, [&] { return Upload(ObjHeader(obj), obj).ok(); }));
}

// A strip of one byte an index: 3 MB of file, 140 MB of mesh; the budget is 64 MiB.
TEST_F(MeshServiceTest, AMeshThatOutgrowsTheBudgetAsItIsReadIsRefused) {
  const std::string ply = PlyStrip(3'000'000);
  v1::MeshHeader header = ObjHeader(ply);
  header.set_format(v1::MESH_FORMAT_PLY);
  const uint64_t before = Info().reserved_host_bytes();

  const absl::Status refused = Upload(header, ply);

  ExpectRefused(refused, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_THAT(refused.message(), HasSubstr("reading the mesh"));
  // The answer may come before the last of it is given back.
  EXPECT_TRUE(Becomes(2000, [&] { return Info().reserved_host_bytes() == before; }));
}

TEST_F(MeshServiceTest, RawLayoutMustDescribeTheBytes) {
  const uint32_t words[] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 7};  // 3 vertices, 1 face, index 7
  const std::string bytes(reinterpret_cast<const char*>(words), sizeof(words));
  v1::MeshHeader header = ObjHeader(bytes);
  header.set_format(v1::MESH_FORMAT_RAW);
  ExpectBad(header, bytes, "INVALID_FIELD", "header.raw_layout");
  v1::RawLayout& layout = *header.mutable_raw_layout();
  layout.set_vertex_count(0);
  layout.set_face_count(1);
  layout.set_face_size(3);
  ExpectBad(header, bytes, "OUT_OF_RANGE", "vertex_count");
  layout.set_vertex_count(4);
  ExpectBad(header, bytes, "INVALID_FIELD", "describes");
  layout.set_vertex_count(3);
  layout.set_face_size(2);
  ExpectBad(header, bytes, "OUT_OF_RANGE", "face_size");
  layout.set_face_size(3);
  layout.set_position_type(static_cast<v1::ScalarType>(9));
  ExpectBad(header, bytes, "UNSUPPORTED", "position_type");
  layout.clear_position_type();
  EXPECT_THAT(Upload(header, bytes), StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(MeshCount(), 0);
}

TEST_F(MeshServiceTest, ListsPagesByIdAndFiltersByLabel) {
  std::set<std::string> ids;
  for (int i = 1; i <= 5; ++i) {
    const std::string obj = CubeObj(i);
    v1::MeshHeader header = ObjHeader(obj);
    (*header.mutable_labels())["size"] = i > 3 ? "large" : "small";
    v1::Mesh mesh;
    ASSERT_OK(Upload(header, obj, &mesh));
    ids.insert(mesh.id());
  }

  std::vector<std::string> listed;
  v1::ListMeshesRequest request;
  request.set_page_size(2);
  do {
    v1::ListMeshesResponse page;
    ASSERT_TRUE(List(request, &page).ok());
    EXPECT_LE(page.meshes_size(), 2);
    for (const auto& mesh : page.meshes()) listed.push_back(mesh.id());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());

  EXPECT_EQ(listed, std::vector<std::string>(ids.begin(), ids.end()));
  v1::ListMeshesRequest filtered;
  filtered.set_filter("size=large");
  v1::ListMeshesResponse page;
  ASSERT_TRUE(List(filtered, &page).ok());
  EXPECT_EQ(page.meshes_size(), 2);
  EXPECT_EQ(page.next_page_token(), "");
}

TEST_F(MeshServiceTest, BadListsAreRefused) {
  v1::ListMeshesRequest request;
  request.set_page_size(1'001);
  EXPECT_EQ(Reason(List(request)), "OUT_OF_RANGE");
  request.set_page_size(-1);
  EXPECT_EQ(Reason(List(request)), "OUT_OF_RANGE");
  request.set_page_size(1'000);
  EXPECT_TRUE(List(request).ok());
  request.set_filter("=x");
  EXPECT_EQ(Reason(List(request)), "INVALID_FIELD");
}

TEST_F(MeshServiceTest, DownloadGivesTheBytesBack) {
  const std::string obj = CubeObj();
  v1::DownloadMeshRequest request;
  request.set_mesh(Upload(obj));
  request.set_offset(10);
  std::vector<v1::DownloadMeshResponse> parts;
  ASSERT_OK(ReadAll(&Meshes::DownloadMesh, request, &parts));

  EXPECT_EQ(parts.at(0).header().sha256(), request.mesh());
  EXPECT_EQ(parts[0].header().total_bytes(), obj.size());
  std::string bytes;
  for (const auto& part : parts) bytes += part.data();
  EXPECT_EQ(bytes, obj.substr(10));

  request.set_offset(1'000'000);
  EXPECT_EQ(Reason(ReadAll(&Meshes::DownloadMesh, request)), "OUT_OF_RANGE");
}

TEST_F(MeshServiceTest, UnknownMeshIsNotFound) {
  v1::GetMeshRequest request;
  request.set_mesh("no-such-mesh");
  EXPECT_EQ(Reason(ReadAll(&Meshes::DownloadMesh, {})), "NOT_FOUND");
  EXPECT_EQ(Reason(Call(&Meshes::GetMesh, request)), "NOT_FOUND");
  EXPECT_EQ(Reason(DeleteMesh("no-such-mesh")), "NOT_FOUND");
}

TEST_F(MeshServiceTest, MeshInUseIsDeletedOnlyByForce) {
  mesh_ = Upload(CubeObj());
  ASSERT_OK(Create(SceneRequest()));

  ExpectRefused(DeleteMesh(mesh_), absl::StatusCode::kFailedPrecondition, "MESH_IN_USE");
  EXPECT_OK(DeleteMesh(mesh_, /*force=*/true));

  EXPECT_EQ(Reason(Call(&Scenes::GetScene, For<v1::GetSceneRequest>())), "NOT_FOUND");
  EXPECT_EQ(MeshCount(), 0);
}

}  // namespace
}  // namespace latticed::testing
