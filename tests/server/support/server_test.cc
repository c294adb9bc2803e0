// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/support/server_test.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/backend.h"
#include "core/base/limits.h"
#include "fmt/format.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

// A grid of cells x cells quads. `vertex` returns the coordinates of vertex (i, j) as text.
std::string GridObj(int cells, const std::function<std::string(int, int)>& vertex) {
  std::string obj;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) obj += fmt::format("v {}\n", vertex(i, j));
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int v = 1 + i + (cells + 1) * j;
      obj += fmt::format("f {} {} {} {}\n", v, v + 1, v + cells + 2, v + cells + 1);
    }
  }
  return obj;
}

}  // namespace

std::string PlaneObj(int cells) {
  return GridObj(cells, [](int i, int j) { return fmt::format("{} {} 0", i, j); });
}

std::string WavyGridObj(int cells) {
  return GridObj(cells, [cells](int i, int j) {
    const double x = static_cast<double>(i) / cells, y = static_cast<double>(j) / cells;
    return fmt::format("{} {} {}", x, y, 0.2 * std::sin(7 * x + 5 * y));
  });
}

std::string CubeObj(double edge) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    text += fmt::format("v {} {} {}\n", (i & 1) * edge, ((i >> 1) & 1) * edge, (i >> 2) * edge);
  }
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

std::string GroupsObj(int count, const std::string& name) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 1\n";
  for (int i = 0; i < count; ++i) text += fmt::format("g {}{}\nf 1 2 3\n", name, i);
  return text;
}

v1::MeshHeader ObjHeader(const std::string& bytes) {
  v1::MeshHeader header;
  header.set_name("cube");
  header.set_format(v1::MESH_FORMAT_OBJ);
  header.set_total_bytes(bytes.size());
  return header;
}

Options TestOptions() {
  Options options;
  options.memory_bytes = uint64_t{64} << 20;
  options.max_mesh_bytes = uint64_t{16} << 20;
  options.drain_delay = absl::ZeroDuration();
  options.node = "test-node";
  return options;
}

void SetAxes(v1::LatticeAxes& axes, int u, int v, int w) {
  axes.set_u(u);
  axes.set_v(v);
  axes.set_w(w);
}

v1::Vec3 ToVec3(Vec3d v) {
  v1::Vec3 message;
  message.set_x(v.x);
  message.set_y(v.y);
  message.set_z(v.z);
  return message;
}

void SetFrame(v1::LatticeFrame& frame, Vec3d origin, Vec3d size) {
  *frame.mutable_origin() = ToVec3(origin);
  frame.mutable_u()->set_x(size.x);
  frame.mutable_v()->set_y(size.y);
  frame.mutable_w()->set_z(size.z);
}

void AddLongLabels(google::protobuf::Map<std::string, std::string>& labels) {
  for (size_t i = 0; i < limits::kMaxLabels; ++i) {
    labels[fmt::format("k{:062}", i)] = std::string(limits::kMaxLabelValueBytes, 'v');
  }
}

void ExpectRefusal(const absl::Status& status, const Refusal& refusal, const char* file, int line) {
  const ::testing::ScopedTrace trace(file, line, "refused");
  EXPECT_THAT(status, StatusIs(refusal.code, ::testing::HasSubstr(refusal.message)));
  const error::Details details = error::DetailsOf(status);
  EXPECT_EQ(details.reason, refusal.reason) << status;
  EXPECT_EQ(details.field, refusal.field) << status;
}

namespace {

// A client that sends nothing for three heartbeats gets no updates. Those of tests send no heartbeats, and under a
// sanitizer they may be slow.
void WaitForSlowClients(Options& options) {
  if (options.heartbeat_interval == Options().heartbeat_interval) {
    options.heartbeat_interval = absl::Seconds(20);
  }
}

}  // namespace

void ServerTest::StartServer(Options options) {
  server_.reset();
  WaitForSlowClients(options);
  options.backend = "cpu";
  options.threads = std::max(options.threads, 1);
  options.log_level = "off";
  Use(InProcessServer::Start(std::move(options)));
}

