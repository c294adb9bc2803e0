// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Constraints of edits: held points and layers, mirror symmetry, and what becomes of them in the history.
#include "core/ffd/constraints/constraints.h"

#include <cmath>

#include "core/ffd/constraints/point_freedom.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/edit/knot_insertion.h"
#include "tests/core/ffd/history/edit_history_fixture.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using Code = absl::StatusCode;

class ConstraintsTest : public EditHistoryTest {
 protected:
  void Constrain(Constraints constraints) {
    ASSERT_TRUE(Do("ann", SetConstraints{std::move(constraints)}).ok());
  }
  const Vec3d& Point(int i, int j, int k) const {
    const Lattice& lattice = history_.lattice();
    return lattice.control_points[static_cast<size_t>(lattice.structure.Index(i, j, k))];
  }
  // The largest distance of a control point from its image in the plane u = 1/2.
  double Asymmetry() const {
    const auto& size = history_.lattice().structure.size;
    double largest = 0;
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          const Vec3d p = Point(i, j, k), q = Point(size[0] - 1 - i, j, k);
          largest = std::max(largest, Norm(p - Vec3d{1 - q.x, q.y, q.z}));
        }
      }
    }
    return largest;
  }
};

TEST_F(ConstraintsTest, SettingThemIsAStepThatMovesNothing) {
  const Constraints constraints{.held = {3}, .volume = KeptVolume{.volume = 2}};

  const auto outcome = Do("ann", SetConstraints{constraints});

  ASSERT_TRUE(outcome.ok());
  EXPECT_TRUE(outcome->constraints_changed);
  EXPECT_TRUE(outcome->changed.empty());
  EXPECT_EQ(history_.constraints(), constraints);
  EXPECT_TRUE(Do("ann", Undo{})->constraints_changed);
  EXPECT_EQ(history_.constraints(), Constraints{});
  EXPECT_TRUE(Do("ann", Redo{})->constraints_changed);
  EXPECT_EQ(history_.constraints(), constraints);
}

TEST_F(ConstraintsTest, AnotherEditorsConstraintsAreNotUndone) {
  Constrain({.held = {3}});
  ASSERT_TRUE(Do("bob", SetConstraints{{.held = {4}}}).ok());
  EXPECT_EQ(Reason(Do("ann", Undo{})), "UNDO_CONFLICT");
}

TEST_F(ConstraintsTest, HeldPointsStayUnderEveryEdit) {
  Constrain({.held = {21}, .held_layers = {{.axis = 2, .at_end = true, .layers = 2}}});
  const auto before = history_.lattice().control_points;
  std::vector<uint32_t> all;
  for (uint32_t i = 0; i < 64; ++i) all.push_back(i);
  std::vector<Vec3d> elsewhere(64, Vec3d{1, 2, 3});
  const std::array<double, 16> twice{2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 1, 1, 1};
  const std::vector<Edit> edits = {
      MoveControlPoints{all, {1, 2, 3}}, SetControlPoints{all, elsewhere},
      TransformControlPoints{all, twice}, ReplaceControlPoints{elsewhere},
      DragPoints{{{0.5, 0.5, 0.5}}, {{0.9, 0.9, 0.9}}}};
  for (const Edit& edit : edits) {
    ASSERT_TRUE(Do("ann", edit).ok());
    EXPECT_FALSE(AtStart());
    for (size_t i = 0; i < 64; ++i) {
      if (i != 21 && i < 32) continue;
      EXPECT_EQ(history_.lattice().control_points[i], before[i]);
    }
  }
  ASSERT_TRUE(Do("ann", Reset{}).ok());
  EXPECT_TRUE(AtStart());
}

