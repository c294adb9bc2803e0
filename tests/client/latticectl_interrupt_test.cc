// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticectl, interrupted by SIGINT or SIGTERM, deletes what it has made on a server, and its exit code
// names the signal. The fake server sends the signal from inside the call to be interrupted.
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <regex>
#include <set>
#include <sstream>

#include "absl/time/clock.h"
#include "client/cpp/latticectl/command_line/interruption.h"
#include "core/base/mutex.h"
#include "core/base/sha256.h"
#include "latticed/v1/mesh.grpc.pb.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "tests/client/fake_server.h"
#include "tests/client/latticectl_server_fixture.h"

namespace latticed::client {
namespace {

using ::testing::HasSubstr;

constexpr int kInterrupted = 128;
constexpr char kTriangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

// Restores the default actions: a program that a shell starts in the background may ignore SIGINT.
void TakeSignals() {
  for (const int number : {SIGINT, SIGTERM}) signal(number, SIG_DFL);
}

// A server that stores ids of meshes and scenes, and sends `signal` during the call `interrupted_rpc`.
class FakeServices final : public v1::MeshService::Service, public v1::SceneService::Service {
 public:
  std::string interrupted_rpc;
  int signal = 0;
  std::set<std::string> meshes, scenes, ever;

  grpc::Status GetMesh(grpc::ServerContext*, const v1::GetMeshRequest* request,
                       v1::Mesh* mesh) override {
    const MutexLock lock(&mutex_);
    Fill(request->mesh(), mesh);
    return StatusOf(meshes.contains(request->mesh()));
  }
  grpc::Status UploadMesh(grpc::ServerContext* context,
                          grpc::ServerReader<v1::UploadMeshRequest>* parts,
                          v1::Mesh* mesh) override {
    v1::UploadMeshRequest part;
    parts->Read(&part);
    const std::string id = part.header().sha256();
    if (Interrupt("begin of UploadMesh")) return UntilCancelled(*context);
    while (parts->Read(&part)) {
    }
    (void)Interrupt("end of UploadMesh");
    Add(id, &meshes);
    Fill(id, mesh);
    return grpc::Status::OK;
  }
  grpc::Status DeleteMesh(grpc::ServerContext*, const v1::DeleteMeshRequest* request,
                          v1::DeleteMeshResponse*) override {
    const MutexLock lock(&mutex_);
    return StatusOf(meshes.erase(request->mesh()) > 0);
  }
  grpc::Status CreateScene(grpc::ServerContext*, const v1::CreateSceneRequest* request,
                           v1::Scene* scene) override {
    (void)Interrupt("CreateScene");
    Add(request->scene_id(), &scenes);
    scene->set_id(request->scene_id());
    return grpc::Status::OK;
  }
  // Never ends by itself: only a cancellation ends the call.
  grpc::Status GetUpdate(grpc::ServerContext* context, const v1::GetUpdateRequest*,
                         grpc::ServerWriter<v1::SceneEvent>*) override {
    (void)Interrupt("GetUpdate");
    return UntilCancelled(*context);
  }
  grpc::Status DeleteScene(grpc::ServerContext*, const v1::DeleteSceneRequest* request,
                           v1::DeleteSceneResponse*) override {
    const MutexLock lock(&mutex_);
    return StatusOf(scenes.erase(request->scene()) > 0);
  }

 private:
  // Sends the signal if `rpc` is the call to be interrupted. Returns whether it is.
  bool Interrupt(const std::string& rpc) const {
    if (rpc != interrupted_rpc) return false;
    kill(getpid(), signal);
    return true;
  }
  void Add(const std::string& id, std::set<std::string>* ids) {
    const MutexLock lock(&mutex_);
    ids->insert(id);
    ever.insert(id);
  }
  static void Fill(const std::string& id, v1::Mesh* mesh) {
    mesh->set_id(id);
    mesh->set_format(v1::MESH_FORMAT_OBJ);
  }
  static grpc::Status StatusOf(bool found) {
    return found ? grpc::Status::OK : grpc::Status(grpc::StatusCode::NOT_FOUND, "it is not here");
  }
  static grpc::Status UntilCancelled(const grpc::ServerContext& context) {
    while (!context.IsCancelled()) absl::SleepFor(absl::Milliseconds(1));
    return grpc::Status::CANCELLED;
  }

  Mutex mutex_;
};

class LatticectlInterrupt : public LatticectlTest {
 protected:
  void SetUp() override {
    LatticectlTest::SetUp();
    TakeSignals();
    // 32 MiB, in many parts: more than a connection buffers while the server does not read.
    ASSERT_OK(WriteFile(Path("mesh.obj"), kTriangle + std::string(size_t{32} << 20, '#')));
    ASSERT_OK(WriteFile(Path("small.obj"), kTriangle));
    MustRun({"lattice", Path("small.obj"), "-o", Path("L.json")});
  }

  RunResult Apply(const std::string& mesh) const {
    return Latticectl({"apply", Path(mesh), "--lattice", Path("L.json"), "-o", Path("o.ply"),
                       "--server", server_.address()});
  }