void ServerTest::StartServerOn(std::unique_ptr<Backend> backend, Options options,
                               std::shared_ptr<Store> store) {
  std::vector<std::unique_ptr<Backend>> backends;
  backends.push_back(std::move(backend));
  options.log_level = "off";
  WaitForSlowClients(options);
  Use(InProcessServer::Start(std::move(options), std::move(backends), std::move(store)));
}

void ServerTest::Use(absl::StatusOr<std::unique_ptr<InProcessServer>> server) {
  ASSERT_OK(server);
  server_ = *std::move(server);
  Reach(server_->channel());
}

void ServerTest::Reach(const std::shared_ptr<grpc::Channel>& channel) {
  meshes_ = v1::MeshService::NewStub(channel);
  scenes_ = v1::SceneService::NewStub(channel);
  infos_ = v1::ServerService::NewStub(channel);
}

absl::Status ServerTest::Upload(const v1::MeshHeader& header, std::string_view bytes,
                                v1::Mesh* mesh, const Metadata& metadata) {
  constexpr size_t kPartBytes = size_t{64} << 10;
  grpc::ClientContext context;
  for (const auto& [name, value] : metadata) context.AddMetadata(name, value);
  v1::Mesh ignored;
  const auto writer = meshes_->UploadMesh(&context, mesh != nullptr ? mesh : &ignored);
  v1::UploadMeshRequest request;
  *request.mutable_header() = header;
  bool open = writer->Write(request);
  for (size_t at = 0; open && at < bytes.size(); at += kPartBytes) {
    request.set_data(std::string(bytes.substr(at, kPartBytes)));
    open = writer->Write(request);
  }
  writer->WritesDone();
  return client::FromGrpc(writer->Finish());
}

v1::Mesh ServerTest::UploadObj(const std::string& obj) {
  v1::Mesh mesh;
  EXPECT_OK(Upload(ObjHeader(obj), obj, &mesh));
  return mesh;
}

absl::Status ServerTest::DeleteMesh(const std::string& mesh, bool force) {
  v1::DeleteMeshRequest request;
  request.set_mesh(mesh);
  request.set_force(force);
  return Call(&Meshes::DeleteMesh, request);
}

int ServerTest::MeshCount() {
  v1::ListMeshesResponse response;
  EXPECT_OK(Call(&Meshes::ListMeshes, {}, &response));
  return response.meshes_size();
}

int ServerTest::SceneCount() {
  v1::ListScenesResponse response;
  EXPECT_OK(Call(&Scenes::ListScenes, {}, &response));
  return response.scenes_size();
}

v1::ServerInfo ServerTest::Info() {
  v1::ServerInfo info;
  EXPECT_OK(Call(&Infos::GetServerInfo, {}, &info));
  return info;
}

v1::CreateSceneRequest ServerTest::SceneRequest(const std::string& id) const {
  v1::CreateSceneRequest request;
  request.set_scene_id(id);
  request.set_mesh(mesh_);
  return request;
}

v1::Scene ServerTest::Get(const std::string& scene) {
  v1::Scene result;
  EXPECT_OK(Call(&Scenes::GetScene, For<v1::GetSceneRequest>(scene), &result));
  return result;
}

double ServerTest::MeasuredVolume(const std::string& scene) {
  auto request = For<v1::MeasureSceneRequest>(scene);
  request.add_measures(v1::MEASURE_VOLUME);
  v1::MeasureSceneResponse response;
  EXPECT_OK(Call(&Scenes::MeasureScene, request, &response));
  return response.volume();
}

v1::LatticeState ServerTest::Lattice() {
  v1::LatticeState state;
  EXPECT_OK(Call(&Scenes::GetLattice, For<v1::GetLatticeRequest>(), &state));
  return state;
}

v1::EditBatch ServerTest::MoveOne(const std::string& editor, uint64_t sequence, uint32_t point,
                                  Vec3d offset) {
  v1::EditBatch batch = For<v1::EditBatch>();
  batch.set_editor_id(editor);
  batch.set_sequence(sequence);
  batch.set_structure_id(1);
  v1::MoveControlPoints& move = *batch.add_edits()->mutable_move_control_points();
  move.add_indices(point);
  *move.mutable_offset() = ToVec3(offset);
  return batch;
}

