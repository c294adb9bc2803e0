// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// MeshService through a stub: what is taken, what comes back, and every refusal with its reason.
#include <cmath>
#include <set>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "tests/server/test_env.h"
#include "tests/support/becomes.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::CubeObj;
using ::latticed::testing::ObjHeader;
using ::latticed::testing::Reason;
using ::latticed::testing::TestEnv;
using ::testing::HasSubstr;

class MeshServiceTest : public ::testing::Test {
 protected:
  void ExpectRefused(const v1::MeshHeader& header, const std::string& bytes, const char* reason,
                     const char* named) {
    v1::Mesh mesh;
    const grpc::Status status = env_.Upload(header, bytes, &mesh);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << status.error_message();
    EXPECT_EQ(Reason(status), reason) << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr(named));
    EXPECT_EQ(MeshCount(), 0);
  }

  int MeshCount() {
    grpc::ClientContext context;
    v1::ListMeshesResponse response;
    EXPECT_TRUE(env_.meshes().ListMeshes(&context, {}, &response).ok());
    return response.meshes_size();
  }

  grpc::Status List(const v1::ListMeshesRequest& request, v1::ListMeshesResponse* response) {
    grpc::ClientContext context;
    return env_.meshes().ListMeshes(&context, request, response);
  }

  grpc::Status Delete(const std::string& id, bool force) {
    grpc::ClientContext context;
    v1::DeleteMeshRequest request;
    request.set_mesh(id);
    request.set_force(force);
    v1::DeleteMeshResponse response;
    return env_.meshes().DeleteMesh(&context, request, &response);
  }

  TestEnv env_;
};

TEST_F(MeshServiceTest, UploadDescribesTheMesh) {
  const std::string obj = CubeObj(2);
  v1::MeshHeader header = ObjHeader(obj);
  header.set_sha256(Sha256Hex(obj));
  header.mutable_units()->set_up_axis(v1::UP_AXIS_Z);
  header.mutable_units()->set_meters_per_unit(0.001);
  (*header.mutable_labels())["project"] = "chair";
  v1::Mesh mesh;

  const grpc::Status status = env_.Upload(header, obj, &mesh);

  ASSERT_TRUE(status.ok()) << status.error_message();
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
  EXPECT_GT(mesh.host_bytes(), obj.size());
  EXPECT_GT(mesh.create_time().seconds(), 0);
}

TEST_F(MeshServiceTest, SameBytesTwiceAreOneMesh) {
  const v1::Mesh first = env_.UploadCube();
  const std::string obj = CubeObj();
  v1::MeshHeader header = ObjHeader(obj);
  header.set_name("another name");
  v1::Mesh second;

  ASSERT_TRUE(env_.Upload(header, obj, &second).ok());

  EXPECT_EQ(second.id(), first.id());
  EXPECT_EQ(second.name(), first.name());
  EXPECT_EQ(MeshCount(), 1);
}