  FakeServices things_;
  FakeServer server_{static_cast<v1::MeshService::Service*>(&things_),
                     static_cast<v1::SceneService::Service*>(&things_)};
};

TEST_F(LatticectlInterrupt, ApplyDeletesItsSceneAndItsMeshWhereverItIs) {
  for (const int signal : {SIGINT, SIGTERM}) {
    for (const char* rpc :
         {"begin of UploadMesh", "end of UploadMesh", "CreateScene", "GetUpdate"}) {
      SCOPED_TRACE(std::string(rpc) + ", signal " + std::to_string(signal));
      things_.signal = signal;
      things_.interrupted_rpc = rpc;

      const RunResult result = Apply("mesh.obj");

      EXPECT_EQ(result.code, kInterrupted + signal);
      EXPECT_EQ(result.err, "latticectl: interrupted\n");
      EXPECT_EQ(result.out, "");
      EXPECT_FALSE(std::filesystem::exists(Path("o.ply")));
      EXPECT_TRUE(things_.scenes.empty());
      EXPECT_TRUE(things_.meshes.empty());
    }
  }
  EXPECT_GE(things_.ever.size(), 5u);  // the mesh, and a scene for each run that created one
}

TEST_F(LatticectlInterrupt, ApplyLeavesAMeshThatWasThere) {
  const std::string id = Sha256Hex(kTriangle);
  things_.meshes.insert(id);
  things_.signal = SIGINT;
  things_.interrupted_rpc = "GetUpdate";
  EXPECT_EQ(Apply("small.obj").code, kInterrupted + SIGINT);
  EXPECT_TRUE(things_.scenes.empty());
  EXPECT_EQ(things_.meshes, std::set<std::string>{id});
}

// A terminal's error output. Sends `signal` once, when the progress bars match the expression `text`.
class InterruptingOutput final : public std::stringbuf {
 public:
  InterruptingOutput(const std::string& text, int signal) : text_(text), signal_(signal) {}

 protected:
  int sync() override {
    if (signal_ != 0 && std::regex_search(str(), text_)) {
      kill(getpid(), std::exchange(signal_, 0));
    }
    return 0;
  }

 private:
  const std::regex text_;
  int signal_;
};

class LatticectlInterruptDrag : public LatticectlServer {
 protected:
  // The result leaves out the error output, which holds progress bars.
  RunResult RunUntil(const std::string& text, int signal,
                     std::vector<std::string> arguments) const {
    TakeSignals();
    std::ostringstream out;
    InterruptingOutput buffer(text, signal);
    std::ostream err(&buffer);
    const int code =
        RunAt({.out = out, .err = err, .err_is_terminal = true}, AtServer(std::move(arguments)));
    return {.code = code, .out = out.str(), .err = ""};
  }
};

// These drags are too long to end by themselves.
TEST_F(LatticectlInterruptDrag, BenchSaysWhatItHasMeasuredAndDeletesItsSceneAndItsMesh) {
  // The bar changes with each percent, 50 edits: some are measured when it shows the first percent.
  const RunResult result =
      RunUntil("[1-9][0-9]* of 5,000", SIGTERM,
               {"bench", Path("vase.obj"), "--segments", "1", "--rate", "100", "--edits", "5000"});
  EXPECT_EQ(result.code, kInterrupted + SIGTERM);
  EXPECT_THAT(result.out, HasSubstr("editors: edit to update end"));
  EXPECT_THAT(result.out, HasSubstr("verified"));
  EXPECT_EQ(RunJson({"scene", "list"}).size(), 0u);
  EXPECT_EQ(RunJson({"meshes"}).size(), 0u);
}

TEST_F(LatticectlInterruptDrag, TortureComparesWhatWasAcknowledgedAndDeletesItsScenesAndItsMesh) {
  const RunResult result =
      RunUntil("torture: [1-9][0-9]* edits acknowledged, longest pause ", SIGINT,
               {"torture", Path("vase.obj"), "--scenes", "2", "--rate", "50", "--seconds", "300"});
  EXPECT_EQ(result.code, kInterrupted + SIGINT);
  EXPECT_THAT(result.out, HasSubstr("lattices compared"));
  EXPECT_EQ(RunJson({"scene", "list"}).size(), 0u);
  EXPECT_EQ(RunJson({"meshes"}).size(), 0u);
}

TEST_F(LatticectlInterruptDrag, QuickstartDeletesItsSceneAndItsMesh) {
  EXPECT_EQ(RunUntil("drag", SIGINT,
                     {"quickstart", "--sample", "vase", "--steps", "100000", "--output", Path("q")})
                .code,
            kInterrupted + SIGINT);
  EXPECT_EQ(RunJson({"scene", "list"}).size(), 0u);
  EXPECT_EQ(RunJson({"meshes"}).size(), 0u);
}

TEST(Interruption, TheSecondSignalEndsTheProcess) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  TakeSignals();
  EXPECT_EXIT(
      {
        Interruption interruption;
        const std::stop_token stop = interruption.Catch();
        raise(SIGTERM);
        if (interruption.signal() == SIGTERM) raise(SIGINT);
      },
      ::testing::KilledBySignal(SIGINT), "");
}

TEST(Interruption, AnIgnoredSignalStaysIgnored) {
  signal(SIGINT, SIG_IGN);
  {
    Interruption interruption;
    const std::stop_token stop = interruption.Catch();
    raise(SIGINT);
    EXPECT_EQ(interruption.signal(), 0);
    EXPECT_FALSE(stop.stop_requested());
  }
  signal(SIGINT, SIG_DFL);
}

}  // namespace
}  // namespace latticed::client
