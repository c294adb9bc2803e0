// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Random sessions of several editors, with their records, and the comparison of two histories bit by bit.
#ifndef LATTICED_TESTS_CORE_FFD_HISTORY_EDIT_SESSIONS_H_
#define LATTICED_TESTS_CORE_FFD_HISTORY_EDIT_SESSIONS_H_

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/ffd/history/edit_history_image.h"
#include "tests/core/ffd/history/edit_history_fixture.h"

namespace latticed {

inline bool SamePoints(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  return std::ranges::equal(a, b, SameBits);
}

inline void ExpectSame(const Lattice& a, const Lattice& b) {
  EXPECT_EQ(a.structure, b.structure);
  EXPECT_TRUE(SamePoints(a.control_points, b.control_points));
}

inline void ExpectSame(const EditSummary& a, const EditSummary& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.structure_id, b.structure_id);
  EXPECT_EQ(a.boxes_touched, b.boxes_touched);
  EXPECT_EQ(a.patches_touched, b.patches_touched);
  EXPECT_EQ(a.largest_move, b.largest_move);
  EXPECT_EQ(a.drag_residual, b.drag_residual);
}

inline void ExpectSame(const EditStep& a, const EditStep& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.structure_step, b.structure_step);
  EXPECT_EQ(a.written_at, b.written_at);
  EXPECT_EQ(a.editor_id, b.editor_id);
  EXPECT_EQ(a.gesture_id, b.gesture_id);
  EXPECT_EQ(a.open, b.open);
  EXPECT_EQ(a.timed_out, b.timed_out);
  EXPECT_EQ(a.last_heard, b.last_heard);
  EXPECT_EQ(a.indices, b.indices);
  EXPECT_TRUE(SamePoints(a.positions, b.positions));
  EXPECT_TRUE(std::ranges::equal(a.start, b.start, [](const auto& p, const auto& q) {
    return p.first == q.first && SameBits(p.second, q.second);
  }));
  EXPECT_EQ(a.constraints, b.constraints);
  EXPECT_EQ(a.strength, b.strength);
  EXPECT_EQ(a.removes, b.removes);
  ASSERT_EQ(a.weights.has_value(), b.weights.has_value());
  EXPECT_TRUE(SameWeights(a.weights.value_or(nullptr), b.weights.value_or(nullptr)));
  ASSERT_EQ(a.structural.has_value(), b.structural.has_value());
  if (!a.structural.has_value()) return;
  EXPECT_EQ(a.structural->structure, b.structural->structure);
  EXPECT_EQ(a.structural->replaces(), b.structural->replaces());
}

inline void ExpectSame(const EditHistory& a, const EditHistory& b) {
  const EditHistoryImage p = a.image(), q = b.image();
  EXPECT_EQ(p.revision, q.revision);
  EXPECT_EQ(p.structure_id, q.structure_id);
  EXPECT_EQ(p.clock, q.clock);
  EXPECT_EQ(p.records, q.records);
  EXPECT_EQ(p.base.structure_step, q.base.structure_step);
  EXPECT_EQ(p.base.constraints, q.base.constraints);
  EXPECT_EQ(p.base.strength, q.base.strength);
  EXPECT_EQ(p.base.absent, q.base.absent);
  EXPECT_EQ(a.absent(), b.absent());
  EXPECT_EQ(a.strength(), b.strength());
  EXPECT_TRUE(SameWeights(a.weights(), b.weights()));
  EXPECT_EQ(a.constraints(), b.constraints());
  ExpectSame(p.base.base, q.base.base);
  ExpectSame(p.base.initial, q.base.initial);
  ExpectSame(a.lattice(), b.lattice());
  ASSERT_EQ(p.steps.size(), q.steps.size());
  for (size_t n = 0; n < p.steps.size(); ++n) ExpectSame(p.steps[n], q.steps[n]);
  ASSERT_EQ(p.undone.size(), q.undone.size());
  for (size_t n = 0; n < p.undone.size(); ++n) {
    ExpectSame(p.undone[n].step, q.undone[n].step);
    EXPECT_EQ(p.undone[n].undone_by, q.undone[n].undone_by);
    EXPECT_EQ(p.undone[n].undone_at, q.undone[n].undone_at);
  }
  ASSERT_EQ(p.results.size(), q.results.size());
  for (size_t n = 0; n < p.results.size(); ++n) {
    EXPECT_EQ(p.results[n].editor_id, q.results[n].editor_id);
    ExpectSame(p.results[n].summary, q.results[n].summary);
  }
}

// Edits as several editors might send them, a part of them impossible.
class RandomBatches {
 public:
  explicit RandomBatches(uint32_t seed) : random_(seed) {}

  EditBatch Next(const EditHistory& history) {
    EditBatch batch{.editor_id = std::string(1, static_cast<char>('a' + Below(4)))};
    batch.sequence = ++sequences_[batch.editor_id];
    batch.structure_id = history.structure_id() - (Below(20) == 0 ? 1 : 0);
    if (Below(10) == 0) batch.expected_revision = history.revision();
    const auto count = static_cast<uint32_t>(history.lattice().control_points.size());
    if (Below(8) == 0) {
      batch.edits = {Structural(history.lattice())};
      return batch;
    }
    if (Below(40) == 0) {
      batch.edits = {RemoveLattice{}};
      return batch;
    }
    if (Below(20) == 0) {
      batch.edits = {SetWeights{{Below(8)}, {static_cast<float>(Below(11)) / 10}}};
      return batch;
    }
    if (Below(10) == 0) {
      batch.edits = {SetConstraints{SomeConstraints(count)}};
      return batch;
    }
    if (Below(4) == 0) {
      batch.edits = {Below(2) == 0 ? Edit{Redo{}}
                                   : Undo{Below(3) == 0 ? UndoScope::kScene : UndoScope::kMine}};
      return batch;
    }
    if (Below(2) == 0) {
      batch.gesture_id = "g" + std::to_string(Below(2));
      batch.gesture_phase = static_cast<GesturePhase>(Below(3));
      if (batch.gesture_phase == GesturePhase::kCancel) return batch;
    }
    for (uint32_t n = 1 + Below(3); n > 0; --n) batch.edits.push_back(Write(count));
    return batch;
  }
  uint32_t Below(uint32_t end) { return static_cast<uint32_t>(random_() % end); }

