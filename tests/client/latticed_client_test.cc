// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The client's calls, uploads and streams against a real server in this process.
#include "client/cpp/library/latticed_client.h"

#include <stop_token>

#include "core/base/error.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/write/write_mesh.h"
#include "tests/client/quiet_server.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::latticed::testing::StatusIs;

constexpr char kTriangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

class ClientTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(server_, nullptr);
    client_ = std::make_unique<Client>(server_->channel(), "");
  }

  static absl::StatusOr<v1::Mesh> UploadTriangle(Client& client, const Progress& progress = {}) {
    v1::MeshHeader header;
    header.set_format(v1::MESH_FORMAT_OBJ);
    return client.UploadMesh(kTriangle, header, progress);
  }
  // Uploads the triangle. Returns a request for a scene of it.
  static v1::CreateSceneRequest SceneRequest(Client& client) {
    const auto mesh = UploadTriangle(client);
    EXPECT_OK(mesh);
    v1::CreateSceneRequest request;
    request.set_mesh(mesh.value_or(v1::Mesh()).id());
    return request;
  }
  // Creates a scene of the triangle. Returns a request to watch it.
  static v1::WatchRequest WatchOfNewScene(Client& client) {
    const auto scene = client.CreateScene(SceneRequest(client));
    EXPECT_OK(scene);
    v1::WatchRequest watch;
    watch.set_scene(scene.value_or(v1::Scene()).id());
    return watch;
  }
  // Moves the first control point by 1 along x.
  static v1::EditBatch OneMove() {
    v1::EditBatch batch;
    batch.add_edits()->mutable_move_control_points()->add_indices(0);
    batch.mutable_edits(0)->mutable_move_control_points()->mutable_offset()->set_x(1);
    return batch;
  }

  const std::unique_ptr<InProcessServer> server_ = StartServer();
  std::unique_ptr<Client> client_;
};

// A raw mesh of triangles. 6 vertices and 2 faces take as many bytes as 7 vertices and 1 face.
v1::MeshHeader RawHeader(uint64_t vertices, uint64_t faces) {
  v1::MeshHeader header;
  header.set_format(v1::MESH_FORMAT_RAW);
  header.mutable_raw_layout()->set_vertex_count(vertices);
  header.mutable_raw_layout()->set_face_count(faces);
  header.mutable_raw_layout()->set_face_size(3);
  return header;
}

TEST_F(ClientTest, TheSameBytesInAnotherLayoutAreAnotherMesh) {
  // 3 floats per vertex, 3 indices per face: n vertices and m faces take 12 (n + m) bytes.
  const std::string bytes(12 * 8, '\0');
  const auto first = client_->UploadMesh(bytes, RawHeader(6, 2));
  ASSERT_OK(first);
  EXPECT_EQ(first->faces(), 2u);

  EXPECT_THAT(client_->UploadMesh(bytes, RawHeader(7, 1)),
              StatusIs(absl::StatusCode::kAlreadyExists));
  const auto again = client_->UploadMesh(bytes, RawHeader(6, 2));
  ASSERT_OK(again);
  EXPECT_EQ(again->id(), first->id());
}

TEST_F(ClientTest, AMeshThatIsThereIsNotSentAgain) {
  int reports = 0;
  const Progress count = [&](uint64_t done, uint64_t total) {
    ++reports;
    EXPECT_EQ(done, total);
  };
  ASSERT_OK(UploadTriangle(*client_));
  const auto again = UploadTriangle(*client_, count);
  ASSERT_OK(again);
  EXPECT_EQ(reports, 1);
  EXPECT_EQ(again->faces(), 1u);
}

