// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An editor of the client library drags while the daemon is killed or told to stop, and started again at the same address
// on the same folder. His stream goes on by itself: each edit counts once, and he can undo edits from before.
#include <arpa/inet.h>
#include <signal.h>
#include <sys/socket.h>

#include <cstdlib>
#include <memory>
#include <random>
#include <thread>

#include "absl/time/clock.h"
#include "client/cpp/library/latticed_client.h"
#include "fmt/format.h"
#include "tests/server/daemon/daemon_process.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

constexpr char kScene[] = "scene-of-the-drag";
constexpr uint64_t kEdits = 200, kInFlight = 24, kKilledAt = 100, kUndone = 140;
constexpr uint64_t kPoints = 64;  // 4 x 4 x 4
constexpr absl::Duration kDown = absl::Milliseconds(500);
// From the start of the new daemon's process: it is ready, the editor finds it, and the scene wakes. Less than two seconds,
// unless the machine stalls.
constexpr absl::Duration kMostPause = absl::Seconds(15);

constexpr char kBoxObj[] =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

// A free port that the system gives to nobody, so that a restarted daemon can use it again.
std::string FreeAddress() {
  std::mt19937 random(std::random_device{}());
  for (;;) {
    const int port = 20'000 + static_cast<int>(random() % 10'000);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int socket_of_port = socket(AF_INET, SOCK_STREAM, 0);
    const int bound =
        bind(socket_of_port, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
    close(socket_of_port);
    if (bound == 0) return fmt::format("127.0.0.1:{}", port);
  }
}

// Edit n puts control point n modulo 64 to (n, 0, 0).
v1::EditBatch Edit(uint64_t n) {
  v1::EditBatch batch;
  auto& set = *batch.add_edits()->mutable_set_control_points();
  set.add_indices(static_cast<uint32_t>(n % kPoints));
  for (const double x : {static_cast<double>(n), 0.0, 0.0}) set.add_positions(x);
  return batch;
}

v1::EditBatch Undo() {
  v1::EditBatch batch;
  batch.add_edits()->mutable_undo();
  return batch;
}

// The lattice after the first `edits` edits.
v1::Lattice LatticeAfter(uint64_t edits, v1::Lattice lattice) {
  for (uint64_t n = 1; n <= edits; ++n) {
    double* xyz = lattice.mutable_control_points()->mutable_data() + 3 * (n % kPoints);
    xyz[0] = static_cast<double>(n);
    xyz[1] = xyz[2] = 0;
  }
  return lattice;
}

class ResumeTest : public ::testing::TestWithParam<int> {
 protected:
  std::unique_ptr<Daemon> StartDaemon() {
    return std::make_unique<Daemon>(
        std::vector<std::string>{"--listen", address_, "--backend", "cpu", "--threads", "1",
                                 "--drain-delay", "0s", "--data-dir", folder_.Path("data")});
  }
  void CreateScene(client::Client& client) {
    v1::MeshHeader header;
    header.set_format(v1::MESH_FORMAT_OBJ);
    const auto mesh = client.UploadMesh(kBoxObj, header);
    ASSERT_OK(mesh);
    v1::CreateSceneRequest request;
    request.set_scene_id(kScene);
    request.set_mesh(mesh->id());
    auto& size = *request.add_lattices()->mutable_fit()->mutable_size();
    size.set_u(4);
    size.set_v(4);
    size.set_w(4);
    ASSERT_OK(client.CreateScene(request));
  }
  // Starts another daemon after a pause.
  void Restart(std::unique_ptr<Daemon>& daemon) {
    daemon->Wait();
    absl::SleepFor(kDown);
    restarted_ = absl::Now();
    daemon = StartDaemon();
  }
  // Compares the scene with the state after `edits` edits, at a revision.
  static void Check(client::Client& client, uint64_t revision, uint64_t edits,
                    const v1::Lattice& initial) {
    const auto state = client.GetLattice(kScene);
    ASSERT_OK(state);
    EXPECT_EQ(state->revision(), revision);
    EXPECT_EQ(state->lattice().SerializeAsString(),
              LatticeAfter(edits, initial).SerializeAsString());
  }

  TemporaryFolder folder_;
  const std::string address_ = FreeAddress();
  absl::Time restarted_;
};

TEST_P(ResumeTest, ADragGoesOnAndCanBeUndone) {
  auto daemon = StartDaemon();
  ASSERT_EQ(daemon->Address(), address_);
  std::vector<absl::StatusCode> told;
  const auto client = client::Client::Connect(
      {.address = address_, .observer = [&](const absl::Status& s) { told.push_back(s.code()); }});
  ASSERT_NO_FATAL_FAILURE(CreateScene(*client));
  const auto initial = client->GetLattice(kScene);
  ASSERT_OK(initial);
  v1::WatchRequest watch;
  watch.set_scene(kScene);
  auto stream = client->Deform(watch);
  ASSERT_OK(stream);

  std::thread restarter;
  absl::Time first_after;
  for (uint64_t n = 1; n <= kEdits; ++n) {
    const auto sequence = (*stream)->Send(Edit(n));
    ASSERT_OK(sequence);
    ASSERT_EQ(*sequence, n);
    if (n == kKilledAt) {
      daemon->Signal(GetParam());
      restarter = std::thread([&] { Restart(daemon); });
    }
    if (n > kInFlight) {
      ASSERT_OK((*stream)->WaitFor(n - kInFlight));
    }
    if ((*stream)->reconnections() > 0 && first_after == absl::Time()) first_after = absl::Now();
  }
  ASSERT_OK((*stream)->WaitFor(kEdits));
  restarter.join();
  const absl::Duration pause = first_after - restarted_;
  printf("the editor went on %.0f ms after the restart\n", absl::ToDoubleMilliseconds(pause));
  EXPECT_GT(pause, absl::ZeroDuration());
  EXPECT_LT(pause, kMostPause);
  EXPECT_GE((*stream)->reconnections(), 1);
  if (GetParam() == SIGKILL) {  // else the client waits as the goaway says
    EXPECT_THAT(told,
                ::testing::ElementsAre(absl::StatusCode::kUnavailable, absl::StatusCode::kOk));
  }
  ASSERT_NO_FATAL_FAILURE(Check(*client, kEdits, kEdits, initial->lattice()));

  for (uint64_t n = 1; n <= kUndone; ++n) ASSERT_OK((*stream)->Send(Undo()));
  ASSERT_OK((*stream)->WaitFor(kEdits + kUndone));
  static_assert(kEdits - kUndone < kKilledAt - kInFlight, "some are from before the signal");
  Check(*client, kEdits + kUndone, kEdits - kUndone, initial->lattice());
  (*stream)->Cancel();
  stream->reset();
  daemon->Signal(SIGKILL);
  daemon->Wait();
}

INSTANTIATE_TEST_SUITE_P(Signals, ResumeTest, ::testing::Values(SIGKILL, SIGTERM),
                         [](const auto& info) { return info.param == SIGKILL ? "Kill" : "Drain"; });

}  // namespace
}  // namespace latticed::testing
