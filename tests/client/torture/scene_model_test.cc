// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/torture/scene_model.h"

#include "client/cpp/latticectl/geometry/lattice_json.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A cube with 2 x 2 x 2 control points. Edit n puts control point n modulo 8 to (n, 0, 0).
Lattice Cube() {
  LatticeStructure cube{.degree = {1, 1, 1}, .size = {2, 2, 2}};
  for (auto& knots : cube.knots) knots = ClampedUniformKnots(1, 2);
  cube.frame = {{0, 0, 0}, {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}};
  return {cube, IdentityControlPoints(cube)};
}

EditBatch Edit(uint64_t sequence, const std::string& editor = "ann") {
  return {.editor_id = editor,
          .sequence = sequence,
          .structure_id = 1,
          .edits = {SetControlPoints{{static_cast<uint32_t>(sequence % 8)},
                                     {{static_cast<double>(sequence), 0, 0}}}}};
}

class SceneModelTest : public ::testing::Test {
 protected:
  void Acknowledge(uint64_t sequence, uint64_t revision, const std::string& editor = "ann") {
    v1::EditResult result;
    result.set_revision(revision);
    result.set_structure_id(1);
    model_.Acknowledged(Edit(sequence, editor), result);
  }
  void Edits(uint64_t count) {
    for (uint64_t n = 1; n <= count; ++n) {
      model_.Begin();
      Acknowledge(n, n);
    }
  }
  // What a server says that has edits 1 to `revision`.
  static v1::LatticeState After(uint64_t revision) {
    Lattice lattice = Cube();
    for (uint64_t n = 1; n <= revision; ++n) {
      lattice.control_points[n % 8] = {static_cast<double>(n), 0, 0};
    }
    v1::LatticeState state;
    *state.mutable_lattice() = ToProto(lattice);
    state.set_structure_id(1);
    state.set_revision(revision);
    return state;
  }
  void Check(const v1::LatticeState& state) { model_.Check(model_.newest(), state); }
  // The only fault, of this kind.
  void ExpectFault(uint64_t Faults::*kind, uint64_t count, const char* what) const {
    const Faults faults = model_.faults();
    EXPECT_EQ(faults.*kind, count);
    EXPECT_EQ(faults.lost + faults.doubled + faults.gaps + faults.twice + faults.differing, count);
    EXPECT_THAT(faults.what, ElementsAre(HasSubstr(what)));
    EXPECT_FALSE(model_.intact());
  }
  void ExpectNothing() const { EXPECT_THAT(model_.faults().what, IsEmpty()); }

  SceneModel model_{"vase", Cube()};
};

TEST_F(SceneModelTest, WhatWasAcknowledgedIsThere) {
  Edits(10);
  Check(After(10));
  Edits(0);
  Check(After(10));
  ExpectNothing();
}

TEST_F(SceneModelTest, AnEditWithoutAnswerMayBeThereOrNot) {
  Edits(2);
  model_.Begin();
  Check(After(2));
  ExpectNothing();
  Check(After(3));  // compared when the answer comes
  ExpectNothing();
  Acknowledge(3, 3);
  ExpectNothing();

  model_.Begin();
  v1::LatticeState wrong = After(4);
  wrong.mutable_lattice()->set_control_points(3, 0.5);
  Check(wrong);
  ExpectNothing();
  Acknowledge(4, 4);
  ExpectFault(&Faults::differing, 1,
              "scene vase, revision 4: has control point 1 at (0.5, 0, 0), not (1, 0, 0)");
}

TEST_F(SceneModelTest, AnOlderRevisionIsALoss) {
  Edits(5);
  Check(After(3));
  ExpectFault(&Faults::lost, 2, "scene vase, revision 3: is the newest, but revision 5 was");
}

TEST_F(SceneModelTest, SoIsOneThatWasShownButNotAcknowledged) {
  Edits(2);
  model_.Begin();
  model_.Told(3);
  Check(After(2));
  ExpectFault(&Faults::lost, 1, "revision 3 was acknowledged or shown");
}

TEST_F(SceneModelTest, ASceneThatIsGoneHasLostAll) {
  Edits(5);
  model_.Gone(absl::NotFoundError("there is no scene vase"));
  ExpectFault(&Faults::lost, 5, "there is no scene vase");
}

TEST_F(SceneModelTest, MoreRevisionsThanEditsAreDoubled) {
  Edits(2);
  Check(After(4));
  ExpectFault(&Faults::doubled, 2, "revision 4: is more than the 2 edits that were sent");
}

TEST_F(SceneModelTest, ARevisionOfNoEditIsAGap) {
  Edits(2);
  model_.Begin();
  model_.Begin();
  Acknowledge(3, 4);
  Check(After(4));
  ExpectNothing();
  model_.Refused(Edit(1, "bob"), /*unsure=*/false);
  ExpectFault(&Faults::gaps, 1, "revision 3: is of no edit that was acknowledged");
}

TEST_F(SceneModelTest, AnEditThatTheStoreRefusedMayBeThere) {
  Edits(2);
  model_.Begin();
  model_.Refused(Edit(3), /*unsure=*/true);
  model_.Begin();
  Acknowledge(4, 4);
  Check(After(4));
  ExpectNothing();
}

TEST_F(SceneModelTest, OneRevisionIsOneEdits) {
  Edits(2);
  model_.Begin();
  model_.Begin();
  Acknowledge(3, 3);
  Acknowledge(1, 3, "bob");
  ExpectFault(
      &Faults::twice, 1,
      "revision 3: was acknowledged for edit 3 of editor ann, and for edit 1 of editor bob");
}

TEST_F(SceneModelTest, AlsoLongAfterwards) {
  Edits(5);
  Check(After(5));
  model_.Begin();
  Acknowledge(6, 2);
  ExpectFault(&Faults::twice, 1, "revision 2: was acknowledged for another edit, and for edit 6");
}

TEST_F(SceneModelTest, AnotherStructureDiffers) {
  Edits(1);
  v1::LatticeState state = After(1);
  state.set_structure_id(2);
  Check(state);
  ExpectFault(&Faults::differing, 1, "revision 1: has structure 2, not 1");
}

TEST_F(SceneModelTest, OtherKnotsDiffer) {
  Edits(1);
  v1::LatticeState state = After(1);
  state.mutable_lattice()->set_knots_w(0, -1);
  state.mutable_lattice()->set_knots_w(1, -1);
  Check(state);
  ExpectFault(&Faults::differing, 1, "revision 1: has other knots");
}

TEST_F(SceneModelTest, AnAcknowledgementOfWhatMustBeRefusedDiffers) {
  EditBatch undo{.editor_id = "ann", .sequence = 1, .structure_id = 1, .edits = {Undo{}}};
  v1::EditResult result;
  result.set_revision(1);
  result.set_structure_id(1);
  model_.Begin();
  model_.Acknowledged(undo, result);
  Check(After(1));
  ExpectFault(&Faults::differing, 1, "edit 1 of editor ann was acknowledged, but must be refused");
}

}  // namespace
}  // namespace latticed::client