TEST_F(ClientTest, AStopCancelsAllButDeletions) {
  std::stop_source stop;
  Client client(server_->channel(), "", stop.get_token());
  const v1::CreateSceneRequest request = SceneRequest(client);
  const std::string& mesh = request.mesh();
  const v1::WatchRequest watch = WatchOfNewScene(client);
  const std::string& scene = watch.scene();
  const auto stream = client.Deform(watch);
  ASSERT_OK(stream);

  stop.request_stop();

  const auto end = (*stream)->Next();
  ASSERT_OK(end);
  EXPECT_TRUE(end->ended());
  v1::GetUpdateRequest update;
  update.set_scene(scene);
  v1::ExportRequest file;
  file.set_scene(scene);
  const std::vector<absl::Status> cancelled{
      client.GetServerInfo().status(),      client.GetMesh(mesh).status(),
      client.ListMeshes().status(),         client.UploadMesh("new", RawHeader(0, 0)).status(),
      client.CreateScene(request).status(), client.GetScene(scene).status(),
      client.ListScenes().status(),         client.GetLattice(scene).status(),
      client.ApplyEdits({}).status(),       client.EvaluatePoints({}).status(),
      client.GetUpdate(update).status(),    client.GetTopology(scene, "").status(),
      client.Export(file).status(),         client.Watch(watch).status(),
      client.Deform(watch).status(),        client.Pick({}).status(),
      client.MeasureScene({}).status()};
  for (size_t i = 0; i < cancelled.size(); ++i) {
    EXPECT_THAT(cancelled[i], StatusIs(absl::StatusCode::kCancelled)) << i;
  }
  EXPECT_OK(client.DeleteScene(scene));
  EXPECT_OK(client.DeleteMesh(mesh, /*force=*/false));
}

