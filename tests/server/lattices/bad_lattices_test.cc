// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What scenes of several lattices refuse.
#include "tests/server/lattices/several_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

using BadSeveralLatticesTest = SeveralLatticesTest;

TEST_F(BadSeveralLatticesTest, LatticesThatDoNotAddUpAreRefused) {
  v1::Lattice turned = TurnedSpot();
  turned.clear_outside();
  ExpectRefused(Create(RequestOf({Whole(), turned})), Code::kInvalidArgument, "INVALID_FIELD",
                "lattices[1].outside");
  ExpectRefused(Create(RequestOf({Whole(), HalfLattice()})), Code::kInvalidArgument,
                "INVALID_FIELD", "lattices[1].outside");
  ExpectRefused(Create(RequestOf(std::vector<v1::Lattice>(9, Whole()))), Code::kInvalidArgument,
                "OUT_OF_RANGE", "lattices");
  v1::Lattice fine = Whole(), other = Whole();
  SetAxes(*fine.mutable_size(), 31, 31, 31);
  SetAxes(*other.mutable_size(), 20, 20, 20);
  ExpectRefused(Create(RequestOf({fine, other})), Code::kInvalidArgument, "INVALID_FIELD",
                "lattices");
}

TEST_F(BadSeveralLatticesTest, ALatticeThatThereIsNotIsRefused) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot()})));
  ExpectRefused(Apply(MoveIn(2, 1, 0, {})), Code::kInvalidArgument, "OUT_OF_RANGE", "lattice");
  auto lattice = For<v1::GetLatticeRequest>();
  lattice.set_lattice(2);
  v1::LatticeState state;
  ExpectRefused(Call(&Scenes::GetLattice, lattice, &state), Code::kInvalidArgument, "OUT_OF_RANGE",
                "lattice");
  auto measure = For<v1::MeasureSceneRequest>();
  measure.add_measures(v1::MEASURE_VOLUME);
  measure.set_lattice(7);
  v1::MeasureSceneResponse got;
  ExpectRefused(Call(&Scenes::MeasureScene, measure, &got), Code::kInvalidArgument, "OUT_OF_RANGE",
                "lattice");
  ASSERT_OK(Apply(MoveIn(1, 1, 0, {0.1, 0, 0})));  // the refused batch was not counted
  EXPECT_EQ(Get().revision(), 1u);
}

TEST_F(BadSeveralLatticesTest, WeightsAreEditsOfTheFirst) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot()})));
  v1::EditBatch batch = MoveIn(1, 1, 0, {});
  auto& weights = *batch.mutable_edits(0)->mutable_set_weights();
  weights.mutable_values()->resize(8 * sizeof(float));
  ExpectRefused(Apply(batch), Code::kInvalidArgument, "INVALID_FIELD", "lattice");
  batch.set_lattice(0);
  ASSERT_OK(Apply(batch));
  EXPECT_TRUE(Get().weighted());
}

TEST_F(BadSeveralLatticesTest, AFrameThatWouldNoLongerAddUpIsRefusedLater) {
  ASSERT_OK(Create(RequestOf({Whole(), Spot()})));
  v1::Lattice ends = Spot();
  ends.clear_outside();
  v1::EditBatch batch = Replace(1, ends);
  batch.set_lattice(1);
  ExpectRefused(Apply(batch), Code::kInvalidArgument, "INVALID_FIELD", "lattices[1].outside");
  EXPECT_EQ(Get().structure_id(), 1u);
}

}  // namespace
}  // namespace latticed::testing
