// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Refusals of what goes on outside a lattice.
#include <limits>

#include "tests/server/outside/outside_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr char kOutside[] = "lattices[0].lattice.outside";

class OutsideRequestsTest : public OutsideSceneTest {
 protected:
  void ExpectLattice(const v1::Lattice& lattice, const std::string& reason,
                     const std::string& field, int line = __builtin_LINE()) {
    ExpectRefused(Create(RequestFor(lattice)), Code::kInvalidArgument, reason, kOutside + field,
                  __FILE__, line);
  }
};

TEST_F(OutsideRequestsTest, RefusesWhatDoesNotFitTheMode) {
  v1::Lattice lattice = Falloff(0.3);
  lattice.mutable_outside()->clear_widths();
  ExpectLattice(lattice, "INVALID_FIELD", ".widths");
  lattice.mutable_outside()->add_widths(0.1);
  lattice.mutable_outside()->add_widths(0.1);
  ExpectLattice(lattice, "INVALID_FIELD", ".widths");
  lattice = Falloff(0.3);
  lattice.mutable_outside()->add_steps(0.1);
  lattice.mutable_outside()->add_steps(0.1);
  ExpectLattice(lattice, "INVALID_FIELD", ".steps");
  lattice = Falloff(0.3);
  lattice.mutable_outside()->set_mode(v1::OUTSIDE_MODE_FIXED);
  ExpectLattice(lattice, "INVALID_FIELD", ".widths");
  lattice = Linear();
  lattice.mutable_outside()->add_steps(0.1);
  ExpectLattice(lattice, "INVALID_FIELD", ".steps");
  lattice = Linear();
  lattice.mutable_outside()->set_continuity(v1::OUTSIDE_CONTINUITY_C0);
  ExpectLattice(lattice, "INVALID_FIELD", ".continuity");
  lattice = Linear();
  lattice.mutable_outside()->set_mode(static_cast<v1::OutsideMode>(9));
  ExpectLattice(lattice, "UNSUPPORTED", ".mode");
  lattice = Falloff(0.3, static_cast<v1::OutsideContinuity>(9));
  ExpectLattice(lattice, "UNSUPPORTED", ".continuity");
  EXPECT_EQ(SceneCount(), 0);
}

TEST_F(OutsideRequestsTest, RefusesBadNumbers) {
  for (const double width : {-1., 1e-4, 1e4}) {
    ExpectLattice(Falloff(width), "OUT_OF_RANGE", ".widths[1]");
  }
  ExpectLattice(Falloff(std::numeric_limits<double>::quiet_NaN()), "NOT_FINITE", ".widths[1]");
  for (const double step : {-0.1, 0.3, 7.}) {
    v1::Lattice lattice = Falloff(0.3);
    lattice.mutable_outside()->add_steps(step);
    ExpectLattice(lattice, "OUT_OF_RANGE", ".steps[1]");
  }
  v1::Lattice lattice = Falloff(0.3);
  lattice.mutable_outside()->add_steps(std::numeric_limits<double>::infinity());
  ExpectLattice(lattice, "NOT_FINITE", ".steps[1]");
}

TEST_F(OutsideRequestsTest, RefusesUnclampedKnotsAndTooManyControlPoints) {
  v1::Lattice lattice = Falloff(0.3);
  for (int k = 0; k < 7; ++k) lattice.add_knots_u(k);
  ExpectLattice(lattice, "INVALID_FIELD", ".widths[1]");
  lattice = Falloff(0.3);
  SetAxes(*lattice.mutable_size(), 32, 32, 32);
  ExpectLattice(lattice, "OUT_OF_RANGE", "");
}

TEST_F(OutsideRequestsTest, RefusesEditsThatCannotGoOn) {
  ASSERT_OK(Create(RequestFor(Linear())));
  // Within range inside, but not what the tangent leads to.
  const v1::LatticeState before = Lattice();
  ExpectRefused(Apply(MoveOne("ann", 1, 3, {9e17, 0, 0})), Code::kInvalidArgument, "OUT_OF_RANGE",
                "lattice.outside");
  v1::EditBatch knots = Replace(2, Falloff(0.3));
  SetAxes(*knots.mutable_edits(0)->mutable_replace_lattice()->mutable_lattice()->mutable_size(), 32,
          32, 32);
  ExpectRefused(Apply(knots), Code::kInvalidArgument, "OUT_OF_RANGE",
                "edits[0].replace_lattice.lattice.outside");
  EXPECT_EQ(Lattice().SerializeAsString(), before.SerializeAsString());
}

TEST_F(OutsideRequestsTest, AMirrorNeedsSymmetricWidths) {
  ASSERT_OK(Create(RequestFor(Falloff(0.3))));
  v1::EditBatch batch = MoveOne("ann", 1, 0, {});
  auto& constraints = *batch.mutable_edits(0)->mutable_set_constraints()->mutable_constraints();
  constraints.set_mirror(v1::LATTICE_AXIS_U);
  ExpectRefused(Apply(batch), Code::kInvalidArgument, "INVALID_FIELD",
                "edits[0].set_constraints.constraints.mirror");
  constraints.set_mirror(v1::LATTICE_AXIS_V);
  batch.set_sequence(2);
  EXPECT_OK(Apply(batch));
}

TEST_F(OutsideRequestsTest, AKnotThatWouldMakeTooManyControlPointsIsRefused) {
  v1::Lattice lattice = Falloff(0.3);
  SetAxes(*lattice.mutable_size(), 30, 32, 32);  // 32 with what goes on
  ASSERT_OK(Create(RequestFor(lattice)));
  v1::EditBatch knot = MoveOne("ann", 1, 0, {});
  knot.mutable_edits(0)->mutable_insert_knot()->set_value(1.5);
  ExpectRefused(Apply(knot), Code::kInvalidArgument, "OUT_OF_RANGE", "edits[0].insert_knot");
  EXPECT_EQ(Get().structure_id(), 1u);
}

}  // namespace
}  // namespace latticed::testing
