// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Folds of a session, compared with the definition's.
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/server/mixed/mixed_session.h"

namespace latticed::testing {
namespace {

constexpr int kSampled = 60, kPlacesCompared = 8;
constexpr double kBeside = 1e-9;  // from a plane between two polynomials, world units
constexpr double kDeterminant = 1e-10;

double Determinant(const std::array<Vec3d, 3>& columns) {
  return Dot(columns[0], Cross(columns[1], columns[2]));
}

}  // namespace

v1::FoldReport MixedSession::Folds() {
  v1::FoldReport report;
  EXPECT_OK(Call(&Scenes::CertifyFolds, For<v1::CertifyFoldsRequest>(), &report));
  return report;
}

void MixedSession::ExpectFolds(std::span<const LatticeDefinition> lattices) {
  const v1::FoldReport report = Folds();
  ++counts_[report.certified() ? "scenes certified" : "scenes that fold or may"];
  for (int n = 0; n < kSampled && report.certified(); ++n) {
    const CubePlace place = AnyPlace();
    ASSERT_GT(Determinant(model_.SurfaceAt(lattices, place, place.rest).jacobian), 0) << n;
  }
  for (int n = 0; n < std::min(report.places_size(), kPlacesCompared); ++n) {
    const v1::FoldedBox& fold = report.places(n);
    EXPECT_TRUE(HasDeterminant(lattices, fold)) << fold.DebugString();
    if (fold.state() != v1::FOLD_STATE_FOLDED) continue;
    EXPECT_LE(fold.determinant(), 0);
    ++counts_["folds as defined"];
  }
}

// On a knot plane and on an edge of the cube there are several.
bool MixedSession::HasDeterminant(std::span<const LatticeDefinition> lattices,
                                  const v1::FoldedBox& fold) {
  const Vec3d rest{fold.rest_point().x(), fold.rest_point().y(), fold.rest_point().z()};
  std::vector<CubePlace> places{{.triangle = 0, .barycentrics = {}, .rest = rest}};
  if (model_.weights().has_value()) places = PlacesAt(rest);
  for (const CubePlace& place : places) {
    for (int side = 0; side < 27; ++side) {
      const Vec3d aside{side % 3 - 1.0, side / 3 % 3 - 1.0, side / 9 - 1.0};
      const auto columns = model_.SurfaceAt(lattices, place, rest + kBeside * aside).jacobian;
      const double size = Norm(columns[0]) * Norm(columns[1]) * Norm(columns[2]);
      const double apart = std::abs(Determinant(columns) - fold.determinant());
      if (apart <= kDeterminant * std::max(size, 1.0)) return true;
    }
  }
  return false;
}

}  // namespace latticed::testing
