// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server in this process on a free port, and the calls that tests make through real stubs. These need no
// internals of the server.
#ifndef LATTICED_TESTS_SERVER_SUPPORT_SERVER_TEST_H_
#define LATTICED_TESTS_SERVER_SUPPORT_SERVER_TEST_H_

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cpp/library/status.h"
#include "core/base/error.h"
#include "core/base/vec.h"
#include "latticed/v1/mesh.grpc.pb.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "latticed/v1/server.grpc.pb.h"
#include "server/in_process.h"
#include "server/store/store.h"
#include "tests/server/support/stream_clients.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {

// Four quads on [0,2]^2 at z = 0, with UVs x/2, y/2, in two groups.
inline constexpr char kGridObj[] =
    "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0 2 0\nv 1 2 0\nv 2 2 0\n"
    "vt 0 0\nvt .5 0\nvt 1 0\nvt 0 .5\nvt .5 .5\nvt 1 .5\nvt 0 1\nvt .5 1\nvt 1 1\n"
    "g low\nf 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\ng high\nf 4/4 5/5 8/8 7/7\nf 5/5 6/6 9/9 8/8\n";
// A plane of cells x cells unit quads.
[[nodiscard]] std::string PlaneObj(int cells);
// A wavy square of cells x cells quads over [0,1] x [0,1].
[[nodiscard]] std::string WavyGridObj(int cells);
// A cube of 8 vertices and 6 quads. Each edge length gives another mesh id.
[[nodiscard]] std::string CubeObj(double edge = 1);
// `count` triangles, each in its own group, named `name` and its number.
[[nodiscard]] std::string GroupsObj(int count, const std::string& name);
[[nodiscard]] v1::MeshHeader ObjHeader(const std::string& bytes);

inline constexpr char kScene[] = "scene-one";
// A request with only its scene set.
template <class Request>
Request For(const std::string& scene = kScene) {
  Request request;
  request.set_scene(scene);
  return request;
}

// 64 MiB of memory, meshes of at most 16 MiB, no drain delay.
[[nodiscard]] Options TestOptions();

void SetAxes(v1::LatticeAxes& axes, int u, int v, int w);
[[nodiscard]] v1::Vec3 ToVec3(Vec3d v);
// Sets a frame whose edges are along the axes.
void SetFrame(v1::LatticeFrame& frame, Vec3d origin, Vec3d size);
// Adds 32 labels, the most that are allowed, of the most bytes that are allowed: 10 KB.
void AddLongLabels(google::protobuf::Map<std::string, std::string>& labels);

// A refusal, as a client sees it.
struct Refusal {
  absl::StatusCode code = absl::StatusCode::kInvalidArgument;
  std::string reason;   // of ErrorInfo
  std::string field;    // of BadRequest; empty: it has none
  std::string message;  // part of it: the allowed range, or what is wrong
};
// A failed check reports the caller's line. (clang 14 has no std::source_location.)
void ExpectRefusal(const absl::Status& status, const Refusal& refusal,
                   const char* file = __builtin_FILE(), int line = __builtin_LINE());
inline void ExpectRefused(const absl::Status& status, absl::StatusCode code,
                          const std::string& reason, const std::string& field = "",
                          const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  ExpectRefusal(status, {code, reason, field, ""}, file, line);
}
// The published reason of a failed call, such as "NOT_FOUND".
[[nodiscard]] inline std::string Reason(const absl::Status& status) {
  return error::DetailsOf(status).reason;
}

class ServerTest : public ::testing::Test {
 protected:
  using Meshes = v1::MeshService::Stub;
  using Scenes = v1::SceneService::Stub;
  using Infos = v1::ServerService::Stub;

  // Starts it on the CPU, with one thread unless the options say more, and without a log.
  void StartServer(Options options);
  // Starts it on `backend`, without a log.
  void StartServerOn(std::unique_ptr<Backend> backend, Options options = {},
                     std::shared_ptr<Store> store = nullptr);
  // From now on the stubs use this channel.
  void Reach(const std::shared_ptr<grpc::Channel>& channel);