TEST_F(ConstraintsTest, ADragReachesItsTargetWithTheFreePoints) {
  const Vec3d point{0.4, 0.5, 0.45}, target{0.6, 0.4, 0.5};
  for (const Constraints& constraints :
       {Constraints{.held = {21, 22}}, Constraints{.mirror = 0},
        Constraints{.held = {21}, .held_layers = {{.axis = 1, .layers = 1}}, .mirror = 0}}) {
    history_ = EditHistory(UnitLattice());
    sequences_.clear();
    Constrain(constraints);
    const auto outcome = Do("ann", DragPoints{{point}, {target}});
    ASSERT_TRUE(outcome.ok());
    EXPECT_LE(outcome->summary.drag_residual, 1e-12);
    const Lattice& lattice = history_.lattice();
    EXPECT_LE(
        Norm(EvaluateWorld(lattice.structure, lattice.control_points, point).position - target),
        1e-12);
    if (constraints.mirror.has_value()) {
      EXPECT_LE(Asymmetry(), 1e-14);
    }
    for (const uint32_t i : constraints.held) {
      EXPECT_EQ(history_.lattice().control_points[i], history_.initial().control_points[i]);
    }
  }
}

// Any other symmetric move that reaches the target is longer: the least one is orthogonal to those that move the point
// nowhere.
TEST_F(ConstraintsTest, AMirroredDragIsTheLeast) {
  Constrain({.mirror = 0});
  const Vec3d point{0.3, 0.5, 0.45};
  ASSERT_TRUE(Do("ann", DragPoints{{point}, {point + Vec3d{0.1, 0.2, -0.1}}}).ok());
  const auto& s = history_.lattice().structure;
  const PointFreedom freedom({.mirror = 0}, s);
  std::vector<Vec3d> move = history_.lattice().control_points, other(64);
  for (size_t i = 0; i < 64; ++i) {
    move[i] -= history_.initial().control_points[i];
    other[i] = {std::sin(double(i)), std::cos(3.0 * double(i)), std::sin(2.0 * double(i))};
  }
  freedom.SymmetriseMoves(other);
  // Takes from `other` what moves the point, by the least move that does the same.
  const Lattice rest = history_.initial();
  Lattice moved = rest;
  for (size_t i = 0; i < 64; ++i) moved.control_points[i] += other[i];
  const Vec3d effect = EvaluateWorld(s, moved.control_points, point).position - point;
  EditHistory another(rest);
  ASSERT_TRUE(another
                  .Apply({.editor_id = "a",
                          .sequence = 1,
                          .structure_id = 1,
                          .edits = {SetConstraints{{.mirror = 0}}}},
                         now_, {})
                  .ok());
  ASSERT_TRUE(another
                  .Apply({.editor_id = "a",
                          .sequence = 2,
                          .structure_id = 1,
                          .edits = {DragPoints{{point}, {point + effect}}}},
                         now_, {})
                  .ok());
  double along = 0;
  for (size_t i = 0; i < 64; ++i) {
    other[i] -= another.lattice().control_points[i] - rest.control_points[i];
    along += Dot(move[i], other[i]);
  }
  EXPECT_NEAR(along, 0, 1e-13);
}

// Points that were moved before there was a mirror stay where they are but for the drag.
TEST_F(ConstraintsTest, AMirroredDragReachesItsTargetFromAnyLattice) {
  ASSERT_TRUE(Do("ann", MoveControlPoints{{21, 25}, {0.1, 0.2, 0.3}}).ok());
  Constrain({.mirror = 0});
  const double before = Asymmetry();
  const Vec3d point{0.3, 0.5, 0.45}, target{0.4, 0.6, 0.5};

  const auto outcome = Do("ann", DragPoints{{point}, {target}});

  ASSERT_TRUE(outcome.ok());
  EXPECT_LE(outcome->summary.drag_residual, 1e-12);
  const Lattice& lattice = history_.lattice();
  const DeformedPoint dragged = EvaluateWorld(lattice.structure, lattice.control_points, point);
  EXPECT_LE(Norm(dragged.position - target), 1e-12);
  EXPECT_NEAR(Asymmetry(), before, 1e-12);
}

TEST_F(ConstraintsTest, ImagesMoveAlongWithTheirPoints) {
  Constrain({.mirror = 0});
  ASSERT_TRUE(Do("ann", MoveControlPoints{{21}, {0.1, 0.2, 0.3}}).ok());
  EXPECT_LE(Asymmetry(), 1e-15);
  EXPECT_GT(Norm(history_.lattice().control_points[22] - history_.initial().control_points[22]),
            0.3);
  // Both of a pair by one offset: what would break the symmetry is left out.
  ASSERT_TRUE(Do("ann", MoveControlPoints{{25, 26}, {0.1, 0, 0.3}}).ok());
  EXPECT_LE(Asymmetry(), 1e-15);
  EXPECT_NEAR(history_.lattice().control_points[25].x, history_.initial().control_points[25].x,
              1e-15);
  ASSERT_TRUE(Do("ann", Reset{}).ok());
  EXPECT_TRUE(AtStart());
}