TEST_F(ClientTest, StreamsSeeEachOthersPresence) {
  v1::WatchRequest watch = WatchOfNewScene(*client_);
  watch.set_editor_id("alice");
  const auto alice = client_->Deform(watch);
  ASSERT_OK(alice);
  watch.set_editor_id("bob");
  const auto bob = client_->Watch(watch);
  ASSERT_OK(bob);
  v1::Presence presence;
  presence.set_name("Bob");
  ASSERT_OK((*bob)->Show(presence));
  presence.set_name("Alice");
  presence.mutable_camera()->mutable_position()->set_y(-5);
  presence.mutable_camera()->mutable_up()->set_z(1);
  presence.mutable_camera()->set_fov_y(40);
  ASSERT_OK((*alice)->Show(presence));

  const auto edit = (*alice)->Send(OneMove());
  ASSERT_OK(edit);
  ASSERT_OK((*alice)->WaitFor(*edit));
  ASSERT_OK((*bob)->Next());

  ASSERT_EQ((*alice)->others().size(), 1u);
  EXPECT_EQ((*alice)->others().at("bob").name(), "Bob");
  ASSERT_EQ((*bob)->others().size(), 1u);
  EXPECT_EQ((*bob)->others().at("alice").name(), "Alice");
  EXPECT_EQ((*bob)->others().at("alice").camera().fov_y(), 40);
  (*alice)->HalfClose();
  while (!(*alice)->Next().value_or(DeformStream::Step{}).ended()) continue;
  EXPECT_THAT((*alice)->Show(presence), StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST_F(ClientTest, ExportsCarryUpAxisAndUnit) {
  const std::string obj = "v 0 0 0\nv 100 0 0\nv 100 0 200\nf 1 2 3\n";
  v1::MeshHeader header;
  header.set_format(v1::MESH_FORMAT_OBJ);
  header.mutable_units()->set_up_axis(v1::UP_AXIS_Z);
  header.mutable_units()->set_meters_per_unit(0.01);
  const auto mesh = client_->UploadMesh(obj, header);
  ASSERT_OK(mesh);
  v1::CreateSceneRequest request;
  request.set_mesh(mesh->id());
  request.mutable_default_view()->set_segments(1);
  const auto scene = client_->CreateScene(std::move(request));
  ASSERT_OK(scene);
  const auto export_as = [&](v1::ExportFormat format) {
    v1::ExportRequest wanted;
    wanted.set_scene(scene->id());
    wanted.set_format(format);
    const auto file = client_->Export(wanted);
    EXPECT_OK(file);
    return file.ok() ? file->bytes : "";
  };

  for (const auto format : {v1::EXPORT_FORMAT_PLY, v1::EXPORT_FORMAT_OBJ, v1::EXPORT_FORMAT_STL}) {
    EXPECT_THAT(export_as(format).substr(0, 100), ::testing::HasSubstr("up +z, 0.01 m per unit"));
  }
  const std::string glb = export_as(v1::EXPORT_FORMAT_GLB);
  EXPECT_THAT(glb, ::testing::HasSubstr(R"("extras":{"metersPerUnit":0.01,"upAxis":"z"})"));
  // A reader that ignores the extras sees metres and +y up.
  const auto read = ReadMesh(MeshFormat::kGlb, glb);
  ASSERT_OK(read);
  const Bounds bounds = read->ComputeBounds();
  EXPECT_LE(Norm(bounds.min - Vec3d{0, 0, 0}), 1e-5);
  EXPECT_LE(Norm(bounds.max - Vec3d{1, 2, 0}), 1e-5);
}

TEST_F(ClientTest, AGlbIsInMetresAndYUpAndASceneMayReadItOtherwise) {
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 1 0 2\nf 1 2 3\n";
  const auto parsed = ReadMesh(MeshFormat::kObj, obj);
  ASSERT_OK(parsed);
  v1::MeshHeader header;
  header.set_format(v1::MESH_FORMAT_GLB);
  const auto glb = WriteGlb(*parsed);
  ASSERT_OK(glb);
  const auto mesh = client_->UploadMesh(*glb, header);
  ASSERT_OK(mesh);
  EXPECT_EQ(mesh->up_axis(), v1::UP_AXIS_Y);
  EXPECT_EQ(mesh->meters_per_unit(), 1);
  v1::CreateSceneRequest request;
  request.set_mesh(mesh->id());
  request.mutable_units()->set_up_axis(v1::UP_AXIS_Z);
  const auto scene = client_->CreateScene(std::move(request));
  ASSERT_OK(scene);

  v1::ExportRequest wanted;
  wanted.set_scene(scene->id());
  wanted.set_format(v1::EXPORT_FORMAT_OBJ);
  const auto file = client_->Export(wanted);

  ASSERT_OK(file);
  EXPECT_THAT(file->bytes.substr(0, 100), ::testing::HasSubstr("up +z, 1 m per unit"));
}

TEST_F(ClientTest, AnErrorSaysReasonFieldAndTheRequestIdOfTheServersLog) {
  const auto missing = client_->GetScene("no-such-scene");
  EXPECT_THAT(missing, StatusIs(absl::StatusCode::kNotFound));
  const error::Details details = error::DetailsOf(missing.status());
  EXPECT_EQ(details.reason, "NOT_FOUND");
  EXPECT_EQ(details.metadata.at("kind"), "scene");
  EXPECT_EQ(details.metadata.at("id"), "no-such-scene");
  EXPECT_THAT(details.metadata.at("request_id"), ::testing::MatchesRegex("[0-9a-f]{16}"));

  v1::CreateSceneRequest request;
  request.set_scene_id("a b");
  const auto refused = client_->CreateScene(std::move(request));
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(error::DetailsOf(refused.status()).field, "scene_id");
  EXPECT_EQ(error::DetailsOf(refused.status()).metadata.count("request_id"), 1u);
  for (const auto& stream_error :
       {client_->GetUpdate({}).status(), client_->Watch({}).status(), client_->Deform({}).status(),
        client_->Export({}).status(), client_->UploadMesh("", {}).status()}) {
    EXPECT_EQ(error::DetailsOf(stream_error).metadata.count("request_id"), 1u) << stream_error;
  }
}

}  // namespace
}  // namespace latticed::client
