// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/adaptive/patch_curvature.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "core/adaptive/composed_patch.h"
#include "core/adaptive/curvature_slack.h"

namespace latticed {
namespace {

constexpr uint32_t kCurvatureSeed = 11;

using Polynomials = std::array<PatchPolynomial<double>, 3>;

template <typename T, int kDegree = 2>
CurvatureBounds<T> BoundsOf(const std::array<PatchPolynomial<T>, 3>& p, T shear, int degree) {
  if constexpr (kDegree < kMostPatchDegree) {
    if (degree > kDegree) return BoundsOf<T, kDegree + 1>(p, shear, degree);
  }
  const T* component[3] = {p[0].value, p[1].value, p[2].value};
  return BoundCurvature<kDegree, T>(component, shear);
}

// d^2 P along two directions (dx, dt), at (x, t).
Vec3d SecondDerivative(const Polynomials& p, std::array<double, 2> at, std::array<double, 2> d1,
                       std::array<double, 2> d2) {
  Vec3d sum;
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i <= p[0].degree; ++i) {
      for (int j = 0; j <= p[0].degree - i; ++j) {
        const auto monomial = [&](int di, int dj) {
          double factor = 1;
          for (int k = 0; k < di; ++k) factor *= i - k;
          for (int k = 0; k < dj; ++k) factor *= j - k;
          return factor == 0 ? 0 : factor * std::pow(at[0], i - di) * std::pow(at[1], j - dj);
        };
        sum[c] +=
            p[static_cast<size_t>(c)].value[PatchTerm(i, j)] *
            (d1[0] * d2[0] * monomial(2, 0) + (d1[0] * d2[1] + d1[1] * d2[0]) * monomial(1, 1) +
             d1[1] * d2[1] * monomial(0, 2));
      }
    }
  }
  return sum;
}

// The largest norms at the points of a grid over the patch, corners included.
CurvatureBounds<double> Sampled(const Polynomials& p, double shear) {
  constexpr int kGrid = 12;
  const std::array<double, 2> corner[3] = {{-0.5, -0.5}, {0.5, -0.5}, {shear - 0.5, 0.5}};
  const auto side = [&](int from, int to) {
    return std::array{corner[to % 3][0] - corner[from % 3][0],
                      corner[to % 3][1] - corner[from % 3][1]};
  };
  CurvatureBounds<double> largest;
  for (int i = 0; i <= kGrid; ++i) {
    for (int j = 0; j <= kGrid - i; ++j) {
      const double b1 = double(i) / kGrid, b2 = double(j) / kGrid;
      const std::array at{b1 + shear * b2 - 0.5, b2 - 0.5};
      for (int e = 0; e < 3; ++e) {
        largest.edge[e] = std::max(largest.edge[e],
                                   Norm(SecondDerivative(p, at, side(e, e + 1), side(e, e + 1))));
        largest.mixed[e] = std::max(largest.mixed[e],
                                    Norm(SecondDerivative(p, at, side(e, e + 1), side(e, e + 2))));
      }
    }
  }
  return largest;
}

Polynomials RandomPolynomials(int degree, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Polynomials p;
  for (auto& component : p) {
    component.degree = degree;
    for (int k = 0; k < (degree + 1) * (degree + 2) / 2; ++k) component.value[k] = uniform(random);
  }
  return p;
}

TEST(PatchCurvature, SquareByHand) {
  Polynomials p;
  p[0].degree = 2;
  p[0].value[PatchTerm(2, 0)] = 3;   // 3 x^2
  p[1].value[PatchTerm(1, 1)] = 2;   // 2 x t
  p[2].value[PatchTerm(0, 2)] = -1;  // -t^2

  const auto bounds = BoundsOf(p, 0.25, 2);

  // Edges are (1, 0), (-0.75, 1) and (-0.25, -1) in (x, t); d^2 along (a, b) is (6 a^2, 4 a b, -2 b^2).
  EXPECT_DOUBLE_EQ(bounds.edge[0], 6);
  EXPECT_DOUBLE_EQ(bounds.edge[1], Norm({3.375, -3, -2}));
  EXPECT_DOUBLE_EQ(bounds.edge[2], Norm({0.375, 1, -2}));
  // Along (a, b) and (c, d) it is (6 a c, 2 (a d + b c), -2 b d).
  EXPECT_DOUBLE_EQ(bounds.mixed[0], Norm({1.5, 2, 0}));
  EXPECT_DOUBLE_EQ(bounds.mixed[1], Norm({4.5, -2, 0}));
  EXPECT_DOUBLE_EQ(bounds.mixed[2], Norm({-1.125, -1, -2}));
}