  // A unary call. Its deadline of one minute is for servers that hang.
  template <class Stub, class Request, class Response>
  absl::Status Call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                    const std::type_identity_t<Request>& request,
                    std::type_identity_t<Response>* response = nullptr,
                    const Metadata& metadata = {}) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    for (const auto& [name, value] : metadata) context.AddMetadata(name, value);
    Response ignored;
    return client::FromGrpc((Of(static_cast<Stub*>(nullptr)).*method)(
        &context, request, response != nullptr ? response : &ignored));
  }
  // Reads a server stream to its end: all its messages, and its status.
  template <class Stub, class Request, class Message>
  absl::Status ReadAll(std::unique_ptr<grpc::ClientReader<Message>> (Stub::*method)(
                           grpc::ClientContext*, const Request&),
                       const std::type_identity_t<Request>& request,
                       std::type_identity_t<std::vector<Message>>* messages = nullptr,
                       const Metadata& metadata = {}) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    for (const auto& [name, value] : metadata) context.AddMetadata(name, value);
    const auto reader = (Of(static_cast<Stub*>(nullptr)).*method)(&context, request);
    Message message;
    while (reader->Read(&message)) {
      if (messages != nullptr) messages->push_back(message);
    }
    return client::FromGrpc(reader->Finish());
  }

  // Uploads the header, then the bytes in parts of 64 KiB.
  absl::Status Upload(const v1::MeshHeader& header, std::string_view bytes,
                      v1::Mesh* mesh = nullptr, const Metadata& metadata = {});
  // Fails the test when the upload is refused.
  v1::Mesh UploadObj(const std::string& obj);
  // The same; returns the mesh's id.
  std::string Upload(const std::string& obj) { return UploadObj(obj).id(); }
  absl::Status DeleteMesh(const std::string& mesh, bool force = false);
  int MeshCount();
  int SceneCount();
  v1::ServerInfo Info();
  v1::CreateSceneRequest SceneRequest(const std::string& id = kScene) const;
  absl::Status Create(const v1::CreateSceneRequest& request, v1::Scene* scene = nullptr) {
    return Call(&Scenes::CreateScene, request, scene);
  }
  v1::Scene Get(const std::string& scene = kScene);
  v1::LatticeState Lattice();
  double MeasuredVolume(const std::string& scene = kScene);
  absl::Status DeleteScene(const std::string& scene = kScene) {
    return Call(&Scenes::DeleteScene, For<v1::DeleteSceneRequest>(scene));
  }
  // Moves one control point by `offset`, in structure 1, which every scene has at first.
  static v1::EditBatch MoveOne(const std::string& editor, uint64_t sequence, uint32_t point,
                               Vec3d offset);
  absl::Status Apply(const v1::EditBatch& batch, v1::EditResult* result = nullptr) {
    return Call(&Scenes::ApplyEdits, batch, result);
  }
  absl::Status Update(const v1::GetUpdateRequest& request, EventLog& log);
  absl::Status Update(int segments, const std::string& scene = kScene, EventLog* log = nullptr);
  absl::StatusOr<std::string> Export(const v1::ExportRequest& request);
  // The value of a series of the server's metrics; -1 when there is no such series.
  double Metric(const std::string& series) const;

  std::string mesh_;  // that SceneRequest names
  std::unique_ptr<InProcessServer> server_;
  std::unique_ptr<Meshes> meshes_;
  std::unique_ptr<Scenes> scenes_;
  std::unique_ptr<Infos> infos_;

 private:
  void Use(absl::StatusOr<std::unique_ptr<InProcessServer>> server);
  Meshes& Of(Meshes*) { return *meshes_; }
  Scenes& Of(Scenes*) { return *scenes_; }
  Infos& Of(Infos*) { return *infos_; }
};

// A server with small limits and nothing in it.
class SmallServerTest : public ServerTest {
 protected:
  void SetUp() override { StartServer(TestOptions()); }
};

// A server with the mesh kGridObj.
class SceneFixture : public ServerTest {
 protected:
  void SetUp() override { StartServer({}); }
  void StartServer(Options options);

  // Repeats `call` while it is kResourceExhausted: a stream that has just ended may still hold memory.
  static absl::Status OnceIdle(const std::function<absl::Status()>& call);
  // Repeats DeleteMesh until no unfinished scene holds the mesh; MESH_IN_USE if one stays.
  absl::Status DeleteMeshOnceUnused();

  static v1::EditBatch Move(const std::string& editor, uint64_t sequence, uint32_t point,
                            double x) {
    return MoveOne(editor, sequence, point, {x, 0, 0});
  }
  static v1::EditBatch Knot(const std::string& editor, uint64_t sequence);
  // Of the editor's own newest step.
  v1::EditBatch UndoMine(const std::string& editor, uint64_t sequence);
  // The scene's surface as a PLY file.
  std::string Ply();
};

// The same with a scene of default options.
class OneSceneTest : public SceneFixture {
 protected:
  void SetUp() override {
    SceneFixture::SetUp();
    ASSERT_OK(Create(SceneRequest()));
  }
};

// A server for streams.
class StreamTest : public ServerTest {
 protected:
  // Long enough that silent watchers are not paused before the deadline of a stream.
  static constexpr absl::Duration kHeartbeat = absl::Seconds(60);

  void SetUp() override { StartServer(kHeartbeat); }
  void StartServer(absl::Duration heartbeat);
  // A wavy grid in a lattice of 5^3 control points, degree 2; a view of 4 segments, QUANTISED.
  void CreateScene(int cells = 8);
  v1::WatchRequest Watch(const std::string& editor = "alice") const;
  v1::EditBatch Move(uint64_t sequence, uint32_t point, double dz,
                     const std::string& editor = "alice") const;
  absl::Status Control(const WatchClient& watcher, v1::ControlWatchRequest request,
                       v1::ControlWatchResponse* response = nullptr);

  uint64_t structure_id_ = 1;
};

// The same with the scene of CreateScene.
class SceneStreamTest : public StreamTest {
 protected:
  void SetUp() override {
    StreamTest::SetUp();
    CreateScene();
  }
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SUPPORT_SERVER_TEST_H_
