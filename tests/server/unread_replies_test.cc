// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Clients that send large requests and take in no byte of the small replies: what they sent is given
// back, though their calls never end.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/base/limits.h"
#include "tests/server/scene_fixture.h"
#include "tests/server/unfinished_calls.h"

namespace latticed::testing {
namespace {

// What this process has allocated and not freed.
size_t AllocatedBytes() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

class UnreadRepliesTest : public SceneFixture {
 protected:
  static constexpr int kSize = 32, kPoints = kSize * kSize * kSize;

  void SetUp() override {
    StartServer({.memory_bytes = uint64_t{64} << 20});
    v1::CreateSceneRequest request = SceneRequest();
    v1::LatticeAxes& size = *request.add_lattices()->mutable_fit()->mutable_size();
    size.set_u(kSize);
    size.set_v(kSize);
    size.set_w(kSize);
    ASSERT_OK(Create(request));
  }

  // All control points as they are: as large as an edit can be.
  std::string ReplaceAll() {
    v1::EditBatch batch = Move("alice", 1, 0, 0);
    const v1::LatticeState state = Lattice();
    *batch.mutable_edits(0)->mutable_replace_control_points()->mutable_control_points() =
        state.lattice().control_points();
    return batch.SerializeAsString();
  }
};

TEST_F(UnreadRepliesTest, OfLargeRequestsKeepNothingOfThem) {
  constexpr size_t kConnections = 3, kCalls = 100;
  const std::string request = ReplaceAll();
  ASSERT_GT(request.size(), size_t{kPoints} * 24);
  ASSERT_LT(request.size(), limits::kMaxMessageBytes);
  std::vector<std::unique_ptr<UnfinishedCalls>> connections;
  size_t before = 0;
  for (size_t c = 0; c < kConnections; ++c) {
    connections.push_back(std::make_unique<UnfinishedCalls>(
        server_->address(), "/latticed.v1.SceneService/ApplyEdits", request));
    for (size_t n = 1; n <= kCalls; ++n) {
      connections[c]->Begin();
      ASSERT_TRUE(connections[c]->Run([&] { return connections[c]->answered() == n; }));
      if (before == 0) before = AllocatedBytes();  // the edit is made; the others repeat it
    }
  }

  const size_t more = AllocatedBytes() - std::min(before, AllocatedBytes());

  for (const auto& connection : connections) {
    EXPECT_EQ(connection->ended(), 0u) << "their replies wait";
    EXPECT_EQ(connection->sent(), kCalls);
  }
  EXPECT_LT(more, size_t{16} << 20) << "of " << kConnections * kCalls * request.size();
  EXPECT_EQ(Get().revision(), 1u) << "and others are answered";
}

}  // namespace
}  // namespace latticed::testing