absl::Status ServerTest::Update(const v1::GetUpdateRequest& request, EventLog& log) {
  std::vector<v1::SceneEvent> events;
  const absl::Status status = ReadAll(&Scenes::GetUpdate, request, &events);
  for (const v1::SceneEvent& event : events) log.Take(event);
  return status;
}

absl::Status ServerTest::Update(int segments, const std::string& scene, EventLog* log) {
  auto request = For<v1::GetUpdateRequest>(scene);
  request.mutable_view()->set_segments(segments);
  EventLog ignored;
  return Update(request, log != nullptr ? *log : ignored);
}

absl::StatusOr<std::string> ServerTest::Export(const v1::ExportRequest& request) {
  std::vector<v1::ExportResponse> parts;
  if (auto status = ReadAll(&Scenes::Export, request, &parts); !status.ok()) return status;
  std::string bytes;
  for (const v1::ExportResponse& part : parts) bytes += part.data();
  return bytes;
}

double ServerTest::Metric(const std::string& series) const {
  const std::string metrics = server_->metrics(), line = "\n" + series + " ";
  const size_t at = metrics.find(line);
  return at == std::string::npos ? -1 : std::stod(metrics.substr(at + line.size()));
}

void SceneFixture::StartServer(Options options) {
  ASSERT_NO_FATAL_FAILURE(ServerTest::StartServer(std::move(options)));
  mesh_ = Upload(kGridObj);
}

absl::Status SceneFixture::OnceIdle(const std::function<absl::Status()>& call) {
  absl::Status status;
  Becomes(2'000, [&] {
    status = call();
    return !absl::IsResourceExhausted(status);
  });
  return status;
}

absl::Status SceneFixture::DeleteMeshOnceUnused() {
  absl::Status status;
  Becomes(2'000, [&] {
    status = DeleteMesh(mesh_);
    return status.ok();
  });
  return status;
}

v1::EditBatch SceneFixture::UndoMine(const std::string& editor, uint64_t sequence) {
  v1::EditBatch batch;
  batch.set_scene(kScene);
  batch.set_editor_id(editor);
  batch.set_sequence(sequence);
  batch.set_structure_id(Lattice().structure_id());
  batch.add_edits()->mutable_undo();
  return batch;
}

std::string SceneFixture::Ply() {
  auto bytes = Export(For<v1::ExportRequest>());
  EXPECT_OK(bytes);
  return bytes.value_or("");
}

v1::EditBatch SceneFixture::Knot(const std::string& editor, uint64_t sequence) {
  v1::EditBatch batch = Move(editor, sequence, 0, 0);
  batch.mutable_edits(0)->mutable_insert_knot()->set_value(0.5);
  return batch;
}

void StreamTest::StartServer(absl::Duration heartbeat) {
  ServerTest::StartServer(
      {.threads = 2, .heartbeat_interval = heartbeat, .drain_delay = absl::Milliseconds(100)});
}

void StreamTest::CreateScene(int cells) {
  mesh_ = Upload(WavyGridObj(cells));
  v1::CreateSceneRequest request = SceneRequest();
  v1::LatticeFit& fit = *request.add_lattices()->mutable_fit();
  SetAxes(*fit.mutable_size(), 5, 5, 5);
  SetAxes(*fit.mutable_degree(), 2, 2, 2);
  request.mutable_default_view()->set_segments(4);
  request.mutable_default_view()->set_encoding(v1::ENCODING_QUANTISED);
  v1::Scene scene;
  ASSERT_OK(Create(request, &scene));
  structure_id_ = scene.structure_id();
}

v1::WatchRequest StreamTest::Watch(const std::string& editor) const {
  auto request = For<v1::WatchRequest>();
  request.set_editor_id(editor);
  request.set_max_unacked_updates(0);
  return request;
}

v1::EditBatch StreamTest::Move(uint64_t sequence, uint32_t point, double dz,
                               const std::string& editor) const {
  v1::EditBatch batch = MoveOne(editor, sequence, point, {0, 0, dz});
  batch.set_structure_id(structure_id_);
  return batch;
}

absl::Status StreamTest::Control(const WatchClient& watcher, v1::ControlWatchRequest request,
                                 v1::ControlWatchResponse* response) {
  request.set_watch_id(watcher.log.hello.watch_id());
  return Call(&Scenes::ControlWatch, request, response);
}

}  // namespace latticed::testing
