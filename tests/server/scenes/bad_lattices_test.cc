// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// CreateScene refuses every lattice that the formulas do not allow. The refusal names what is wrong.
#include <functional>
#include <limits>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A valid lattice with every field set: frame [0,2] x [0,2] x [-1,1], 4 x 4 x 4 points, degree 2.
v1::Lattice GoodLattice() {
  v1::Lattice lattice;
  SetFrame(*lattice.mutable_frame(), {0, 0, -1}, {2, 2, 2});
  SetAxes(*lattice.mutable_degree(), 2, 2, 2);
  SetAxes(*lattice.mutable_size(), 4, 4, 4);
  for (const double knot : {0, 0, 0, 1, 2, 2, 2}) {
    lattice.add_knots_u(knot);
    lattice.add_knots_v(knot);
    lattice.add_knots_w(knot);
  }
  for (int i = 0; i < 3 * 64; ++i) lattice.add_control_points(i % 7);
  return lattice;
}

class BadLatticesTest : public SceneFixture {
 protected:
  // No scene was made. The same request with a valid lattice succeeds.
  void TearDown() override {
    EXPECT_EQ(SceneCount(), 0);
    v1::CreateSceneRequest request = SceneRequest();
    *request.add_lattices()->mutable_lattice() = GoodLattice();
    EXPECT_OK(Create(request));
    EXPECT_EQ(SceneCount(), 1);
  }
};

struct BadLattice {
  const char* name;
  std::function<void(v1::Lattice&)> spoil;
  const char* reason;
  const char* field;  // path below lattices[0].lattice
  const char* message;
};

