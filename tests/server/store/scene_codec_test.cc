// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Records and images survive as bytes, with all their bits. Damaged bytes are refused or describe another history; they
// crash nothing.
#include "server/store/records/scene_codec.h"

#include <random>
#include <string>
#include <variant>
#include <vector>

#include "gmock/gmock.h"
#include "tests/core/ffd/history/edit_sessions.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;

SceneRecord ToScene(const EditRecord& record) {
  SceneRecord scene{.edit = record, .commit_time = absl::FromUnixNanos(1'700'000'000'123'456'789)};
  if (record.batch.sequence % 3 == 0) scene.box = {record.batch.sequence, {1.5, -2, 1e-300}, 0.125};
  return scene;
}

TEST(SceneCodec, ALogOfBytesLeadsToTheSameHistory) {
  for (uint32_t seed = 101; seed <= 110; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    EditHistory copy(UnitLattice());
    ASSERT_OK(copy.MadeWith(nullptr, 8));
    RunSession(seed, 250, [&](const EditHistory& history, const EditRecord& record) {
      const SceneRecord before = ToScene(record);
      const std::string bytes = EncodeRecord(before);
      ASSERT_OK_AND_ASSIGN(const SceneRecord after, DecodeRecord(bytes));
      EXPECT_EQ(EncodeRecord(after), bytes);
      EXPECT_EQ(after.commit_time, before.commit_time);
      ASSERT_EQ(after.box.has_value(), before.box.has_value());
      if (after.box.has_value()) {
        EXPECT_EQ(after.box->id, before.box->id);
        EXPECT_TRUE(SameBits(after.box->origin, before.box->origin));
        EXPECT_EQ(after.box->range, 0.125);
      }
      ASSERT_OK(copy.ApplyRecord(after.edit));
      if (copy.records() % 20 == 0) ExpectSame(copy, history);
    });
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(SceneCodec, AHistoryGoesOnFromItsImageInBytes) {
  EditHistory copy(UnitLattice());
  ASSERT_OK(copy.MadeWith(nullptr, 8));
  RunSession(7, 400, [&](const EditHistory& history, const EditRecord& record) {
    ASSERT_OK(copy.ApplyRecord(record));
    if (copy.records() % 40 != 0) return;
    const std::string bytes = EncodeImage({.histories = {copy.image()}, .now = record.now});
    ASSERT_OK_AND_ASSIGN(SceneImage image, DecodeImage(bytes));
    EXPECT_EQ(image.now, record.now);
    EXPECT_EQ(EncodeImage(image), bytes);
    ASSERT_OK_AND_ASSIGN(copy, EditHistory::FromImage(std::move(image.histories[0])));
    ASSERT_OK(copy.MadeWith(nullptr, 8));
    ExpectSame(copy, history);
  });
}

TEST(SceneCodec, ARecordOfTenPointsTakesItsPointsAndAHundredBytes) {
  EditHistory history(UnitLattice());
  EditBatch batch{.editor_id = "0123456789abcdef",
                  .sequence = 1000,
                  .structure_id = 1,
                  .gesture_id = "0123456789abcdef"};
  MoveControlPoints move{{}, {0.1, 0.2, 0.3}};
  for (uint32_t n = 0; n < 10; ++n) move.indices.push_back(n);
  batch.edits = {move};
  ASSERT_OK(history.Apply(batch, {}, [](const auto&) { return absl::OkStatus(); }));
  const std::string bytes = EncodeRecord(ToScene(history.LastRecord(batch, {})));
  EXPECT_GT(bytes.size(), 240u);
  EXPECT_LT(bytes.size(), 360u);
}

// set_weights, the points that restore a volume, and a strength: no batch has all three, and the last would be ignored.
TEST(SceneCodec, ABatchOfThreeEditsIsRefused) {
  SceneRecord record;
  record.edit.batch = {.editor_id = "ann", .sequence = 1, .structure_id = 1};
  record.edit.batch.edits = {SetWeights{{}, {0.5f, 1}}, SetControlPoints{{3}, {{1, 2, 3}}}};
  ASSERT_OK_AND_ASSIGN(const SceneRecord two, DecodeRecord(EncodeRecord(record)));
  ASSERT_EQ(two.edit.batch.edits.size(), 2u);
  EXPECT_EQ(std::get<SetWeights>(two.edit.batch.edits[0]).values, (std::vector<float>{0.5f, 1}));
  EXPECT_EQ(std::get<SetControlPoints>(two.edit.batch.edits[1]).indices, std::vector<uint32_t>{3});

  record.edit.batch.edits.push_back(SetStrength{0.5});
  const auto three = DecodeRecord(EncodeRecord(record));
  EXPECT_THAT(three.status(), StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(std::string(three.status().message()), ::testing::HasSubstr("three edits"));
}

TEST(SceneCodec, DamagedBytesCrashNothing) {
  std::string image;
  std::vector<std::string> records;
  RunSession(3, 60, [&](const EditHistory& history, const EditRecord& record) {
    records.push_back(EncodeRecord(ToScene(record)));
    image = EncodeImage({.histories = {history.image()}});
  });
  std::mt19937 random(5);
  int refused = 0;
  for (int n = 0; n < 20'000; ++n) {
    const bool is_image = n % 2 == 0;
    std::string bytes = is_image ? image : records[random() % records.size()];
    if (n % 5 == 0) bytes.resize(random() % bytes.size());
    for (uint32_t flips = 1 + random() % 3; flips > 0 && !bytes.empty(); --flips) {
      bytes[random() % bytes.size()] ^= static_cast<char>(1 << random() % 8);
    }
    if (is_image) {
      auto decoded = DecodeImage(bytes);
      auto history = decoded.ok() ? EditHistory::FromImage(std::move(decoded->histories[0]))
                                  : absl::StatusOr<EditHistory>(decoded.status());
      if (!history.ok()) {
        EXPECT_THAT(history.status(), StatusIs(absl::StatusCode::kDataLoss));
        ++refused;
        continue;
      }
      while (history->ForgetOldestStep()) {
      }
      continue;
    }
    const auto decoded = DecodeRecord(bytes);
    EditHistory history(UnitLattice());
    if (!decoded.ok() || !history.ApplyRecord(decoded->edit).ok()) ++refused;
  }
  EXPECT_GT(refused, 5'000);
}

}  // namespace
}  // namespace latticed