TEST(PatchCurvature, BoundsContainTheSampledDerivatives) {
  std::mt19937 random(kCurvatureSeed);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int degree = 2; degree <= kMostPatchDegree; ++degree) {
    for (int trial = 0; trial < 8; ++trial) {
      const Polynomials p = RandomPolynomials(degree, random);
      const double shear = trial == 0 ? 0 : trial == 1 ? 1 : uniform(random);

      const CurvatureBounds<double> bounds = BoundsOf(p, shear, degree);

      const CurvatureBounds<double> sampled = Sampled(p, shear);
      // Each norm is at least the largest at a corner, and a random polynomial of high degree is close to its hull.
      const double most = degree <= 3 ? 1.0 + 1e-12 : 3.0;
      for (int e = 0; e < 3; ++e) {
        EXPECT_GE(bounds.edge[e], sampled.edge[e] * (1 - 1e-12))
            << "degree " << degree << " seed " << kCurvatureSeed;
        EXPECT_GE(bounds.mixed[e], sampled.mixed[e] * (1 - 1e-12)) << "degree " << degree;
        EXPECT_LE(bounds.edge[e], sampled.edge[e] * most) << "degree " << degree << " edge " << e;
        EXPECT_LE(bounds.mixed[e], sampled.mixed[e] * most)
            << "degree " << degree << " corner " << e;
      }
    }
  }
}

TEST(PatchCurvature, APlanarPatchHasNone) {
  Polynomials p;
  p[0].degree = 9;
  for (size_t c = 0; c < 3; ++c) {
    p[c].value[PatchTerm(0, 0)] = 1e6;
    p[c].value[PatchTerm(1, 0)] = 7;
    p[c].value[PatchTerm(0, 1)] = -3;
  }

  const CurvatureBounds<double> bounds = BoundsOf(p, 0.3, 9);

  for (int e = 0; e < 3; ++e) {
    EXPECT_EQ(bounds.edge[e], 0);
    EXPECT_EQ(bounds.mixed[e], 0);
  }
}

// Counts what the docstring promises.
struct CountingOps {
  using V = double;
  static inline int operations = 0;
  static V Set(double value) { return value; }
  static V Add(V a, V b) { return ++operations, a + b; }
  static V Sub(V a, V b) { return ++operations, a - b; }
  static V Mul(V a, V b) { return ++operations, a * b; }
  static V MulAdd(V a, V b, V c) { return ++operations, a * b + c; }
  static V Max(V a, V b) { return ++operations, a > b ? a : b; }
};

template <int kDegree>
int CountOperations() {
  const double p[PatchPolynomial<double>::kMostTerms] = {};
  const double* component[3] = {p, p, p};
  double edge[3], mixed[3];
  CountingOps::operations = 0;
  PatchCurvature<kDegree, CountingOps>::SquaredBounds(component, 0.5, edge, mixed);
  return CountingOps::operations;
}

TEST(PatchCurvature, CostsAreThoseOfItsDocstring) {
  EXPECT_EQ((std::array{CountOperations<3>(), CountOperations<4>(), CountOperations<5>(),
                        CountOperations<6>(), CountOperations<7>(), CountOperations<8>(),
                        CountOperations<9>()}),
            (std::array{212, 470, 890, 1'463, 2'252, 3'248, 4'514}));
}