const std::vector<BadLattice>& BadLattices() {
  using L = v1::Lattice;
  static const auto& rows = *new std::vector<BadLattice>{
      {"no frame", [](L& l) { l.clear_frame(); }, "INVALID_FIELD", "frame", "is required"},
      {"NaN in the origin", [](L& l) { l.mutable_frame()->mutable_origin()->set_x(kNan); },
       "NOT_FINITE", "frame.origin", "finite"},
      {"infinity in the origin",
       [](L& l) { l.mutable_frame()->mutable_origin()->set_y(kInfinity); }, "NOT_FINITE",
       "frame.origin", "finite"},
      {"NaN in an edge", [](L& l) { l.mutable_frame()->mutable_v()->set_z(kNan); }, "NOT_FINITE",
       "frame.v", "finite"},
      {"infinity in an edge", [](L& l) { l.mutable_frame()->mutable_w()->set_z(-kInfinity); },
       "NOT_FINITE", "frame.w", "finite"},
      {"two edges along each other", [](L& l) { *l.mutable_frame()->mutable_v() = l.frame().u(); },
       "SINGULAR_FRAME", "frame", "span a volume"},
      {"an edge of length 0", [](L& l) { l.mutable_frame()->clear_w(); }, "SINGULAR_FRAME", "frame",
       "span a volume"},
      {"three edges in a plane",
       [](L& l) {
         l.mutable_frame()->mutable_w()->set_z(1e-12);
         l.mutable_frame()->mutable_w()->set_x(1);
       },
       "SINGULAR_FRAME", "frame", "span a volume"},
      {"degree 0", [](L& l) { l.mutable_degree()->set_u(0); }, "OUT_OF_RANGE", "degree.u",
       "got 0, allowed is 1 to 3"},
      {"degree 4", [](L& l) { l.mutable_degree()->set_v(4); }, "OUT_OF_RANGE", "degree.v",
       "got 4, allowed is 1 to 3"},
      {"degree -1", [](L& l) { l.mutable_degree()->set_w(-1); }, "OUT_OF_RANGE", "degree.w",
       "got -1, allowed is 1 to 3"},
      {"size of the degree", [](L& l) { l.mutable_size()->set_u(2); }, "OUT_OF_RANGE", "size.u",
       "got 2, allowed is 3 to 32768"},
      {"size 0", [](L& l) { l.mutable_size()->set_w(0); }, "OUT_OF_RANGE", "size.w",
       "got 0, allowed is 3 to 32768"},
      {"size -4", [](L& l) { l.mutable_size()->set_v(-4); }, "OUT_OF_RANGE", "size.v",
       "got -4, allowed is 3 to 32768"},
      {"too many control points along an axis", [](L& l) { l.mutable_size()->set_v(32'769); },
       "OUT_OF_RANGE", "size.v", "got 32769, allowed is 3 to 32768"},
      {"too many control points in all", [](L& l) { SetAxes(*l.mutable_size(), 32, 32, 33); },
       "OUT_OF_RANGE", "size", "got 33792, allowed is 8 to 32768"},
      {"more control points than 64 bits count",
       [](L& l) { SetAxes(*l.mutable_size(), 2'000'000'000, 2'000'000'000, 2'000'000'000); },
       "OUT_OF_RANGE", "size.u", "allowed is 3 to 32768"},
      {"NaN in knots", [](L& l) { l.set_knots_u(3, kNan); }, "NOT_FINITE", "knots_u", "finite"},
      {"infinity in knots", [](L& l) { l.set_knots_w(6, kInfinity); }, "NOT_FINITE", "knots_w",
       "finite"},
      {"decreasing knots", [](L& l) { l.set_knots_v(3, 3); }, "INVALID_FIELD", "knots_v",
       "must not decrease"},
      {"a knot missing", [](L& l) { l.mutable_knots_u()->RemoveLast(); }, "INVALID_FIELD",
       "knots_u", "got 6 knots, size + degree + 1 = 7 are needed"},
      {"a knot too many", [](L& l) { l.add_knots_w(2); }, "INVALID_FIELD", "knots_w",
       "got 8 knots, size + degree + 1 = 7 are needed"},
      {"an interior knot above the degree",
       [](L& l) {
         l.mutable_size()->set_u(6);
         l.clear_knots_u();
         for (const double knot : {0, 0, 0, 1, 1, 1, 2, 2, 2}) l.add_knots_u(knot);
       },
       "INVALID_FIELD", "knots_u", "knot 1 has multiplicity 3, at most 2 is allowed"},
      {"an empty domain",
       [](L& l) {
         for (int i = 0; i < 7; ++i) l.set_knots_v(i, 1);
       },
       "INVALID_FIELD", "knots_v", "must not be empty"},
      {"NaN in control points", [](L& l) { l.set_control_points(100, kNan); }, "NOT_FINITE",
       "control_points", "finite"},
      {"infinity in control points", [](L& l) { l.set_control_points(191, kInfinity); },
       "NOT_FINITE", "control_points", "finite"},
      {"half a control point", [](L& l) { l.add_control_points(1); }, "INVALID_FIELD",
       "control_points", "got 193 numbers"},
      {"a control point too many",
       [](L& l) {
         for (int i = 0; i < 3; ++i) l.add_control_points(1);
       },
       "INVALID_FIELD", "control_points", "got 65 points, size u * v * w = 64 are needed"},
      {"more control points than any lattice has",
       [](L& l) { l.mutable_control_points()->Resize(3 * 32'768 + 3, 0); }, "OUT_OF_RANGE",
       "control_points", ""},
      {"a control point missing",
       [](L& l) {
         for (int i = 0; i < 3; ++i) l.mutable_control_points()->RemoveLast();
       },
       "INVALID_FIELD", "control_points", "got 63 points, size u * v * w = 64 are needed"},
  };
  return rows;
}

TEST_F(BadLatticesTest, LatticesAreCheckedFieldByField) {
  for (const BadLattice& row : BadLattices()) {
    SCOPED_TRACE(row.name);
    v1::CreateSceneRequest request = SceneRequest();
    v1::Lattice& lattice = *request.add_lattices()->mutable_lattice();
    lattice = GoodLattice();
    row.spoil(lattice);

    ExpectRefusal(Create(request), {.reason = row.reason,
                                    .field = std::string("lattices[0].lattice.") + row.field,
                                    .message = row.message});
  }
}

struct BadFit {
  const char* name;
  std::function<void(v1::LatticeFit&)> spoil;
  const char* reason;
  const char* field;  // path below lattices[0].fit
  const char* message;
};

void SetOutside(v1::LatticeFit& fit, v1::OutsideMode mode, const std::vector<double>& widths) {
  fit.mutable_outside()->set_mode(mode);
  fit.mutable_outside()->mutable_widths()->Add(widths.begin(), widths.end());
}

TEST_F(BadLatticesTest, FitsAreCheckedFieldByField) {
  using F = v1::LatticeFit;
  const std::vector<BadFit> rows = {
      {"NaN", [](F& f) { f.set_padding(kNan); }, "NOT_FINITE", "padding", "finite"},
      {"infinity", [](F& f) { f.set_padding(kInfinity); }, "NOT_FINITE", "padding", "finite"},
      {"below 0", [](F& f) { f.set_padding(-0.01); }, "OUT_OF_RANGE", "padding",
       "got -0.01, allowed is 0 to"},
      {"a flat mesh without padding", [](F& f) { f.set_padding(0); }, "INVALID_FIELD", "padding",
       "flat"},
      {"next to none", [](F& f) { f.set_padding(1e-310); }, "SINGULAR_FRAME", "padding",
       "a larger one is needed"},
      {"degree 0", [](F& f) { SetAxes(*f.mutable_degree(), 2, 0, 2); }, "OUT_OF_RANGE", "degree.v",
       "got 0, allowed is 1 to 3"},
      {"degree 4", [](F& f) { SetAxes(*f.mutable_degree(), 2, 2, 4); }, "OUT_OF_RANGE", "degree.w",
       "got 4, allowed is 1 to 3"},
      {"size of the degree", [](F& f) { SetAxes(*f.mutable_size(), 4, 2, 4); }, "OUT_OF_RANGE",
       "size.v", "got 2, allowed is 3 to 32768"},
      {"too many control points", [](F& f) { SetAxes(*f.mutable_size(), 100, 100, 100); },
       "OUT_OF_RANGE", "size", "got 1000000, allowed is 8 to 32768"},
      {"a line without widths", [](F& f) { SetOutside(f, v1::OUTSIDE_MODE_LINEAR, {}); },
       "INVALID_FIELD", "outside.widths", "no mesh says how far"},
      {"a falloff without widths", [](F& f) { SetOutside(f, v1::OUTSIDE_MODE_FALLOFF, {}); },
       "INVALID_FIELD", "outside.widths", "must be set"},
      {"a fixed one of a width", [](F& f) { SetOutside(f, v1::OUTSIDE_MODE_FIXED, {1}); },
       "INVALID_FIELD", "outside.widths", "must be empty"},
      {"next to no width", [](F& f) { SetOutside(f, v1::OUTSIDE_MODE_FALLOFF, {1e-6}); },
       "OUT_OF_RANGE", "outside.widths[0]", "allowed is 0.001 to 1000"},
  };
  for (const BadFit& row : rows) {
    SCOPED_TRACE(row.name);
    v1::CreateSceneRequest request = SceneRequest();
    row.spoil(*request.add_lattices()->mutable_fit());

    ExpectRefusal(Create(request), {.reason = row.reason,
                                    .field = std::string("lattices[0].fit.") + row.field,
                                    .message = row.message});
  }
}

}  // namespace
}  // namespace latticed::testing
