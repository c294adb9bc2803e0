// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Less detail while edits come, through the stub and in real time.
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using LevelOfDetailStreamTest = SceneStreamTest;

// A limit of a view. While edits come it allows 6 points per patch, which are 2 segments.
struct Limit {
  const char* name;
  void (*set)(uint64_t patches, v1::ViewOptions& view);
};
constexpr Limit kLimits[] = {
    {"MaxPoints", [](uint64_t patches, auto& view) { view.set_max_points(patches * 6); }},
    {"MaxBytesPerSecond",
     [](uint64_t patches, auto& view) { view.set_max_bytes_per_second(25 * patches * 8 * 6); }},
};

class LimitedStreamTest : public SceneStreamTest, public ::testing::WithParamInterface<Limit> {
 protected:
  // Drags until an update comes with less detail.
  void DragUntilReduced(DeformClient& client) {
    patches_ = Get().patches();
    v1::WatchRequest watch = Watch();
    GetParam().set(patches_, *watch.mutable_view());
    client.Open(watch);
    client.ReadUntilRevision(0);
    EXPECT_TRUE(client.log.ends.back().full_detail());
    EXPECT_EQ(client.log.topologies.back().segments(), 4);
    while (client.log.ends.back().full_detail()) {
      ASSERT_LT(sequence_, 1'000u) << "detail never falls";
      ++sequence_;
      ASSERT_TRUE(client.Send(Move(sequence_, 62, sequence_ % 2 == 0 ? 0.01 : -0.01)));
      client.ReadUntilRevision(sequence_);
    }
  }
  uint64_t patches_ = 0;
  uint64_t sequence_ = 0;
};
INSTANTIATE_TEST_SUITE_P(Limits, LimitedStreamTest, ::testing::ValuesIn(kLimits),
                         [](const auto& limit) { return std::string(limit.param.name); });

TEST_P(LimitedStreamTest, FullDetailComesByItselfWhenEditsPause) {
  DeformClient client(*scenes_);
  DragUntilReduced(client);
  const v1::Topology& reduced = client.log.topologies.back();
  EXPECT_EQ(reduced.segments(), 2);
  EXPECT_EQ(reduced.patch_count(), patches_);
  EXPECT_EQ(reduced.point_count(), 6 * patches_);
  EXPECT_EQ(client.log.begins.back().view().segments(), 2);

  client.ReadUntil([&] { return client.log.ends.back().full_detail(); });

  EXPECT_EQ(client.log.ends.back().revision(), sequence_);
  EXPECT_EQ(client.log.ends.back().head_revision(), sequence_);
  EXPECT_EQ(client.log.topologies.back().segments(), 4);
  EXPECT_EQ(client.log.topologies.back().point_count(), 15 * patches_);
  EventLog fresh;
  ASSERT_OK(Update(For<v1::GetUpdateRequest>(), fresh));
  EXPECT_EQ(client.log.chunks, fresh.chunks);
}

TEST_P(LimitedStreamTest, AHalfClosedStreamEndsInFullDetail) {
  DeformClient client(*scenes_);
  DragUntilReduced(client);
  ++sequence_;
  ASSERT_TRUE(client.Send(Move(sequence_, 62, 0.01)));

  client.HalfClose();

  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(client.log.ends.back().revision(), sequence_);
  EXPECT_TRUE(client.log.ends.back().full_detail());
}

TEST_P(LimitedStreamTest, GetUpdateIsAlwaysInFullDetail) {
  DeformClient client(*scenes_);
  DragUntilReduced(client);
  auto request = For<v1::GetUpdateRequest>();
  GetParam().set(patches_, *request.mutable_view());

  EventLog log;
  ASSERT_OK(Apply(Move(1, 62, 0.01, "bob")));
  ASSERT_OK(Update(request, log));

  EXPECT_EQ(log.topologies.at(0).segments(), 4);
  EXPECT_TRUE(log.ends.at(0).full_detail());
}

TEST_F(LevelOfDetailStreamTest, BitsOfAGestureAreAnnounced) {
  v1::WatchRequest watch = Watch();
  v1::ViewOptions& view = *watch.mutable_view();
  view.set_position_bits(14);
  view.set_normal_bits(10);
  view.set_drag_position_bits(11);
  view.set_drag_normal_bits(8);
  DeformClient client(*scenes_, watch);
  const auto expect_bits = [&](int position_bits, int normal_bits, size_t bytes_per_point) {
    SCOPED_TRACE(client.log.ends.size());
    const v1::ViewOptions& in_force = client.log.begins.back().view();
    EXPECT_EQ(client.log.quantisations.back().bits(), position_bits);
    EXPECT_EQ(in_force.position_bits(), position_bits);
    EXPECT_EQ(in_force.normal_bits(), normal_bits);
    EXPECT_EQ(in_force.drag_position_bits(), 11);
    EXPECT_EQ(in_force.drag_normal_bits(), 8);
    size_t bytes = 0;
    for (const auto& [index, data] : client.log.chunks) bytes += data.size();
    EXPECT_EQ(bytes, bytes_per_point * client.log.topologies.back().point_count());
    EXPECT_EQ(client.log.ends.back().full_detail(), position_bits == 14);
  };
  client.ReadUntilRevision(0);
  expect_bits(14, 10, 10);
  auto request = For<v1::GetUpdateRequest>();
  *request.mutable_view() = view;
  v1::EditBatch batch = Move(0, 62, 0.1);
  for (const auto end : {v1::GESTURE_PHASE_COMMIT, v1::GESTURE_PHASE_CANCEL}) {
    batch.set_gesture_id(v1::GesturePhase_Name(end));
    for (const auto phase : {v1::GESTURE_PHASE_UPDATE, end}) {
      batch.set_sequence(batch.sequence() + 1);
      batch.set_gesture_phase(phase);
      if (phase == v1::GESTURE_PHASE_CANCEL) batch.clear_edits();
      ASSERT_TRUE(client.Send(batch));
      client.ReadUntilRevision(batch.sequence());
      if (phase == end) {
        expect_bits(14, 10, 10);
      } else {
        expect_bits(11, 8, 8);
      }
    }
    EventLog fresh;
    ASSERT_OK(Update(request, fresh));
    EXPECT_EQ(client.log.chunks, fresh.chunks);
  }
}

}  // namespace
}  // namespace latticed::testing