// A patch in a box, as the fused pipeline has it: its first edge, and the perpendicular to corner 2.
struct RandomPatch {
  Vec3d centre, along, across;
  double shear;
};
RandomPatch DrawPatch(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  const auto point = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
  // From patches that fill the box to tiny ones; every third is a sliver.
  const double size = std::exp2(-14 * (0.5 + uniform(random)));
  const Vec3d origin = (1 - size) * point();
  std::array<Vec3d, 3> v{origin + size * point(), origin + size * point(), origin + size * point()};
  if (random() % 3 == 0)
    v[2] = v[0] + (0.5 + uniform(random)) * (v[1] - v[0]) + 1e-5 * size * point();
  while (Norm(v[1] - v[0]) < Norm(v[2] - v[1]) || Norm(v[1] - v[0]) < Norm(v[0] - v[2]))
    v = {v[1], v[2], v[0]};
  RandomPatch patch{.along = v[1] - v[0]};
  patch.shear = Dot(v[2] - v[0], patch.along) / Dot(patch.along, patch.along);
  patch.across = v[2] - v[0] - patch.shear * patch.along;
  patch.centre = v[0] + 0.5 * patch.along + 0.5 * patch.across;
  return patch;
}

template <typename T>
CurvatureBounds<T> ComposeAndBound(const std::vector<Vec3d>& coefficients,
                                   const std::array<int, 3>& degree, const RandomPatch& patch) {
  T map[3][3];
  for (int a = 0; a < 3; ++a) {
    map[a][0] = static_cast<T>(patch.centre[a]);
    map[a][1] = static_cast<T>(patch.along[a]);
    map[a][2] = static_cast<T>(patch.across[a]);
  }
  std::array<PatchPolynomial<T>, 3> p;
  for (int component = 0; component < 3; ++component) {
    std::vector<T> c;
    for (const Vec3d& v : coefficients) c.push_back(static_cast<T>(v[component]));
    p[static_cast<size_t>(component)] = ComposePatch(c.data(), degree, map);
  }
  return BoundsOf(p, static_cast<T>(patch.shear), degree[0] + degree[1] + degree[2]);
}

TEST(CurvatureSlack, RaisedFloatBoundsAreNeverBelowExactOnes) {
  constexpr int kPatches = 3'000;
  std::mt19937 random(kCurvatureSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  double worst_shortfall = 0, largest_slack = 0;
  for (int trial = 0; trial < kPatches; ++trial) {
    std::array<int, 3> degree{1 + trial % 3, 1 + trial / 3 % 3, 1 + trial / 9 % 3};
    const double falloff = std::exp2(-4 * std::abs(uniform(random)));
    std::vector<Vec3d> coefficients;
    for (int a = 0; a <= degree[0]; ++a) {
      for (int b = 0; b <= degree[1]; ++b) {
        for (int c = 0; c <= degree[2]; ++c) {
          const double scale = a + b + c < 2 ? 100 : std::pow(falloff, a + b + c - 2);
          coefficients.push_back(scale * Vec3d{uniform(random), uniform(random), uniform(random)});
        }
      }
    }
    const RandomPatch patch = DrawPatch(random);

    CurvatureBounds<float> raised = ComposeAndBound<float>(coefficients, degree, patch);
    const CurvatureBounds<float> computed = raised;
    const auto slack =
        CurvatureSlack(coefficients, degree, PatchReach(patch.centre, patch.along, patch.across));
    float v[3], slack_f[6];
    for (int a = 0; a < 3; ++a)
      v[a] = static_cast<float>(2 * std::abs(patch.along[a]) + std::abs(patch.across[a]));
    for (size_t k = 0; k < 6; ++k) slack_f[k] = static_cast<float>(slack[k]);
    const float patch_slack = PatchSlack(v, slack_f);
    RaiseBounds(patch_slack, &raised);

    const CurvatureBounds<double> exact = ComposeAndBound<double>(coefficients, degree, patch);
    for (int e = 0; e < 3; ++e) {
      ASSERT_GE(double{raised.edge[e]}, exact.edge[e])
          << "trial " << trial << " seed " << kCurvatureSeed;
      ASSERT_GE(double{raised.mixed[e]}, exact.mixed[e]) << "trial " << trial;
      worst_shortfall = std::max(worst_shortfall,
                                 (exact.edge[e] - double{computed.edge[e]}) / double{patch_slack});
    }
    largest_slack = std::max(largest_slack, double{patch_slack} / exact.edge[0]);
  }
  // The slack is needed: without it, bounds are too small. It is not much.
  EXPECT_GT(worst_shortfall, 1e-4);
  EXPECT_LT(worst_shortfall, 0.05);
  EXPECT_LT(largest_slack, 5e-3);
}

}  // namespace
}  // namespace latticed
