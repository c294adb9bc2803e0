// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/stream_support.h"

#include <cmath>
#include <utility>

#include "fmt/format.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

std::string WavyGridObj(int cells) {
  std::string text;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const double x = static_cast<double>(i) / cells;
      const double y = static_cast<double>(j) / cells;
      text += fmt::format("v {} {} {}\n", x, y, 0.2 * std::sin(7 * x + 5 * y));
    }
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int a = 1 + i + (cells + 1) * j;
      text += fmt::format("f {} {} {} {}\n", a, a + 1, a + cells + 2, a + cells + 1);
    }
  }
  return text;
}

}  // namespace

void EventLog::Take(const v1::SceneEvent& event) {
  events.push_back(event);
  switch (event.event_case()) {
    case v1::SceneEvent::kHello:
      hello = event.hello();
      break;
    case v1::SceneEvent::kLatticeState:
      lattice = event.lattice_state();
      break;
    case v1::SceneEvent::kLatticeDelta: {
      const v1::LatticeDelta& delta = event.lattice_delta();
      EXPECT_EQ(delta.revision(), lattice.revision() + 1) << "deltas have no gap";
      lattice.set_revision(delta.revision());
      for (int i = 0; i < delta.indices_size(); ++i) {
        for (int k = 0; k < 3; ++k) {
          lattice.mutable_lattice()->set_control_points(3 * static_cast<int>(delta.indices(i)) + k,
                                                        delta.positions(3 * i + k));
        }
      }
      ++deltas;
      break;
    }
    case v1::SceneEvent::kTopology:
      topologies.push_back(event.topology());
      break;
    case v1::SceneEvent::kQuantisation:
      quantisations.push_back(event.quantisation());
      break;
    case v1::SceneEvent::kUpdateBegin:
      EXPECT_EQ(in_update_, event.update_begin().restart());
      in_update_ = true;
      staged_.clear();
      begins.push_back(event.update_begin());
      break;
    case v1::SceneEvent::kChunks:
      EXPECT_TRUE(in_update_);
      EXPECT_LT(event.ByteSizeLong(), size_t{1} << 20);
      EXPECT_EQ(event.chunks().update_id(), begins.back().update_id());
      EXPECT_EQ(event.chunks().topology_id(), topologies.back().topology_id());
      EXPECT_EQ(event.chunks().quantisation_id(), quantisations.back().quantisation_id());
      for (const v1::Chunk& chunk : event.chunks().chunks()) {
        EXPECT_LE(chunk.revision(), begins.back().revision());
        EXPECT_TRUE(staged_.emplace(chunk.index(), chunk.data()).second);
      }
      break;
    case v1::SceneEvent::kUpdateEnd:
      EXPECT_TRUE(in_update_);
      in_update_ = false;
      EXPECT_EQ(event.update_end().revision(), begins.back().revision());
      EXPECT_EQ(staged_.size(), begins.back().chunk_count());
      for (auto& [index, data] : staged_) chunks[index] = std::move(data);
      EXPECT_GE(event.update_end().revision(), ends.empty() ? 0 : ends.back().revision());
      ends.push_back(event.update_end());
      break;
    case v1::SceneEvent::kEditResult:
      results.push_back(event.edit_result());
      break;
    case v1::SceneEvent::kPresence:
      EXPECT_TRUE(lattice.has_lattice()) << "presence comes after lattice_state";
      presences.push_back(event.presence());
      break;
    case v1::SceneEvent::kHeartbeat:
      ++heartbeats;
      break;
    case v1::SceneEvent::kGoaway:
      goaways.push_back(event.goaway());
      break;
    default:
      ADD_FAILURE() << "unexpected " << event.ShortDebugString();
  }
}

void StreamTest::StartServer(absl::Duration heartbeat) {
  Options options;
  options.backend = "cpu";
  options.threads = 2;
  options.log_level = "off";
  options.heartbeat_interval = heartbeat;
  options.drain_delay = absl::Milliseconds(100);
  server_.reset();
  auto server = InProcessServer::Start(options);
  ASSERT_OK(server);
  server_ = *std::move(server);
  meshes_ = v1::MeshService::NewStub(server_->channel());
  scenes_ = v1::SceneService::NewStub(server_->channel());
}

