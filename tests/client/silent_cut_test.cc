// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Streams over a line that carries nothing more without a word, and over a slow one. The server is a process of its own: the
// threads of one in this process would handle the events of the client's sockets too.
#include <chrono>
#include <iostream>
#include <memory>
#include <string>
#include <thread>

#include "absl/time/clock.h"
#include "client/cpp/library/latticed_client.h"
#include "fmt/format.h"
#include "tests/client/relay.h"
#include "tests/server/daemon/daemon_process.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

constexpr double kSlow = 200e3;  // bytes a second
constexpr int kQuads = 24;       // along each side of the sheet: updates take four seconds
// From the cut to the edit's update. Expected are 1.6 to 1.9 s on a quiet machine; a patient client would take 40.
constexpr absl::Duration kLongestPause = absl::Seconds(30);

std::string Sheet() {
  std::string obj;
  for (int y = 0; y <= kQuads; ++y) {
    for (int x = 0; x <= kQuads; ++x) obj += fmt::format("v {} {} {}\n", x, y, (x * y) % 7);
  }
  for (int y = 0; y < kQuads; ++y) {
    for (int x = 1; x <= kQuads; ++x) {
      const int corner = y * (kQuads + 1) + x;
      obj += fmt::format("f {} {} {} {}\n", corner, corner + 1, corner + kQuads + 2,
                         corner + kQuads + 1);
    }
  }
  return obj;
}

class SilentCutTest : public ::testing::Test {
 protected:
  ~SilentCutTest() override {
    server_.Signal(SIGKILL);
    server_.Wait();
  }

  // A stream with large updates, of a new scene.
  std::unique_ptr<DeformStream> Open(const Relay& relay) {
    client_ = Client::Connect({.address = relay.address()});
    v1::MeshHeader header;
    header.set_format(v1::MESH_FORMAT_OBJ);
    const auto mesh = client_->UploadMesh(Sheet(), header);
    EXPECT_OK(mesh);
    v1::CreateSceneRequest create;
    create.set_mesh(mesh.value_or(v1::Mesh()).id());
    const auto scene = client_->CreateScene(create);
    EXPECT_OK(scene);
    v1::WatchRequest watch;
    watch.set_scene(scene.value_or(v1::Scene()).id());
    watch.mutable_view()->set_encoding(v1::ENCODING_RAW);
    watch.mutable_view()->set_segments(4);
    auto stream = client_->Deform(watch);
    EXPECT_OK(stream);
    return stream.ok() ? *std::move(stream) : nullptr;
  }
  // Moves all control points, and waits for the update.
  static void MoveAll(DeformStream& stream) {
    v1::EditBatch batch;
    auto& move = *batch.add_edits()->mutable_move_control_points();
    for (uint32_t point = 0; point < 64; ++point) move.add_indices(point);
    move.mutable_offset()->set_z(0.25);
    const auto sequence = stream.Send(batch);
    ASSERT_OK(sequence);
    EXPECT_OK(stream.WaitFor(*sequence));
  }

  ::latticed::testing::Daemon server_{{"--listen=127.0.0.1:0", "--backend=cpu"}};
  const std::string address_ = server_.Address();
  std::unique_ptr<Client> client_;
};

TEST_F(SilentCutTest, AnEditorGoesOnByAnotherConnection) {
  Relay relay(address_);
  const auto stream = Open(relay);
  ASSERT_NE(stream, nullptr);

  relay.Silence();
  const absl::Time cut = absl::Now();
  MoveAll(*stream);

  const absl::Duration pause = absl::Now() - cut;
  std::cout << "the editor went on after " << pause << "\n";
  EXPECT_LT(pause, kLongestPause);
  EXPECT_EQ(stream->reconnections(), 1);
  EXPECT_EQ(stream->surface().lattice().revision(), 1u);
}

TEST_F(SilentCutTest, ASlowLineThatIsBusyWithALargeUpdateIsNotTakenForOne) {
  const Relay relay(address_, kSlow);
  const auto stream = Open(relay);
  ASSERT_NE(stream, nullptr);
  for (int i = 0; i < 2; ++i) MoveAll(*stream);

  EXPECT_EQ(stream->reconnections(), 0);
}

TEST_F(SilentCutTest, AStreamThatNobodyReadsIsNotTakenForOne) {
  const Relay relay(address_);
  const auto stream = Open(relay);
  ASSERT_NE(stream, nullptr);

  // 14 heartbeats come through: longer than a silence.
  const uint64_t before = relay.answers();
  while (relay.answers() < before + 14) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  MoveAll(*stream);

  EXPECT_EQ(stream->reconnections(), 0);
}

}  // namespace
}  // namespace latticed::client