TEST_F(MeshServiceTest, HeaderIsCheckedFieldByField) {
  const std::string obj = CubeObj();
  const auto refuse = [&](auto change, const char* reason, const char* named) {
    v1::MeshHeader header = ObjHeader(obj);
    change(header);
    ExpectRefused(header, obj, reason, named);
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

TEST_F(MeshServiceTest, BytesMustBeAsAnnounced) {
  const std::string obj = CubeObj();
  v1::MeshHeader header = ObjHeader(obj);
  header.set_sha256(std::string(64, '0'));
  ExpectRefused(header, obj, "HASH_MISMATCH", "header.sha256");
  ExpectRefused(ObjHeader(obj), obj + "\n", "SIZE_MISMATCH", "announced");
  ExpectRefused(ObjHeader(obj), obj.substr(1), "SIZE_MISMATCH", "announced");
}

TEST_F(MeshServiceTest, MalformedFilesOfEveryFormatAreRefused) {
  const std::string junk =
      "this is no mesh at all, whatever the format; 84 bytes and more of it ....."
      "..............................";
  for (const auto format : {v1::MESH_FORMAT_OBJ, v1::MESH_FORMAT_PLY, v1::MESH_FORMAT_STL,
                            v1::MESH_FORMAT_GLB, v1::MESH_FORMAT_DRACO}) {
    SCOPED_TRACE(v1::MeshFormat_Name(format));
    v1::MeshHeader header = ObjHeader(junk);
    header.set_format(format);
    ExpectRefused(header, junk, "MALFORMED_FILE", "");
  }
}

TEST_F(MeshServiceTest, StreamMustBeginWithTheHeader) {
  grpc::ClientContext context;
  v1::Mesh mesh;
  const auto writer = env_.meshes().UploadMesh(&context, &mesh);
  v1::UploadMeshRequest request;
  request.set_data("v 0 0 0\n");
  writer->Write(request);
  writer->WritesDone();

  const grpc::Status status = writer->Finish();

  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(Reason(status), "STREAM_NOT_OPENED");
}

TEST_F(MeshServiceTest, PartAbove768KiBIsRefused) {
  const std::string large((size_t{768} << 10) + 1, '\n');
  grpc::ClientContext context;
  v1::Mesh mesh;
  const auto writer = env_.meshes().UploadMesh(&context, &mesh);
  v1::UploadMeshRequest request;
  *request.mutable_header() = ObjHeader(large);
  writer->Write(request);
  request.set_data(large);
  writer->Write(request);
  writer->WritesDone();

  const grpc::Status status = writer->Finish();

  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Reason(status), "OUT_OF_RANGE");
}

TEST_F(MeshServiceTest, BudgetIsReservedByHeadersAndGivenBack) {
  // 64 MiB of budget: four open uploads of 16 MiB fill it.
  v1::MeshHeader header = ObjHeader("");
  header.set_total_bytes(16u << 20);
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientWriter<v1::UploadMeshRequest>>> writers;
  std::vector<v1::Mesh> meshes(4);
  for (int i = 0; i < 4; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    writers.push_back(env_.meshes().UploadMesh(contexts.back().get(), &meshes[size_t(i)]));
    v1::UploadMeshRequest request;
    *request.mutable_header() = header;
    writers.back()->Write(request);
    writers.back()->WaitForInitialMetadata();  // the header is admitted
  }
  const std::string obj = CubeObj();
  v1::Mesh mesh;
  grpc::Status status = env_.Upload(ObjHeader(obj), obj, &mesh);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(Reason(status), "OUT_OF_MEMORY");

  for (auto& context : contexts) context->TryCancel();
  for (auto& writer : writers) {
    EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }

  const auto uploads = [&] {  // the server hears of a cancellation a little later
    status = env_.Upload(ObjHeader(obj), obj, &mesh);
    return status.ok();
  };
  EXPECT_TRUE(testing::Becomes(2000, uploads)) << status.error_message();
}

TEST_F(MeshServiceTest, RawArraysAreRead) {
  const float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const uint32_t corners[] = {0, 1, 2, 3};
  const float normals[] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  const uint32_t groups[] = {0};
  std::string bytes;
  const auto append = [&bytes](const auto& array) {
    bytes.append(reinterpret_cast<const char*>(array), sizeof(array));
  };
  append(positions);
  append(corners);
  append(normals);
  append(groups);
  v1::MeshHeader header = ObjHeader(bytes);
  header.set_format(v1::MESH_FORMAT_RAW);
  v1::RawLayout& layout = *header.mutable_raw_layout();
  layout.set_vertex_count(4);
  layout.set_face_count(1);
  layout.set_face_size(4);
  layout.set_normals(v1::ATTRIBUTE_DOMAIN_VERTEX);
  layout.add_group_names("seat");
  v1::Mesh mesh;

  const grpc::Status status = env_.Upload(header, bytes, &mesh);

  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(mesh.faces(), 1u);
  EXPECT_TRUE(mesh.has_normals());
  ASSERT_EQ(mesh.groups_size(), 1);
  EXPECT_EQ(mesh.groups(0).name(), "seat");
  EXPECT_EQ(mesh.groups(0).faces(), 1u);
  header.mutable_raw_layout()->set_face_size(0);
  header.mutable_raw_layout()->set_corner_count(4);
  EXPECT_EQ(env_.Upload(header, bytes, &mesh).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(MeshServiceTest, RawLayoutMustDescribeTheBytes) {
  const uint32_t words[] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 7};  // 3 vertices, 1 face, index 7
  const std::string bytes(reinterpret_cast<const char*>(words), sizeof(words));
  v1::MeshHeader header = ObjHeader(bytes);
  header.set_format(v1::MESH_FORMAT_RAW);
  ExpectRefused(header, bytes, "INVALID_FIELD", "header.raw_layout");
  v1::RawLayout& layout = *header.mutable_raw_layout();
  layout.set_vertex_count(0);
  layout.set_face_count(1);
  layout.set_face_size(3);
  ExpectRefused(header, bytes, "OUT_OF_RANGE", "vertex_count");
  layout.set_vertex_count(4);
  ExpectRefused(header, bytes, "INVALID_FIELD", "describes");
  layout.set_vertex_count(3);
  layout.set_face_size(2);
  ExpectRefused(header, bytes, "OUT_OF_RANGE", "face_size");
  layout.set_face_size(3);
  layout.set_position_type(static_cast<v1::ScalarType>(9));
  ExpectRefused(header, bytes, "UNSUPPORTED", "position_type");
  layout.clear_position_type();
  v1::Mesh mesh;
  EXPECT_EQ(env_.Upload(header, bytes, &mesh).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(MeshCount(), 0);
}

TEST_F(MeshServiceTest, ListsPagesByIdAndFiltersByLabel) {
  std::set<std::string> ids;
  for (int i = 1; i <= 5; ++i) {
    const std::string obj = CubeObj(i);
    v1::MeshHeader header = ObjHeader(obj);
    (*header.mutable_labels())["size"] = i > 3 ? "large" : "small";
    v1::Mesh mesh;
    ASSERT_TRUE(env_.Upload(header, obj, &mesh).ok());
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
  v1::ListMeshesResponse response;
  v1::ListMeshesRequest request;
  request.set_page_size(1'001);
  EXPECT_EQ(Reason(List(request, &response)), "OUT_OF_RANGE");
  request.set_page_size(-1);
  EXPECT_EQ(Reason(List(request, &response)), "OUT_OF_RANGE");
  request.set_page_size(1'000);
  EXPECT_TRUE(List(request, &response).ok());
  request.set_filter("=x");
  EXPECT_EQ(Reason(List(request, &response)), "INVALID_FIELD");
}

TEST_F(MeshServiceTest, DownloadGivesTheBytesBack) {
  const std::string obj = CubeObj();
  const v1::Mesh mesh = env_.UploadCube();
  v1::DownloadMeshRequest request;
  request.set_mesh(mesh.id());
  request.set_offset(10);
  grpc::ClientContext context;
  const auto reader = env_.meshes().DownloadMesh(&context, request);
  v1::DownloadMeshResponse part;
  ASSERT_TRUE(reader->Read(&part));
  const v1::MeshHeader header = part.header();

  std::string bytes;
  while (reader->Read(&part)) bytes += part.data();

  EXPECT_TRUE(reader->Finish().ok());
  EXPECT_EQ(bytes, obj.substr(10));
  EXPECT_EQ(header.sha256(), mesh.id());
  EXPECT_EQ(header.total_bytes(), obj.size());
}

TEST_F(MeshServiceTest, DownloadPastTheEndIsRefused) {
  v1::DownloadMeshRequest request;
  request.set_mesh(env_.UploadCube().id());
  request.set_offset(1'000'000);
  grpc::ClientContext context;
  v1::DownloadMeshResponse part;
  const auto reader = env_.meshes().DownloadMesh(&context, request);

  EXPECT_FALSE(reader->Read(&part));
  EXPECT_EQ(Reason(reader->Finish()), "OUT_OF_RANGE");
}

TEST_F(MeshServiceTest, UnknownMeshIsNotFound) {
  grpc::ClientContext context, download;
  v1::GetMeshRequest request;
  request.set_mesh("no-such-mesh");
  v1::Mesh mesh;
  v1::DownloadMeshRequest download_request;
  v1::DownloadMeshResponse part;
  const auto reader = env_.meshes().DownloadMesh(&download, download_request);

  EXPECT_FALSE(reader->Read(&part));
  EXPECT_EQ(Reason(reader->Finish()), "NOT_FOUND");
  EXPECT_EQ(Reason(env_.meshes().GetMesh(&context, request, &mesh)), "NOT_FOUND");
  EXPECT_EQ(Reason(Delete("no-such-mesh", false)), "NOT_FOUND");
}

TEST_F(MeshServiceTest, MeshInUseIsDeletedOnlyByForce) {
  const v1::Mesh mesh = env_.UploadCube();
  v1::CreateSceneRequest create;
  create.set_scene_id("scene-of-the-cube");
  create.set_mesh(mesh.id());
  v1::Scene scene;
  grpc::ClientContext create_context, get_context;
  ASSERT_TRUE(env_.scenes().CreateScene(&create_context, create, &scene).ok());

  const grpc::Status refused = Delete(mesh.id(), false);
  const grpc::Status forced = Delete(mesh.id(), true);

  EXPECT_EQ(refused.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(Reason(refused), "MESH_IN_USE");
  EXPECT_TRUE(forced.ok()) << forced.error_message();
  v1::GetSceneRequest get;
  get.set_scene("scene-of-the-cube");
  EXPECT_EQ(Reason(env_.scenes().GetScene(&get_context, get, &scene)), "NOT_FOUND");
  EXPECT_EQ(MeshCount(), 0);
}

}  // namespace
}  // namespace latticed
