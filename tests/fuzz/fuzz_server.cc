// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_server.h"

#include <grpcpp/generic/async_generic_service.h>
#include <sanitizer/lsan_interface.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "fmt/format.h"
#include "latticed/v1/mesh.grpc.pb.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "server/backends.h"
#include "server/base/telemetry.h"
#include "server/stores/scene_registry.h"
#include "server/stores/upload_store.h"

namespace latticed::fuzz {
namespace {

constexpr char kScene[] = "scene-one";
constexpr char kHonestScene[] = "honest-scene-of-another-client";
constexpr int kMostInputs = 20'000;       // of one server
constexpr size_t kMostUploads = 16;       // left by inputs; the server takes limits::kMaxUploads
constexpr uint64_t kMostBytes = 8 << 20;  // reserved by what cannot be deleted
constexpr absl::Duration kPatience = absl::Seconds(10);

// A cube of six quads.
std::string CubeObj(double edge) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    text += fmt::format("v {} {} {}\n", (i & 1) * edge, ((i >> 1) & 1) * edge, (i >> 2) * edge);
  }
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

Options SmallOptions() {
  Options options;
  options.backend = "cpu";
  options.threads = 1;
  options.listen = "127.0.0.1:0";
  options.http = "127.0.0.1:0";  // where server/web believes to listen
  options.memory_bytes = uint64_t{64} << 20;
  options.transport_memory_bytes = uint64_t{64} << 20;
  options.max_mesh_bytes = uint64_t{1} << 20;
  options.max_scenes = 8;
  options.max_watchers = 8;
  options.cors_origins = {"https://pages.example"};
  options.web_root = "/dev/null";
  options.first_message_timeout = absl::Milliseconds(50);
  options.http_timeouts.linger = std::chrono::milliseconds(20);
  options.drain_delay = absl::ZeroDuration();
  options.log_level = "off";
  return options;
}

void Require(const grpc::Status& status, const char* what) {
  if (!status.ok()) {
    Fail(fmt::format("{}: code {}, {}", what, static_cast<int>(status.error_code()),
                     status.error_message()));
  }
}

// Tells who holds a scene that was deleted, and whether it is only slow.
void FailAbout(const std::weak_ptr<Scene>& deleted) {
  const auto scene = deleted.lock();
  if (scene == nullptr) return;  // it has gone just now
  std::string words =
      fmt::format("a deleted scene stays: {} owners, {} watchers, revision {}",
                  scene.use_count() - 1, scene->watcher_count(), scene->State()->revision);
  for (const auto& [purpose, bytes] : scene->memory()) {
    words += fmt::format(", {} of {}", bytes, purpose);
  }
  absl::SleepFor(kPatience);
  Fail(fmt::format("{}; {} owners later", words, scene.use_count() - 1));
}

}  // namespace

void Fail(const std::string& words) {
  std::fprintf(stderr, "FAILED: %s\n", words.c_str());
  std::abort();
}

void SetOptions(int* argc, char*** argv) {
  static char no_leaks[] = "-detect_leaks=0", no_entropy[] = "-entropic=0";
  static std::vector<char*> arguments(*argv, *argv + *argc);
  arguments.insert(arguments.begin() + 1, {no_leaks, no_entropy});
  *argc = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  *argv = arguments.data();
}

FuzzServer& FuzzServer::Get() {
  static FuzzServer server;
  return server;
}

// gRPC's callback threads end with the last object that uses them. Between two servers that may be a call that ends on
// one of these threads, and gRPC frees twice what such a thread still uses. A server that stays keeps the threads.
FuzzServer::FuzzServer() {
  static auto* const service = new grpc::CallbackGenericService;
  static auto* const stays =
      grpc::ServerBuilder().RegisterCallbackGenericService(service).BuildAndStart().release();
  if (stays == nullptr) Fail("gRPC makes no server");
  Start();
}

FuzzServer::~FuzzServer() { Stop(); }

void FuzzServer::Start() {
  Options options = SmallOptions();
  ConfigureLogging(options.log_level, options.log_format);
  auto backends = MakeBackends(options);
  if (!backends.ok()) Fail(backends.status().ToString());
  env_ = std::make_unique<ServerEnv>(std::move(options), *std::move(backends), Authenticator());
  auto server = GrpcServer::Start(env_.get());
  if (!server.ok()) Fail(server.status().ToString());
  server_ = *std::move(server);
  channel_ = server_->InProcessChannel();
  inputs_ = 0;
  honest_mesh_ = Upload(CubeObj(2));
  mesh_ = Upload(CubeObj(1));
  CreateScene(kHonestScene, honest_mesh_);
}

