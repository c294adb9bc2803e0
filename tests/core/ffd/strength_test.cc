// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The strength of a scene: the lattice that it leads to, drags under it, and its steps in the history.
#include <cmath>
#include <random>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/edit/direct_manipulation.h"
#include "core/ffd/outside/outside_map.h"
#include "core/ffd/outside/outside_rules.h"
#include "tests/core/ffd/history/edit_history_fixture.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using Code = absl::StatusCode;

constexpr uint32_t kStrengthSeed = 47;

// A lattice over the unit cube, moved at random; a falloff of 0.3 goes on at all sides where `falls_off`.
Lattice RandomLattice(std::array<int, 3> degree, bool falls_off, std::mt19937& random) {
  std::uniform_real_distribution<double> move(-0.2, 0.2);
  Lattice lattice = *FitLattice(UnitBounds(), {5, 4, 6}, degree, 0);
  if (falls_off) {
    lattice.structure.outside.mode = OutsideMode::kFalloff;
    lattice.structure.outside.widths.fill(0.3);
    lattice.structure.outside = ResolvedOutside(lattice.structure, {});
  }
  for (Vec3d& p : lattice.control_points) p += Vec3d{move(random), move(random), move(random)};
  return lattice;
}

Vec3d Deformed(const OutsideMap& map, const Lattice& lattice, Vec3d world) {
  return EvaluateWorld(map.continued(), map.Continue(lattice.control_points), world).position;
}

TEST(Strength, EveryPointGoesThatPartOfItsWay) {
  std::mt19937 random(kStrengthSeed);
  std::uniform_real_distribution<double> place(-0.25, 1.25), unit(0, 1);
  for (int mix = 0; mix < 27; ++mix) {
    const std::array<int, 3> degree{1 + mix % 3, 1 + mix / 3 % 3, 1 + mix / 9};
    for (const bool falls_off : {false, true}) {
      const Lattice lattice = RandomLattice(degree, falls_off, random);
      const double s = unit(random);
      const OutsideMap whole(lattice.structure), part(lattice.structure, s);
      for (int n = 0; n < 20; ++n) {
        const Vec3d x{place(random), place(random), place(random)};
        const Vec3d wanted = x + s * (Deformed(whole, lattice, x) - x);
        EXPECT_LE(Norm(Deformed(part, lattice, x) - wanted), 1e-14)
            << "mix " << mix << ", seed " << kStrengthSeed;
      }
    }
  }
}

TEST(Strength, AtNoneAllIsAtRestBitByBit) {
  std::mt19937 random(kStrengthSeed);
  const Lattice lattice = RandomLattice({2, 3, 1}, true, random);
  const OutsideMap none(lattice.structure, 0);
  const std::vector<Vec3d> points = none.Continue(lattice.control_points);
  const std::vector<Vec3d> rest = IdentityControlPoints(none.continued());
  ASSERT_EQ(points.size(), rest.size());
  for (size_t i = 0; i < rest.size(); ++i) EXPECT_TRUE(SameBits(points[i], rest[i])) << i;
}

TEST(Strength, ADragReachesItsTargets) {
  std::mt19937 random(kStrengthSeed);
  for (const bool falls_off : {false, true}) {
    Lattice lattice = RandomLattice({2, 2, 2}, falls_off, random);
    const OutsideMap map(lattice.structure, 0.3);
    const std::vector<Vec3d> points{{0.2, 0.3, 0.4}, {0.8, 0.6, 0.5}};
    const std::vector<Vec3d> targets{{0.25, 0.2, 0.5}, {0.7, 0.7, 0.5}};

    const ControlPointMoves moves = DragToTargets(lattice, points, targets, nullptr, {}, 0.3);

    EXPECT_LE(moves.residual, 1e-14);
    for (size_t n = 0; n < moves.indices.size(); ++n) {
      lattice.control_points[moves.indices[n]] += moves.offsets[n];
    }
    for (size_t n = 0; n < points.size(); ++n) {
      EXPECT_LE(Norm(Deformed(map, lattice, points[n]) - targets[n]), 1e-14);
    }
  }
}

class StrengthStepsTest : public EditHistoryTest {
 protected:
  absl::StatusOr<EditOutcome> Set(const std::string& editor, double strength) {
    return Do(editor, SetStrength{strength});
  }
  absl::StatusOr<EditOutcome> Slide(const std::string& editor, double strength,
                                    GesturePhase phase = GesturePhase::kUpdate) {
    return Apply({.editor_id = editor,
                  .gesture_id = "slide",
                  .gesture_phase = phase,
                  .edits = {SetStrength{strength}}});
  }
};

