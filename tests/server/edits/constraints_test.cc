// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// set_constraints and keep_volume through the stub.
#include <cmath>
#include <string>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr char kBoxObj[] =
    "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 0 0 1\nv 2 0 1\nv 2 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
constexpr double kRestVolume = 2;

class ConstraintEditsTest : public SceneFixture {
 protected:
  void SetUp() override {
    SceneFixture::SetUp();
    open_ = mesh_;
    mesh_ = Upload(kBoxObj);
    ASSERT_OK(Create(SceneRequest()));
  }
  v1::EditBatch Constrain(const v1::Constraints& constraints) {
    v1::EditBatch batch = Move("ann", ++sequence_, 0, 0);
    *batch.mutable_edits(0)->mutable_set_constraints()->mutable_constraints() = constraints;
    return batch;
  }
  v1::EditBatch Pull(double x, uint32_t point = 21) { return Move("ann", ++sequence_, point, x); }
  void ExpectKept() { EXPECT_NEAR(MeasuredVolume() / kRestVolume, 1, 1e-12); }

  std::string open_;
  uint64_t sequence_ = 0;
};

TEST_F(ConstraintEditsTest, TheVolumeIsKeptByEveryEdit) {
  v1::Constraints constraints;
  constraints.mutable_volume();
  ASSERT_OK(Apply(Constrain(constraints)));
  EXPECT_EQ(Lattice().revision(), 1u);
  EXPECT_TRUE(Lattice().constraints().has_volume());
  const double before = Lattice().lattice().control_points(3 * 21);

  ASSERT_OK(Apply(Pull(0.5)));

  ExpectKept();
  EXPECT_EQ(Lattice().lattice().control_points(3 * 21), before + 0.5);  // others have moved for it
  v1::EditBatch gesture = Pull(0.3, 22);
  gesture.set_gesture_id("g");
  ASSERT_OK(Apply(gesture));
  ExpectKept();
  v1::EditBatch cancel = gesture;
  cancel.set_sequence(++sequence_);
  cancel.clear_edits();
  cancel.set_gesture_phase(v1::GESTURE_PHASE_CANCEL);
  ASSERT_OK(Apply(cancel));
  ExpectKept();
  // Undo takes back the edit together with the moves for it.
  ASSERT_OK(Apply(UndoMine("ann", ++sequence_)));
  EXPECT_EQ(Lattice().lattice().control_points(3 * 21), before);
  ExpectKept();
  ASSERT_OK(Apply(UndoMine("ann", ++sequence_)));
  EXPECT_FALSE(Lattice().has_constraints());
}

TEST_F(ConstraintEditsTest, AGestureKeepsTheVolumeByItself) {
  v1::EditBatch batch = Pull(0.5);
  batch.set_gesture_id("g");
  batch.mutable_keep_volume()->set_axis(v1::LATTICE_AXIS_W);
  const auto before = Lattice();

  ASSERT_OK(Apply(batch));

  ExpectKept();
  const auto after = Lattice();
  for (int i = 0; i < 64; ++i) {  // the others along z only
    if (i == 21) continue;
    EXPECT_EQ(after.lattice().control_points(3 * i), before.lattice().control_points(3 * i));
  }
  ASSERT_OK(Apply(Pull(0.5)));
  EXPECT_GT(std::abs(MeasuredVolume() / kRestVolume - 1), 1e-6);  // a batch that does not name it
}

TEST_F(ConstraintEditsTest, AGivenVolumeIsReached) {
  v1::Constraints constraints;
  constraints.mutable_volume()->set_volume(3);
  ASSERT_OK(Apply(Constrain(constraints)));
  EXPECT_NEAR(MeasuredVolume(), kRestVolume, 1e-12);  // setting it moves nothing
  ASSERT_OK(Apply(Pull(0.1)));
  EXPECT_NEAR(MeasuredVolume(), 3, 3e-12);
}