TEST_F(ConstraintsTest, InsertedKnotsKeepThem) {
  Constrain({.held = {21}, .held_layers = {{.axis = 2, .layers = 1}}, .mirror = 0});
  ASSERT_TRUE(Do("ann", InsertKnot{0, 0.3}).ok());

  // With its image, so that the knots stay symmetric.
  const LatticeStructure& s = history_.lattice().structure;
  EXPECT_EQ(s.size[0], 6);
  EXPECT_TRUE(Check(history_.constraints(), s, "constraints").ok());
  EXPECT_EQ(history_.constraints().mirror, 0);
  EXPECT_EQ(history_.constraints().held_layers.size(), 1u);
  EXPECT_GT(history_.constraints().held.size(), 1u);
  for (uint32_t i : history_.constraints().held) {
    ASSERT_TRUE(Do("ann", MoveControlPoints{{i}, {1, 1, 1}}).ok());
  }
  EXPECT_EQ(history_.lattice().control_points, IdentityControlPoints(s));
  // Undo takes the knots and their constraints back.
  while (history_.structure_id() == 2) ASSERT_TRUE(Do("ann", Undo{}).ok());
  EXPECT_EQ(history_.constraints().held, std::vector<uint32_t>{21});
}

TEST_F(ConstraintsTest, AnotherLatticeKeepsWhatMeansTheSame) {
  const KeptVolume volume{.axis = 1, .volume = 3};
  const Constraints all{.held = {21},
                        .held_layers = {{.axis = 2, .at_end = true, .layers = 3}},
                        .mirror = 0,
                        .volume = volume};
  Constrain(all);
  // Of the same net: all.
  Lattice moved = UnitLattice();
  moved.structure.frame.origin = {1, 2, 3};
  moved.control_points = IdentityControlPoints(moved.structure);
  ASSERT_TRUE(Do("ann", ReplaceLattice{moved}).ok());
  EXPECT_EQ(history_.constraints(), all);
  // What is sheared has no mirror; what is smaller has fewer layers, and other points.
  moved.structure.frame.edges[0] = {1, 0.1, 0};
  ASSERT_TRUE(Do("ann", ReplaceLattice{moved}).ok());
  EXPECT_EQ(history_.constraints(),
            (Constraints{.held = {21}, .held_layers = all.held_layers, .volume = volume}));
  ASSERT_TRUE(Do("ann", Undo{}).ok());
  ASSERT_TRUE(Do("ann", ReplaceLattice{*FitLattice(UnitBounds(), {5, 4, 2}, {2, 2, 1}, 0)}).ok());
  EXPECT_EQ(history_.constraints(),
            (Constraints{.held_layers = {{.axis = 2, .at_end = true, .layers = 2}},
                         .mirror = 0,
                         .volume = volume}));
  ASSERT_TRUE(Do("ann", Undo{}).ok());
  EXPECT_EQ(history_.constraints(), all);
}

TEST_F(ConstraintsTest, AMirrorMovesNothingWhereOnlyOutsideChanges) {
  ASSERT_TRUE(Do("ann", MoveControlPoints{{21}, {0.1, 0.2, 0.3}}).ok());
  Constrain({.mirror = 0});
  Lattice lattice = history_.lattice();
  lattice.structure.outside = {
      .mode = OutsideMode::kFalloff, .widths = {0.3, 0.3}, .steps = {0.15, 0.15}};
  ASSERT_TRUE(Do("ann", ReplaceLattice{lattice}).ok());
  EXPECT_EQ(history_.lattice().control_points, lattice.control_points);
  EXPECT_EQ(history_.constraints().mirror, 0);
  lattice.control_points[21] += Vec3d{0.1, 0, 0};
  ASSERT_TRUE(Do("ann", ReplaceLattice{lattice}).ok());
  EXPECT_LE(Asymmetry(), 1e-15);
}

