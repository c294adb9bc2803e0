// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server with one uploaded mesh, reached through real stubs: what tests of SceneService share.
#ifndef LATTICED_TESTS_SERVER_SCENE_FIXTURE_H_
#define LATTICED_TESTS_SERVER_SCENE_FIXTURE_H_

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <grpcpp/grpcpp.h>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cpp/library/status.h"
#include "core/base/error.h"
#include "fmt/format.h"
#include "latticed/v1/mesh.grpc.pb.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "latticed/v1/server.grpc.pb.h"
#include "server/in_process.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {

// Four quads on [0,2]^2 at z = 0, with UVs x/2, y/2, in two groups.
inline constexpr char kGridObj[] =
    "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0 2 0\nv 1 2 0\nv 2 2 0\n"
    "vt 0 0\nvt .5 0\nvt 1 0\nvt 0 .5\nvt .5 .5\nvt 1 .5\nvt 0 1\nvt .5 1\nvt 1 1\n"
    "g low\nf 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\ng high\nf 4/4 5/5 8/8 7/7\nf 5/5 6/6 9/9 8/8\n";

// A plane of cells x cells quads.
inline std::string PlaneObj(int cells) {
  std::string obj;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) obj += fmt::format("v {} {} 0\n", i, j);
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int v = 1 + i + (cells + 1) * j;
      obj += fmt::format("f {} {} {} {}\n", v, v + 1, v + cells + 2, v + cells + 1);
    }
  }
  return obj;
}

class SceneFixture : public ::testing::Test {
 protected:
  void SetUp() override { StartServer({}); }

  void StartServer(Options options) {
    options.backend = "cpu";
    options.threads = 1;
    options.log_level = "off";
    ASSERT_NO_FATAL_FAILURE(Use(InProcessServer::Start(std::move(options))));
    mesh_ = Upload(kGridObj);
  }

  // On a backend of the test's own; without a mesh.
  void StartServerOn(std::unique_ptr<Backend> backend, Options options = {}) {
    std::vector<std::unique_ptr<Backend>> backends;
    backends.push_back(std::move(backend));
    options.log_level = "off";
    Use(InProcessServer::Start(std::move(options), std::move(backends)));
  }

  std::string Upload(const std::string& obj) {
    grpc::ClientContext context;
    v1::Mesh mesh;
    auto writer = v1::MeshService::NewStub(server_->channel())->UploadMesh(&context, &mesh);
    v1::UploadMeshRequest request;
    request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
    request.mutable_header()->set_total_bytes(obj.size());
    writer->Write(request);
    request.set_data(obj);
    writer->Write(request);
    writer->WritesDone();
    EXPECT_OK(client::FromGrpc(writer->Finish()));
    return mesh.id();
  }

  // What has just ended may hold its scene, and its memory, for a moment: tries until there is room.
  template <typename Call>
  static absl::Status OnceIdle(Call call) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (true) {
      const absl::Status status = call();
      if (!absl::IsResourceExhausted(status) || std::chrono::steady_clock::now() > give_up) {
        return status;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  // Waits for scenes in the making, which hold the mesh; MESH_IN_USE if one stays.
  absl::Status DeleteMeshOnceUnused() {
    const auto give_up = std::chrono::system_clock::now() + std::chrono::seconds(20);
    grpc::Status status;
    do {
      grpc::ClientContext context;
      v1::DeleteMeshRequest request;
      request.set_mesh(mesh_);
      v1::DeleteMeshResponse response;
      status =
          v1::MeshService::NewStub(server_->channel())->DeleteMesh(&context, request, &response);
    } while (!status.ok() && std::chrono::system_clock::now() < give_up);
    return client::FromGrpc(status);
  }

  // A unary call: status, with the response in `response`. Its deadline is for servers that hang.
  template <typename Request, typename Response>
  absl::Status Call(grpc::Status (v1::SceneService::Stub::*method)(grpc::ClientContext*,
                                                                   const Request&, Response*),
                    const Request& request, Response* response,
                    const std::string& scene_metadata = "") {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    if (!scene_metadata.empty()) context.AddMetadata("latticed-scene", scene_metadata);
    return client::FromGrpc(((*stub_).*method)(&context, request, response));
  }

  v1::Scene Get(const std::string& scene = "scene-one") {
    v1::GetSceneRequest get;
    get.set_scene(scene);
    v1::Scene result;
    EXPECT_OK(Call(&v1::SceneService::Stub::GetScene, get, &result));
    return result;
  }

  v1::ServerInfo Info() {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    v1::ServerInfo info;
    EXPECT_OK(client::FromGrpc(
        v1::ServerService::NewStub(server_->channel())->GetServerInfo(&context, {}, &info)));
    return info;
  }

  // A server stream: all its messages, and its status.
  template <typename Message>
  static absl::Status ReadAll(grpc::ClientReader<Message>& reader, std::vector<Message>& messages) {
    Message message;
    while (reader.Read(&message)) messages.push_back(message);
    return client::FromGrpc(reader.Finish());
  }

  v1::CreateSceneRequest SceneRequest(const std::string& id = "scene-one") const {
    v1::CreateSceneRequest request;
    request.set_scene_id(id);
    request.set_mesh(mesh_);
    return request;
  }
  absl::Status Create(const v1::CreateSceneRequest& request, v1::Scene* scene = nullptr) {
    v1::Scene ignored;
    return Call(&v1::SceneService::Stub::CreateScene, request, scene ? scene : &ignored);
  }
  static v1::EditBatch Move(const std::string& editor, uint64_t sequence, uint32_t point,
                            double x) {
    v1::EditBatch batch;
    batch.set_scene("scene-one");
    batch.set_editor_id(editor);
    batch.set_sequence(sequence);
    batch.set_structure_id(1);
    auto* move = batch.add_edits()->mutable_move_control_points();
    move->add_indices(point);
    move->mutable_offset()->set_x(x);
    return batch;
  }
  static v1::EditBatch Knot(const std::string& editor, uint64_t sequence) {
    v1::EditBatch batch = Move(editor, sequence, 0, 0);
    batch.mutable_edits(0)->mutable_insert_knot()->set_value(0.5);
    return batch;
  }
  absl::Status Apply(const v1::EditBatch& batch, v1::EditResult* result = nullptr) {
    v1::EditResult ignored;
    return Call(&v1::SceneService::Stub::ApplyEdits, batch, result ? result : &ignored);
  }

  v1::LatticeState Lattice() {
    v1::GetLatticeRequest request;
    request.set_scene("scene-one");
    v1::LatticeState state;
    EXPECT_OK(Call(&v1::SceneService::Stub::GetLattice, request, &state));
    return state;
  }

  static void ExpectRefused(const absl::Status& status, absl::StatusCode code,
                            const std::string& reason, const std::string& field = "") {
    EXPECT_THAT(status, StatusIs(code));
    EXPECT_EQ(error::DetailsOf(status).reason, reason) << status;
    EXPECT_EQ(error::DetailsOf(status).field, field) << status;
  }

  std::unique_ptr<InProcessServer> server_;
  std::unique_ptr<v1::SceneService::Stub> stub_;
  std::string mesh_;

 private:
  void Use(absl::StatusOr<std::unique_ptr<InProcessServer>> server) {
    ASSERT_OK(server);
    server_ = *std::move(server);
    stub_ = v1::SceneService::NewStub(server_->channel());
  }
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SCENE_FIXTURE_H_