void FuzzServer::Stop() {
  if (server_ == nullptr) return;
  channel_.reset();
  scene_.reset();
  env_->drain.request_stop();
  server_->Shutdown(absl::Now());
  server_.reset();
  for (const auto& scene : env_->scenes->All()) (void)env_->scenes->Delete(scene->id());
  for (const auto& mesh : env_->meshes.All()) (void)env_->meshes.Remove(mesh->id);
  const bool all_gone = env_->uploads->size() == 0;
  const auto memory = env_->memory, requests = env_->requests, replies = env_->replies;
  env_.reset();
  if (all_gone && memory->used_bytes() != memory->kept_bytes()) {
    Fail(fmt::format("{} bytes are still reserved after the end", memory->used_bytes()));
  }
  if (requests->used_bytes() != 0 || replies->used_bytes() != 0) {
    Fail("requests or replies are still reserved after the end");
  }
  if (__lsan_do_recoverable_leak_check() != 0) Fail("memory has leaked");
}

bool FuzzServer::SceneIsFresh() const {
  return scene_ != nullptr && scene_->ended().ok() && scene_->State()->revision == 0 &&
         scene_->last_use() == scene_used_;
}

void FuzzServer::Begin() {
  if (++inputs_ > kMostInputs || env_->uploads->size() > kMostUploads ||
      env_->memory->used_bytes() > kMostBytes) {
    Stop();
    Start();
  }
  if (!env_->meshes.Find(mesh_).ok()) mesh_ = Upload(CubeObj(1));
  if (scene_ != nullptr) return;
  CreateScene(kScene, mesh_);
  scene_ = *env_->scenes->Find(kScene);
  scene_used_ = scene_->last_use();
}

void FuzzServer::End() {
  CheckHonest();
  if (!SceneIsFresh()) scene_ = nullptr;
  std::vector<std::weak_ptr<Scene>> deleted;
  for (const auto& scene : env_->scenes->All()) {
    if (scene->id() == kHonestScene || scene == scene_) continue;
    deleted.push_back(scene);
    (void)env_->scenes->Delete(scene->id());
  }
  for (const auto& mesh : env_->meshes.All()) {
    if (mesh->id == mesh_ || mesh->id == honest_mesh_) continue;
    (void)env_->scenes->DeleteMesh(mesh->id, true, [&] { return env_->meshes.Remove(mesh->id); });
  }
  const absl::Time latest = absl::Now() + kPatience;
  for (const auto& scene : deleted) {
    while (!scene.expired()) {
      if (absl::Now() > latest) FailAbout(scene);
      absl::SleepFor(absl::Microseconds(50));
    }
  }
}

void FuzzServer::CheckHonest() {
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + kPatience));
  v1::GetSceneRequest request;
  request.set_scene(kHonestScene);
  v1::Scene scene;
  Require(v1::SceneService::NewStub(channel_)->GetScene(&context, request, &scene),
          "the honest client's GetScene");
  if (scene.mesh() != honest_mesh_ || scene.revision() != 0) {
    Fail("the honest client's scene is another: " + scene.ShortDebugString());
  }
}

void FuzzServer::CreateScene(const std::string& id, const std::string& mesh) {
  grpc::ClientContext context;
  v1::CreateSceneRequest request;
  request.set_scene_id(id);
  request.set_mesh(mesh);
  request.mutable_default_view()->set_segments(2);  // evaluation takes most of the time of an input
  v1::LatticeAxes& size = *request.add_lattices()->mutable_fit()->mutable_size();
  size.set_u(3);
  size.set_v(3);
  size.set_w(3);
  v1::Scene scene;
  Require(v1::SceneService::NewStub(channel_)->CreateScene(&context, request, &scene),
          "CreateScene");
}

std::string FuzzServer::Upload(const std::string& obj) {
  grpc::ClientContext context;
  v1::Mesh mesh;
  const auto writer = v1::MeshService::NewStub(channel_)->UploadMesh(&context, &mesh);
  v1::UploadMeshRequest request;
  request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
  request.mutable_header()->set_total_bytes(obj.size());
  writer->Write(request);
  request.set_data(obj);
  writer->Write(request);
  writer->WritesDone();
  Require(writer->Finish(), "UploadMesh");
  return mesh.id();
}

}  // namespace latticed::fuzz