TEST_F(ConstraintsTest, InTheSameFrameAReplacementHonoursThem) {
  Constrain({.held = {21}, .mirror = 0});
  ASSERT_TRUE(Do("ann", MoveControlPoints{{0}, {0.1, 0.2, 0.3}}).ok());
  const std::vector<Vec3d> before = history_.lattice().control_points;
  Lattice wider = UnitLattice();
  wider.structure.outside.widths = {};
  ASSERT_TRUE(Do("ann", ReplaceLattice{wider, true}).ok());
  EXPECT_EQ(history_.lattice().control_points, before);
  for (Vec3d& p : wider.control_points) p += Vec3d{0.1, 0.2, 0};
  ASSERT_TRUE(Do("ann", ReplaceLattice{wider}).ok());
  EXPECT_EQ(history_.lattice().control_points[21], before[21]);
  EXPECT_LE(Asymmetry(), 1e-15);
  EXPECT_NE(history_.lattice().control_points[0], before[0]);
}

TEST_F(ConstraintsTest, RefusesWhatCannotBe) {
  const auto refused = [this](Constraints constraints) {
    const auto result = Do("ann", SetConstraints{std::move(constraints)});
    EXPECT_THAT(result, StatusIs(Code::kInvalidArgument));
    return error::DetailsOf(result.status()).field;
  };
  const std::string field = "edits[0].set_constraints.constraints";
  EXPECT_EQ(refused({.held = {64}}), field + ".held[0]");
  EXPECT_EQ(refused({.held = {1, 1}}), field + ".held[1]");
  EXPECT_EQ(refused({.held_layers = {{.axis = 0, .layers = 4}}}), field + ".held_layers[0].layers");
  EXPECT_EQ(refused({.held_layers = {{.axis = 0, .layers = 0}}}), field + ".held_layers[0].layers");
  EXPECT_EQ(refused({.held_layers = {{.axis = 0}, {.axis = 0}}}), field + ".held_layers[1]");
  EXPECT_EQ(refused({.volume = KeptVolume{.volume = std::nan("")}}), field + ".volume.volume");
  EXPECT_EQ(refused({.volume = KeptVolume{.volume = 0}}), field + ".volume.volume");
  ASSERT_TRUE(Do("ann", InsertKnot{0, 0.3}).ok());
  EXPECT_EQ(refused({.mirror = 0}), field + ".mirror");  // the knots are not symmetric
  Lattice sheared = UnitLattice();
  sheared.structure.frame.edges[0] = {1, 0.1, 0};
  sheared.control_points = IdentityControlPoints(sheared.structure);
  ASSERT_TRUE(Do("ann", ReplaceLattice{sheared}).ok());
  EXPECT_EQ(refused({.mirror = 0}), field + ".mirror");
  EXPECT_THAT(
      Apply({.editor_id = "ann", .edits = {SetConstraints{}, MoveControlPoints{{1}, {1, 1, 1}}}}),
      StatusIs(Code::kInvalidArgument));
}

// Against the identity, layers held at a face join the inside with continuous derivatives of lower orders.
TEST(HeldLayersTest, JoinTheIdentityContinuously) {
  for (int degree = 1; degree <= 3; ++degree) {
    for (int layers = 1; layers <= degree; ++layers) {
      Bounds bounds = UnitBounds();
      Lattice lattice = *FitLattice(bounds, {6, 6, 6}, {degree, degree, degree}, 0);
      const PointFreedom freedom({.held_layers = {{.axis = 0, .layers = layers}}},
                                 lattice.structure);
      for (size_t i = 0; i < lattice.control_points.size(); ++i) {
        if (!freedom.is_held(i)) lattice.control_points[i] += Vec3d{0.1, 0.3, -0.2};
      }
      // The displacement near the face falls with this power of the distance.
      const auto moved = [&](double x) {
        const Vec3d p{x, 0.4, 0.6};
        return Norm(EvaluateWorld(lattice.structure, lattice.control_points, p).position - p);
      };
      EXPECT_LE(moved(0), 1e-15);
      EXPECT_NEAR(std::log2(moved(2e-4) / moved(1e-4)), layers, 1e-3);
    }
  }
}

}  // namespace
}  // namespace latticed