TEST_F(ConstraintEditsTest, AllAreToldAndKeptThroughKnots) {
  v1::Constraints constraints;
  constraints.add_held(21);
  auto& layers = *constraints.add_held_layers();
  layers.set_axis(v1::LATTICE_AXIS_V);
  layers.set_at_end(true);
  layers.set_layers(2);
  constraints.set_mirror(v1::LATTICE_AXIS_W);
  constraints.mutable_volume()->set_axis(v1::LATTICE_AXIS_U);
  constraints.mutable_volume()->set_volume(kRestVolume);
  ASSERT_OK(Apply(Constrain(constraints)));
  EXPECT_EQ(Lattice().constraints().SerializeAsString(), constraints.SerializeAsString());

  ASSERT_OK(Apply(Knot("ann", ++sequence_)));

  auto kept = Lattice().constraints();
  EXPECT_GE(kept.held_size(), 1);
  kept.clear_held();
  constraints.clear_held();
  EXPECT_EQ(kept.SerializeAsString(), constraints.SerializeAsString());
}

TEST_F(ConstraintEditsTest, AllAreKeptThroughAnotherFalloff) {
  v1::Constraints constraints;
  constraints.add_held(21);
  auto& layers = *constraints.add_held_layers();
  layers.set_axis(v1::LATTICE_AXIS_V);
  layers.set_at_end(true);
  layers.set_layers(1);
  constraints.set_mirror(v1::LATTICE_AXIS_W);
  constraints.mutable_volume();
  ASSERT_OK(Apply(Pull(0.1)));
  ASSERT_OK(Apply(Pull(0.15, 25)));  // and not its image, 41
  ASSERT_OK(Apply(Constrain(constraints)));
  ASSERT_OK(Apply(Pull(0.2, 22)));
  const v1::LatticeState before = Lattice();
  const auto replace = [&](const v1::Lattice& lattice, bool keep_shape) {
    v1::EditBatch batch = Pull(0);
    auto& edit = *batch.mutable_edits(0)->mutable_replace_lattice();
    *edit.mutable_lattice() = lattice;
    edit.set_keep_shape(keep_shape);
    batch.set_structure_id(Lattice().structure_id());
    return Apply(batch);
  };
  const auto pull = [&](double x, uint32_t point) {
    v1::EditBatch batch = Pull(x, point);
    batch.set_structure_id(Lattice().structure_id());
    return Apply(batch);
  };
  const auto at = [&](int point) {
    const v1::LatticeState state = Lattice();
    const auto& p = state.lattice().control_points();
    return Vec3d{p[3 * point], p[3 * point + 1], p[3 * point + 2]};
  };
  const Vec3d held = at(21), layer = at(13);

  v1::Lattice falloff = before.lattice();
  falloff.clear_control_points();
  falloff.mutable_outside()->set_mode(v1::OUTSIDE_MODE_FALLOFF);
  for (const double width : {0.3, 0.5}) {
    falloff.mutable_outside()->clear_widths();
    falloff.mutable_outside()->add_widths(width);
    const Vec3d beside = at(25), image = at(41);
    ASSERT_OK(replace(falloff, true));
    EXPECT_LE(Norm(at(25) - beside) + Norm(at(41) - image), 1e-12);
    EXPECT_EQ(Lattice().constraints().SerializeAsString(), constraints.SerializeAsString());
    EXPECT_EQ(at(21), held);
    ExpectKept();
    ASSERT_OK(pull(0.1, 22));  // and its image, 38
    EXPECT_NEAR(at(22).x, at(38).x, 1e-12);
    ASSERT_OK(pull(0.1, 21));
    ASSERT_OK(pull(0.1, 13));
    EXPECT_EQ(at(21), held);
    EXPECT_EQ(at(13), layer);
    ExpectKept();
  }
  ASSERT_OK(replace(falloff, false));  // at rest but for what is held
  EXPECT_EQ(at(21), held);
  // Another size lets single points go.
  SetAxes(*falloff.mutable_size(), 5, 5, 5);
  falloff.clear_knots_u();
  falloff.clear_knots_v();
  falloff.clear_knots_w();
  ASSERT_OK(replace(falloff, true));
  v1::Constraints left = constraints;
  left.clear_held();
  EXPECT_EQ(Lattice().constraints().SerializeAsString(), left.SerializeAsString());
  ExpectKept();
  ASSERT_OK(Apply(UndoMine("ann", ++sequence_)));
  EXPECT_EQ(Lattice().constraints().SerializeAsString(), constraints.SerializeAsString());
  EXPECT_EQ(at(21), held);
}

