// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Kills a daemon at random instants while scenes are edited. After each start, every scene has all edits that were
// acknowledged, and at most the one more that was under way; that one, sent again, counts once.
// LATTICED_KILLS sets the number of kills: 20, and 200 in a whole run.
#include <signal.h>

#include <atomic>
#include <cstdlib>
#include <random>
#include <thread>

#include "fmt/format.h"
#include "tests/server/daemon/daemon_process.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

constexpr int kScenes = 6;

int Kills() {
  const char* kills = std::getenv("LATTICED_KILLS");
  return kills == nullptr ? 20 : std::atoi(kills);
}

// The one editor of a scene, and what he knows of it. Edit n puts control point n modulo 64 to (n, 0, 0): the lattice
// after n edits follows from n.
class Editor {
 public:
  explicit Editor(int number) : scene_(fmt::format("scene-number-{}", number)) {}

  const std::string& scene() const { return scene_; }
  uint64_t acknowledged() const { return acknowledged_; }

  // Sends edits until one is not acknowledged.
  void EditUntilTheServerDies(v1::SceneService::Stub& scenes) {
    while (Send(scenes, acknowledged_ + 1)) {
    }
  }
  bool Send(v1::SceneService::Stub& scenes, uint64_t sequence) {
    v1::EditBatch batch;
    batch.set_scene(scene_);
    batch.set_editor_id("ann");
    batch.set_sequence(sequence);
    batch.set_structure_id(1);
    auto& set = *batch.add_edits()->mutable_set_control_points();
    set.add_indices(static_cast<uint32_t>(sequence % 64));
    for (const double x : {static_cast<double>(sequence), 0.0, 0.0}) set.add_positions(x);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
    v1::EditResult result;
    if (!scenes.ApplyEdits(&context, batch, &result).ok()) return false;
    EXPECT_EQ(result.revision(), sequence);
    acknowledged_ = sequence;
    return true;
  }

  // Compares the scene with all that was acknowledged.
  void Check(v1::SceneService::Stub& scenes, const v1::Lattice& initial) {
    grpc::ClientContext context;
    v1::GetLatticeRequest request;
    request.set_scene(scene_);
    v1::LatticeState state;
    ASSERT_OK(client::FromGrpc(scenes.GetLattice(&context, request, &state)));
    EXPECT_GE(state.revision(), acknowledged_) << scene_ << " lost acknowledged edits";
    EXPECT_LE(state.revision(), acknowledged_ + 1) << scene_ << " has edits that were not sent";
    v1::Lattice expected = initial;
    const uint64_t revision = state.revision();
    for (uint64_t n = revision > 64 ? revision - 63 : 1; n <= revision; ++n) {
      double* xyz = expected.mutable_control_points()->mutable_data() + 3 * (n % 64);
      xyz[0] = static_cast<double>(n);
      xyz[1] = xyz[2] = 0;
    }
    EXPECT_EQ(state.lattice().SerializeAsString(), expected.SerializeAsString()) << scene_;
    // What was under way counts once, whether it was stored or not.
    ASSERT_TRUE(Send(scenes, acknowledged_ + 1));
  }

 private:
  const std::string scene_;
  uint64_t acknowledged_ = 0;
};

class KillTest : public ServerTest {
 protected:
  std::vector<std::string> Arguments() const {
    return {"--listen",  "127.0.0.1:0", "--backend",  "cpu",
            "--threads", "1",           "--data-dir", folder_.Path("data")};
  }
  void Connect(Daemon& daemon) {
    const std::string address = daemon.Address();
    ASSERT_FALSE(address.empty());
    Reach(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  }

  TemporaryFolder folder_;
};

TEST_F(KillTest, NoAcknowledgedEditIsLostOrDoubled) {
  const auto seed = std::random_device{}();
  SCOPED_TRACE(fmt::format("seed {}", seed));
  std::mt19937 random(seed);
  std::vector<Editor> editors;
  for (int n = 0; n < kScenes; ++n) editors.emplace_back(n);
  v1::Lattice initial;
  {
    Daemon daemon(Arguments());
    Connect(daemon);
    mesh_ = Upload(kGridObj);
    for (const Editor& editor : editors) {
      v1::CreateSceneRequest request = SceneRequest(editor.scene());
      request.clear_lattices();
      SetAxes(*request.add_lattices()->mutable_fit()->mutable_size(), 4, 4, 4);
      ASSERT_OK(Create(request));
    }
    v1::LatticeState state;
    ASSERT_OK(Call(&Scenes::GetLattice, For<v1::GetLatticeRequest>(editors[0].scene()), &state));
    initial = state.lattice();
    daemon.Signal(SIGKILL);
    daemon.Wait();
  }
  for (int kill = 0; kill < Kills() && !HasFailure(); ++kill) {
    SCOPED_TRACE(fmt::format("kill {}", kill));
    Daemon daemon(Arguments());
    Connect(daemon);
    for (Editor& editor : editors) editor.Check(*scenes_, initial);
    std::vector<std::thread> threads;
    for (Editor& editor : editors) {
      threads.emplace_back([&] { editor.EditUntilTheServerDies(*scenes_); });
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 200'000));
    daemon.Signal(SIGKILL);
    daemon.Wait();
    for (std::thread& thread : threads) thread.join();
  }
  uint64_t edits = 0;
  for (const Editor& editor : editors) edits += editor.acknowledged();
  EXPECT_GT(edits, static_cast<uint64_t>(Kills()) * kScenes);
  RecordProperty("acknowledged edits", fmt::to_string(edits));
  printf("%d kills, %lu acknowledged edits\n", Kills(), static_cast<unsigned long>(edits));
}

}  // namespace
}  // namespace latticed::testing