void StreamTest::CreateScene(int cells) {
  const std::string obj = WavyGridObj(cells);
  v1::Mesh mesh;
  {
    grpc::ClientContext context;
    const auto writer = meshes_->UploadMesh(&context, &mesh);
    v1::UploadMeshRequest request;
    request.mutable_header()->set_name("grid");
    request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
    request.mutable_header()->set_total_bytes(obj.size());
    writer->Write(request);
    request.set_data(obj);
    writer->Write(request);
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    ASSERT_TRUE(status.ok()) << status.error_message();
  }
  mesh_id_ = mesh.id();
  v1::CreateSceneRequest request;
  request.set_scene_id(kScene);
  request.set_mesh(mesh.id());
  v1::LatticeFit& fit = *request.add_lattices()->mutable_fit();
  for (v1::LatticeAxes* axes : {fit.mutable_size(), fit.mutable_degree()}) {
    const int value = axes == fit.mutable_size() ? 5 : 2;
    axes->set_u(value);
    axes->set_v(value);
    axes->set_w(value);
  }
  request.mutable_default_view()->set_segments(4);
  request.mutable_default_view()->set_encoding(v1::ENCODING_QUANTISED);
  grpc::ClientContext context;
  v1::Scene scene;
  const grpc::Status status = scenes_->CreateScene(&context, request, &scene);
  ASSERT_TRUE(status.ok()) << status.error_message();
  structure_id_ = scene.structure_id();
}

v1::WatchRequest StreamTest::Watch(const std::string& editor) const {
  v1::WatchRequest request;
  request.set_scene(kScene);
  request.set_editor_id(editor);
  request.set_max_unacked_updates(0);
  return request;
}

v1::EditBatch StreamTest::Move(uint64_t sequence, uint32_t index, double dz,
                               const std::string& editor) const {
  v1::EditBatch batch;
  batch.set_scene(kScene);
  batch.set_editor_id(editor);
  batch.set_sequence(sequence);
  batch.set_structure_id(structure_id_);
  v1::MoveControlPoints& move = *batch.add_edits()->mutable_move_control_points();
  move.add_indices(index);
  move.mutable_offset()->set_z(dz);
  return batch;
}

grpc::Status StreamTest::Apply(const v1::EditBatch& batch, v1::EditResult* result) {
  grpc::ClientContext context;
  v1::EditResult ignored;
  return scenes_->ApplyEdits(&context, batch, result != nullptr ? result : &ignored);
}

grpc::Status StreamTest::Update(const v1::GetUpdateRequest& request, EventLog& log) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kStreamDeadline);
  const auto reader = scenes_->GetUpdate(&context, request);
  v1::SceneEvent event;
  while (reader->Read(&event)) log.Take(event);
  return reader->Finish();
}

v1::ServerInfo StreamTest::Info() {
  grpc::ClientContext context;
  v1::ServerInfo info;
  EXPECT_TRUE(
      v1::ServerService::NewStub(server_->channel())->GetServerInfo(&context, {}, &info).ok());
  return info;
}

DeformClient::DeformClient(v1::SceneService::Stub& stub) {
  context_.set_deadline(std::chrono::system_clock::now() + kStreamDeadline);
  stream_ = stub.Deform(&context_);
}

DeformClient::~DeformClient() {
  context_.TryCancel();
  (void)Finish();
}

void DeformClient::Open(const v1::WatchRequest& request) {
  v1::DeformRequest message;
  *message.mutable_watch() = request;
  ASSERT_TRUE(Send(message));
}

bool DeformClient::Send(const v1::EditBatch& batch) {
  v1::DeformRequest message;
  *message.mutable_edit() = batch;
  return Send(message);
}

bool DeformClient::Ack(uint64_t update_id) {
  v1::DeformRequest message;
  message.mutable_control()->set_acked_update_id(update_id);
  return Send(message);
}

bool DeformClient::Read() {
  v1::SceneEvent event;
  if (status_.has_value() || !stream_->Read(&event)) return false;
  log.Take(event);
  return true;
}

void DeformClient::ReadUntil(const std::function<bool()>& done) {
  while (!done()) {
    ASSERT_TRUE(Read()) << "the stream ended: " << Finish().error_message();
  }
}

void DeformClient::ReadUntilRevision(uint64_t revision) {
  ReadUntil([&] { return !log.ends.empty() && log.ends.back().revision() >= revision; });
}

grpc::Status DeformClient::Finish() {
  if (!status_.has_value()) {
    while (Read()) continue;
    status_ = stream_->Finish();
  }
  return *status_;
}

}  // namespace latticed::testing
