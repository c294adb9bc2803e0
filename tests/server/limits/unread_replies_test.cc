// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Clients send large requests and read no byte of the small replies. The server frees the requests,
// although the calls never end.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/limits.h"
#include "tests/server/support/server_test.h"
#include "tests/server/support/unfinished_calls.h"

namespace latticed::testing {
namespace {

// The bytes that this process has allocated and not freed.
size_t AllocatedBytes() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

class UnreadRepliesTest : public SceneFixture {
 protected:
  static constexpr int kSize = 32, kPoints = kSize * kSize * kSize;

  void SetUp() override {
    StartServer({.memory_bytes = uint64_t{1} << 30});
    v1::CreateSceneRequest request = SceneRequest();
    SetAxes(*request.add_lattices()->mutable_fit()->mutable_size(), kSize, kSize, kSize);
    ASSERT_OK(Create(request));
    ASSERT_OK(Create(SceneRequest("scene-two")));
  }

  // Makes 100 calls on each connection, one after the other. Their replies begin and are never read.
  void ExpectNothingKept(const std::string& rpc, const std::string& request, size_t connections) {
    constexpr size_t kCalls = 100;
    size_t before = 0;
    for (size_t c = 0; c < connections; ++c) {
      open_.push_back(std::make_unique<UnfinishedCalls>(
          server_->address(), "/latticed.v1.SceneService/" + rpc, request));
      UnfinishedCalls& connection = *open_.back();
      for (size_t n = 1; n <= kCalls; ++n) {
        connection.Begin();
        ASSERT_TRUE(connection.Run([&] { return connection.answered() == n; }));
        if (before == 0) before = AllocatedBytes();  // the first call's allocations serve all
      }
      EXPECT_EQ(connection.sent(), kCalls);
    }
    const size_t all = connections * kCalls * request.size();

    const size_t after = AllocatedBytes();

    for (const auto& connection : open_) EXPECT_EQ(connection->ended(), 0u) << "their replies wait";
    EXPECT_LT(after - std::min(before, after), all / 8) << "of " << all;
  }

  // Replaces all control points by themselves: the largest edit that there is.
  std::string ReplaceAll() {
    v1::EditBatch batch = Move("alice", 1, 0, 0);
    const v1::LatticeState state = Lattice();
    *batch.mutable_edits(0)->mutable_replace_control_points()->mutable_control_points() =
        state.lattice().control_points();
    return batch.SerializeAsString();
  }

  std::vector<std::unique_ptr<UnfinishedCalls>> open_;
};

// Adds 900,000 bytes in an unknown field, which every rpc ignores.
template <typename Request>
std::string Padded(Request request) {
  constexpr int kLater = 1'000;
  request.GetReflection()->MutableUnknownFields(&request)->AddLengthDelimited(
      kLater, std::string(900'000, 'x'));
  return request.SerializeAsString();
}

TEST_F(UnreadRepliesTest, OfLargeRequestsKeepNothingOfThem) {
  const std::string request = ReplaceAll();
  ASSERT_GT(request.size(), size_t{kPoints} * 24);
  ASSERT_LT(request.size(), limits::kMaxMessageBytes);

  ExpectNothingKept("ApplyEdits", request, 3);

  EXPECT_EQ(Get().revision(), 1u) << "and others are answered";
}

TEST_F(UnreadRepliesTest, OfStreamsKeepNothingOfTheirRequests) {
  auto file = For<v1::ExportRequest>("scene-two");
  file.set_format(v1::EXPORT_FORMAT_PLY);
  file.mutable_view()->set_segments(1);
  auto watch = For<v1::WatchRequest>("scene-two");
  watch.set_max_unacked_updates(0);
  v1::DeformRequest deform;
  *deform.mutable_watch() = watch;

  for (const auto& [rpc, request] :
       {std::pair("GetUpdate", Padded(For<v1::GetUpdateRequest>("scene-two"))),
        {"Export", Padded(file)},
        {"Watch", Padded(watch)},
        {"Deform", Padded(deform)}}) {
    SCOPED_TRACE(rpc);
    ExpectNothingKept(rpc, request, 1);
  }
}

}  // namespace
}  // namespace latticed::testing