TEST_F(ConstraintEditsTest, WhatCannotBeKeptIsRefused) {
  v1::Constraints constraints;
  for (uint32_t i = 0; i < 64; ++i) {
    if (i != 21) constraints.add_held(i);
  }
  constraints.mutable_volume();
  ASSERT_OK(Apply(Constrain(constraints)));
  ASSERT_OK(Apply(Pull(0)));
  // The only free point is put where it was.
  ASSERT_OK(Apply(Pull(0.1)));
  ExpectKept();
  constraints.add_held(21);
  constraints.mutable_volume()->set_volume(3);
  ASSERT_OK(Apply(Constrain(constraints)));
  const auto before = Lattice();
  ExpectRefused(Apply(Pull(0.1)), Code::kFailedPrecondition, "VOLUME_NOT_KEPT");
  EXPECT_EQ(Lattice().SerializeAsString(), before.SerializeAsString());
}

TEST_F(ConstraintEditsTest, AnOpenSurfaceKeepsNoVolume) {
  ASSERT_OK(DeleteScene());
  mesh_ = open_;
  ASSERT_OK(Create(SceneRequest()));
  v1::Constraints constraints;
  constraints.mutable_volume();
  ExpectRefused(Apply(Constrain(constraints)), Code::kFailedPrecondition, "OPEN_SURFACE");
  v1::EditBatch batch = Pull(0.1);
  batch.mutable_keep_volume();
  ExpectRefused(Apply(batch), Code::kFailedPrecondition, "OPEN_SURFACE");
}

TEST_F(ConstraintEditsTest, RefusesBadConstraints) {
  const std::string field = "edits[0].set_constraints.constraints";
  v1::Constraints constraints;
  constraints.add_held(64);
  ExpectRefused(Apply(Constrain(constraints)), Code::kInvalidArgument, "OUT_OF_RANGE",
                field + ".held[0]");
  constraints.Clear();
  constraints.add_held_layers()->set_layers(1);
  ExpectRefused(Apply(Constrain(constraints)), Code::kInvalidArgument, "INVALID_FIELD",
                field + ".held_layers[0].axis");
  constraints.mutable_held_layers(0)->set_axis(v1::LATTICE_AXIS_U);
  constraints.mutable_held_layers(0)->set_layers(4);
  ExpectRefused(Apply(Constrain(constraints)), Code::kInvalidArgument, "OUT_OF_RANGE",
                field + ".held_layers[0].layers");
  constraints.Clear();
  constraints.set_mirror(static_cast<v1::LatticeAxis>(7));
  ExpectRefused(Apply(Constrain(constraints)), Code::kInvalidArgument, "UNSUPPORTED",
                field + ".mirror");
  constraints.Clear();
  constraints.mutable_volume()->set_volume(0);
  ExpectRefused(Apply(Constrain(constraints)), Code::kInvalidArgument, "INVALID_FIELD",
                field + ".volume.volume");
  v1::EditBatch batch = Pull(0.1);
  batch.mutable_keep_volume()->set_volume(0);
  ExpectRefused(Apply(batch), Code::kInvalidArgument, "INVALID_FIELD", "keep_volume.volume");
  v1::EditBatch two = Constrain({});
  *two.add_edits() = two.edits(0);
  ExpectRefused(Apply(two), Code::kInvalidArgument, "INVALID_FIELD", "edits[0].set_constraints");
}

using WatchedConstraintsTest = SceneStreamTest;

TEST_F(WatchedConstraintsTest, WatchersAreToldOfChanges) {
  WatchClient watcher(*scenes_, Watch("bob"));
  watcher.ReadUntilRevision(0);
  ASSERT_FALSE(watcher.log.lattice.has_constraints());
  v1::EditBatch batch = Move(1, 0, 0);
  batch.mutable_edits(0)->mutable_set_constraints()->mutable_constraints()->add_held(7);

  ASSERT_OK(Apply(batch));

  watcher.ReadUntilRevision(1);
  EXPECT_EQ(watcher.log.lattice.constraints().held(0), 7u);
  EXPECT_EQ(watcher.log.lattice.structure_id(), structure_id_);
  const size_t topologies = watcher.log.topologies.size();
  v1::EditBatch undo = Move(2, 0, 0);
  undo.mutable_edits(0)->mutable_undo();
  ASSERT_OK(Apply(undo));
  ASSERT_OK(Apply(Move(3, 9, 0.5)));
  watcher.ReadUntilRevision(3);
  EXPECT_FALSE(watcher.log.lattice.has_constraints());
  EXPECT_EQ(watcher.log.topologies.size(), topologies);  // the surface goes on as it was
}

}  // namespace
}  // namespace latticed::testing
