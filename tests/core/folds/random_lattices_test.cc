// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Random lattices at all degree mixes against dense samples of the definition. LATTICED_FOLD_LATTICES and
// LATTICED_FOLD_SAMPLES set their number and the samples per box and axis.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <string>

#include "core/folds/fold_certifier.h"
#include "tests/core/folds/fold_fixtures.h"

namespace latticed {
namespace {

uint32_t Setting(const char* name, uint32_t usual) {
  const char* const text = std::getenv(name);
  return text == nullptr ? usual : static_cast<uint32_t>(std::stoul(text));
}

// The least det J of the box at n^3 points, faces included.
double LeastSample(const testing::FoldCase& lattice, const KnotBox& box, uint32_t n) {
  double least = 1e300;
  const Vec3d width = box.upper - box.lower;
  for (uint32_t k = 0; k < n * n * n; ++k) {
    const Vec3d l{double(k % n) / (n - 1), double(k / n % n) / (n - 1),
                  double(k / n / n) / (n - 1)};
    const Vec3d at = box.lower + Vec3d{l.x * width.x, l.y * width.y, l.z * width.z};
    least = std::min(least, testing::DefinedDeterminant(lattice.structure, lattice.control_points,
                                                        box.span, at));
  }
  return least;
}

// The cells that the search of a box looks at.
int CellsOf(const testing::FoldCase& lattice, const KnotBox& box, FoldSearch& search) {
  const double slack = MakeBoxDeterminant(lattice.structure, lattice.control_points,
                                          {box.span, box.lower, box.upper}, search.polynomial());
  return search.Decide(slack).cells;
}

TEST(RandomLattices, NoCertificateIsWrongAndNearlyAllBoxesAreDecided) {
  // What the definition may lose. det J of these lattices is below 100.
  constexpr double kRounding = 1e-11;
  const uint32_t count = Setting("LATTICED_FOLD_LATTICES", 540);
  const uint32_t samples = Setting("LATTICED_FOLD_SAMPLES", 5);
  ASSERT_GE(samples, 2);
  uint64_t boxes = 0, undecided = 0, folded = 0, missed = 0;
  int cells = 0, most_cells = 0;
  FoldSearch search;
  uint64_t certified_lattices = 0, decided_lattices = 0;
  for (uint32_t seed = 0; seed < count; ++seed) {
    SCOPED_TRACE(seed);
    // From lattices that hardly ever fold to lattices that nearly always do.
    const double amount = 0.15 * (1 + seed / 27 % 5);
    const testing::FoldCase lattice = testing::DrawLattice(seed, seed % 27, amount);
    const auto plan = testing::PlanOf(lattice.structure, testing::CubeMesh(1));
    ASSERT_NE(plan, nullptr);
    const auto report = FoldCertifier(plan, FoldScope::kVolume).Certify(lattice.control_points);
    ASSERT_TRUE(report.ok());
    boxes += report->boxes;
    undecided += report->Count(FoldState::kUndecided);
    folded += report->Count(FoldState::kFolded);
    certified_lattices += report->certified() ? 1u : 0u;
    decided_lattices += report->Count(FoldState::kUndecided) == 0 ? 1u : 0u;
    for (uint32_t box = 0; box < plan->outside_box(); ++box) {
      const double least = LeastSample(lattice, plan->boxes[box], samples);
      const int looked_at = CellsOf(lattice, plan->boxes[box], search);
      cells += looked_at;
      most_cells = std::max(most_cells, looked_at);
      switch (report->StateOf(box)) {
        case FoldState::kCertified:
          EXPECT_GT(least, -kRounding) << "box " << box;
          break;
        case FoldState::kFolded:
          missed += least > 0 ? 1u : 0u;  // by the samples, not by the certificate
          break;
        case FoldState::kUndecided:
          break;
      }
    }
    for (const FoldedBox& place : report->places) {
      const Vec3d at = FrameMap(lattice.structure).ToParameter(place.rest_point);
      EXPECT_NEAR(testing::DefinedDeterminant(lattice.structure, lattice.control_points,
                                              plan->boxes[place.box].span, at),
                  place.determinant, kRounding);
      if (place.state == FoldState::kFolded) {
        EXPECT_LE(place.determinant, 0);
      }
    }
  }
  std::cout << count << " lattices, " << boxes << " boxes: " << certified_lattices
            << " lattices certified, " << decided_lattices << " decided; " << folded
            << " boxes folded, " << undecided << " undecided, " << missed
            << " folded where all samples are above 0; " << double(cells) / double(boxes)
            << " cells a box, at most " << most_cells << "\n";
  EXPECT_LE(static_cast<double>(undecided), 1e-3 * static_cast<double>(boxes));
  EXPECT_GE(static_cast<double>(decided_lattices), 0.999 * count);
  EXPECT_GT(certified_lattices, count / 10);
  EXPECT_GT(folded, count);
}

}  // namespace
}  // namespace latticed