TEST_F(StrengthStepsTest, ItIsAStepThatMovesNothing) {
  ASSERT_OK(Do("ann", Move({3}, 0.25)));
  const auto outcome = Set("ann", 0.5);
  ASSERT_OK(outcome);
  EXPECT_TRUE(outcome->strength_changed);
  EXPECT_FALSE(outcome->structure_changed);
  EXPECT_TRUE(outcome->changed.empty());
  EXPECT_EQ(outcome->summary.revision, 2u);
  EXPECT_EQ(history_.strength(), 0.5);
  EXPECT_EQ(Moved(3), 0.25);
  ASSERT_OK(Set("ann", 0.25));

  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.strength(), 0.5);
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.strength(), 1);
  ASSERT_OK(Do("ann", Redo{}));
  EXPECT_EQ(history_.strength(), 0.5);
  EXPECT_EQ(Moved(3), 0.25);
}

TEST_F(StrengthStepsTest, AGestureIsOneStep) {
  ASSERT_OK(Set("ann", 0.9));
  for (const double s : {0.8, 0.5, 0.2}) ASSERT_OK(Slide("ann", s));
  ASSERT_OK(Slide("ann", 0.1, GesturePhase::kCommit));
  EXPECT_EQ(history_.strength(), 0.1);
  EXPECT_EQ(history_.undo_steps(), 2u);
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.strength(), 0.9);
  ASSERT_OK(Slide("ann", 0.4));
  ASSERT_OK(End("ann", "slide", GesturePhase::kCancel));
  EXPECT_EQ(history_.strength(), 0.9);
}

TEST_F(StrengthStepsTest, TwoEditorsThatSetItConflictAndThatMovePointsDoNot) {
  ASSERT_OK(Set("ann", 0.5));
  ASSERT_OK(Do("bob", Move({3}, 0.25)));
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.strength(), 1);
  ASSERT_OK(Set("ann", 0.5));
  ASSERT_OK(Set("bob", 0.25));
  EXPECT_EQ(Reason(Do("ann", Undo{})), "UNDO_CONFLICT");
  EXPECT_EQ(history_.strength(), 0.25);
}

TEST_F(StrengthStepsTest, ChangesOfStructureKeepIt) {
  ASSERT_OK(Set("ann", 0.5));
  ASSERT_OK(Do("ann", InsertKnot{0, 0.5}));
  EXPECT_EQ(history_.strength(), 0.5);
  ASSERT_OK(Do("ann", ReplaceLattice{UnitLattice(), false}));
  EXPECT_EQ(history_.strength(), 0.5);
  ASSERT_OK(Do("ann", Undo{}));
  EXPECT_EQ(history_.strength(), 0.5);
}

TEST_F(StrengthStepsTest, WhatIsForgottenStaysInForce) {
  ASSERT_OK(Set("ann", 0.5));
  ASSERT_OK(Do("ann", Move({3}, 0.25)));
  ASSERT_TRUE(history_.ForgetOldestStep());
  EXPECT_EQ(history_.strength(), 0.5);
  EXPECT_EQ(history_.image().base.strength, 0.5);
}

TEST_F(StrengthStepsTest, BadStrengthsAreRefused) {
  for (const double bad : {-0.01, 1.01, -double{INFINITY}, double{NAN}}) {
    EXPECT_THAT(Set("ann", bad), StatusIs(Code::kInvalidArgument,
                                          ::testing::HasSubstr("edits[0].set_strength.strength")));
  }
  EXPECT_EQ(history_.strength(), 1);
  auto image = history_.image();
  image.base.strength = 2;
  EXPECT_THAT(EditHistory::FromImage(std::move(image)), StatusIs(Code::kDataLoss));
}

TEST_F(StrengthStepsTest, ADragWithoutStrengthIsRefused) {
  const DragPoints drag{{{0.3, 0.5, 0.5}}, {{0.5, 0.6, 0.5}}};
  ASSERT_OK(Set("ann", 0));
  EXPECT_EQ(Reason(Do("ann", drag)), "NO_STRENGTH");
  // In one batch the drag is under the strength set before it.
  ASSERT_OK(Apply({.editor_id = "ann", .edits = {SetStrength{0.5}, drag}}));
  const OutsideMap map(history_.lattice().structure, 0.5);
  EXPECT_LE(Norm(Deformed(map, history_.lattice(), drag.points[0]) - drag.targets[0]), 1e-14);
}

TEST_F(StrengthStepsTest, AStrengthThatLeavesNothingToDragByIsAnError) {
  ASSERT_OK(Set("ann", 1e-20));
  const auto refused = Do("ann", DragPoints{{{0.3, 0.5, 0.5}}, {{0.5, 0.6, 0.5}}});
  EXPECT_THAT(refused, StatusIs(Code::kInvalidArgument));
  EXPECT_TRUE(AtStart());
}

}  // namespace
}  // namespace latticed