 private:
  double Unit() { return std::uniform_real_distribution<double>(-0.3, 0.3)(random_); }
  Vec3d Point() { return {Unit(), Unit(), Unit()}; }

  Edit Write(uint32_t count) {
    const uint32_t index = Below(count + count / 20);  // sometimes out of range
    switch (Below(7)) {
      case 0:
        return SetControlPoints{{index}, {Point()}};
      case 1:
        return TransformControlPoints{
            {index}, {1 + Unit(), 0.1, 0, 0, 0, 1, Unit(), 0, Unit(), 0, 1, 0, 0.1, 0.2, 0.3, 1}};
      case 2:
        return DragPoints{{{0.3 + Unit(), 0.5, 0.5}}, {{0.5 + Unit(), 0.6, 0.5}}};
      case 3:
        return Reset{Below(2) == 0 ? ResetTo::kIdentity : ResetTo::kInitial};
      case 4:
        return SetStrength{0.9 + Unit()};  // sometimes out of range
      default:
        return MoveControlPoints{{index}, Point()};
    }
  }
  Constraints SomeConstraints(uint32_t count) {
    Constraints constraints;
    if (Below(2) == 0) constraints.held = {Below(count + count / 20)};  // sometimes out of range
    if (Below(2) == 0) {
      constraints.held_layers = {{static_cast<int>(Below(3)), Below(2) == 0, 1}};
    }
    if (Below(2) == 0) constraints.mirror = static_cast<int>(Below(3));
    if (Below(2) == 0) constraints.volume = KeptVolume{.axis = 2, .volume = 1 + Unit()};
    return constraints;
  }
  Edit Structural(const Lattice& lattice) {
    if (Below(2) == 0) return InsertKnot{static_cast<int>(Below(3)), 0.5 + Unit()};
    const int size = 4 + static_cast<int>(Below(3));
    Lattice other = *FitLattice(UnitBounds(), {size, 4, 4}, {2, 2, 2}, 0);
    other.structure.frame = lattice.structure.frame;
    const bool keeps = Below(2) == 0;
    if (keeps) other.control_points.clear();
    return ReplaceLattice{std::move(other), keeps};
  }

  std::mt19937 random_;
  std::map<std::string, uint64_t> sequences_;
};

// Sixty seconds and more may pass between two batches, so that gestures time out.
inline EditHistory::TimePoint Later(EditHistory::TimePoint now, RandomBatches& batches) {
  return now + std::chrono::seconds(batches.Below(30) == 0 ? 61 : 1);
}

// Moves a free point as though that restored the volume, or none where point 5 is low.
class ScriptedKeeper final : public VolumeKeeper {
 public:
  absl::Status CheckEncloses(const std::vector<Vec3d>&, double) const override {
    return absl::OkStatus();
  }
  absl::Status Keep(const KeptVolume& kept, const PointFreedom* freedom,
                    const std::vector<bool>& named, double,
                    std::vector<Vec3d>& points) const override {
    if (points[5].z < 0) return absl::FailedPreconditionError("not kept");
    for (size_t i = 0; i < points.size(); ++i) {
      if (named[i] || (freedom != nullptr && freedom->is_held(i))) continue;
      points[i].z += 0.01 * *kept.volume;
      break;
    }
    return absl::OkStatus();
  }
};

// What a scene without memory for history does.
inline void ForgetSome(EditHistory& history, RandomBatches& batches, EditRecord& record) {
  if (batches.Below(20) != 0) return;
  for (uint32_t n = batches.Below(4); n > 0 && history.ForgetOldestStep(); --n) {
    ++record.steps_forgotten;
  }
  for (uint32_t n = batches.Below(3); n > 0 && history.ForgetOldestEditor(); --n) {
    ++record.editors_forgotten;
  }
}

// A session of random batches; `each` gets the history and the record of each batch that left one.
template <typename Each>
void RunSession(uint32_t seed, int batches, Each each) {
  RandomBatches random(seed);
  const ScriptedKeeper keeper;
  EditHistory history(UnitLattice());
  ASSERT_OK(history.MadeWith(nullptr, 8));
  EditHistory::TimePoint now;
  for (int n = 0; n < batches; ++n) {
    now = Later(now, random);
    const EditBatch batch = random.Next(history);
    const uint64_t before = history.records();
    const auto admit = [&](const auto&) {
      return random.Below(5) == 0 ? absl::ResourceExhaustedError("no memory") : absl::OkStatus();
    };
    (void)history.Apply(batch, now, admit, {}, &keeper, admit);
    if (history.records() == before) continue;
    history.SetTouched(batch.editor_id, static_cast<uint64_t>(n), 7);
    EditRecord record = history.LastRecord(batch, now);
    ForgetSome(history, random, record);
    each(history, record);
  }
}

}  // namespace latticed

#endif  // LATTICED_TESTS_CORE_FFD_HISTORY_EDIT_SESSIONS_H_
