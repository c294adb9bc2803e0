// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/jacobian_form.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/ffd/direct_ffd.h"
#include "core/folds/volume_lattice.h"
#include "tests/core/folds/turned_fold_fixtures.h"

namespace latticed {
namespace {

constexpr uint32_t kFormSeed = 73;

using testing::DrawTurned;
using testing::JitterAll;
using testing::TurnedFolds;

class Draws {
 public:
  explicit Draws(uint32_t seed) : random_(seed) {}
  double Number(double most) {
    return std::uniform_real_distribution<double>(-most, most)(random_);
  }
  Vec3d Vector(double most) { return {Number(most), Number(most), Number(most)}; }
  // Near a rotation of twice its size, with everything else of the size `step`.
  JacobianForm Form(double step) {
    JacobianForm form{.centre = {Vec3d{1.2, 1.6, 0}, {-1.6, 1.2, 0}, {0, 0, 2}}};
    for (size_t l = 0; l < 3; ++l) {
      form.centre[l] += Vector(0.4);
      for (size_t k = 0; k < 3; ++k) {
        form.slope[l][k] = Vector(step);
        form.bend[l][k] = {std::abs(Number(step)) / 8, 0, std::abs(Number(step)) / 8};
      }
    }
    return form;
  }
  // det of a matrix within the form at t.
  double Determinant(const JacobianForm& form, Vec3d t) {
    std::array<Vec3d, 3> f = form.centre;
    for (size_t l = 0; l < 3; ++l) {
      for (size_t k = 0; k < 3; ++k) {
        f[l] += t[static_cast<int>(k)] * form.slope[l][k];
        const Vec3d bend = form.bend[l][k], share = Vector(1);
        f[l] += Vec3d{share.x * bend.x, share.y * bend.y, share.z * bend.z};
      }
    }
    return Dot(f[0], Cross(f[1], f[2]));
  }

 private:
  std::mt19937 random_;
};

// The bound is below all values, and near the least one in a small cell.
// det is -(1 + t)^2, whose square counts against the bound although the linear part is above 0 beside the plane.
TEST(JacobianForm, MirroredPartsAreNotCertifiedBesideAPlane) {
  JacobianForm form{.centre = {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}};
  form.slope[0][0] = {1, 0, 0};
  form.slope[1][0] = {0, 1, 0};
  const CellPlane plane{.normal = {1, 0, 0}, .bound = -0.9};
  EXPECT_LE(BoundDeterminant(form, 1, {&plane, 1}).least, -0.01);
}

TEST(JacobianForm, TheBoundIsBelowAllValuesInsideThePlanes) {
  Draws draw(kFormSeed);
  uint32_t inside = 0;
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE(::testing::Message() << "form " << i << ", seed " << kFormSeed);
    const double step = std::ldexp(1.0, -(i % 8));
    const JacobianForm form = draw.Form(step);
    std::vector<CellPlane> planes;
    for (int p = 0; p < i % 3; ++p) planes.push_back({draw.Vector(1), draw.Number(1)});
    const double rest = i % 2 == 0 ? 2 : -2;

    const DeterminantBound bound = BoundDeterminant(form, rest, planes);

    double least = std::numeric_limits<double>::infinity();
    for (int sample = 0; sample < 200; ++sample) {
      Vec3d t = draw.Vector(1);
      if (sample < 60) t = {std::copysign(1, t.x), std::copysign(1, t.y), std::copysign(1, t.z)};
      if (std::ranges::any_of(
              planes, [&](const CellPlane& plane) { return Dot(plane.normal, t) > plane.bound; })) {
        continue;
      }
      ++inside;
      least = std::min(least, draw.Determinant(form, t) / rest);
    }
    ASSERT_LE(bound.least, least);
    if (planes.empty() && step < 0.01) {
      EXPECT_GT(bound.least, least - 40 * step * step - 10 * step);
    }
  }
  EXPECT_GT(inside, 100'000u);
}

TEST(JacobianForm, AnExactFormHasItsDeterminant) {
  JacobianForm form{.centre = {Vec3d{0, 3, 0}, {-2, 0, 0}, {0, 0, 0.5}}};
  EXPECT_NEAR(BoundDeterminant(form, 1, {}).least, 3, 1e-10);
  EXPECT_NEAR(BoundDeterminant(form, -1, {}).least, -3, 1e-10);
  form.slope[2][1] = {0, 0, 0.25};  // along t_1 the determinant is 3 + 1.5 t_1
  EXPECT_NEAR(BoundDeterminant(form, 1, {}).least, 1.5, 1e-10);
  // Of the part with t_0 - t_1 <= -1, only its corner t_0 = -1, t_1 = 0 is that low.
  const std::vector<CellPlane> planes{{{1, -1, 0}, -1}};
  const DeterminantBound part = BoundDeterminant(form, 1, planes);
  EXPECT_NEAR(part.least, 3, 1e-10);
  EXPECT_NEAR(part.place.y, 0, 1e-15);
}

TEST(JacobianForm, APartWithoutPointsHasNoLeastValue) {
  const JacobianForm form{.centre = {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  EXPECT_EQ(BoundDeterminant(form, 1, std::vector<CellPlane>{{{1, 1, 0}, -2.5}}).least,
            std::numeric_limits<double>::infinity());
  EXPECT_NEAR(BoundDeterminant(form, 1, std::vector<CellPlane>{{{1, 1, 0}, -1.5}}).least, 1, 1e-10);
}

TEST(JacobianForm, NumbersThatOverflowProveNothing) {
  const JacobianForm form{.centre = {Vec3d{1e200, 0, 0}, {0, 1e200, 0}, {0, 0, 1}}};
  EXPECT_TRUE(std::isnan(BoundDeterminant(form, 1, {}).least));
  EXPECT_FALSE(BoundDeterminant({}, 1, {}).least > 0);  // flat
}

// What a lattice adds in a random cell, by the definition, is in one of the pieces that hold the point.
TEST(VolumeLattice, PiecesHoldTheDefinition) {
  Draws draw(kFormSeed);
  uint32_t inside = 0, beyond = 0;
  for (uint32_t mix = 0; mix < 27; ++mix) {
    const TurnedFolds scene = DrawTurned(mix, false);
    const auto points = JitterAll(scene, 0.2, kFormSeed + mix);
    const LatticeStructure& s = scene.structures[1];
    const size_t first = scene.plan->turned[0].first_point;
    const std::span own = std::span<const Vec3d>(points).subspan(first);
    const VolumeLattice lattice(s, own, std::span(scene.plan->identity_points).subspan(first));
    for (int i = 0; i < 40; ++i) {
      SCOPED_TRACE(::testing::Message()
                   << "mix " << mix << ", cell " << i << ", seed " << kFormSeed);
      const double size = std::ldexp(1.0, -i % 6);
      const Vec3d middle =
          s.frame.origin + 0.5 * (s.frame.edges[0] + s.frame.edges[1] + s.frame.edges[2]);
      WorldCell cell{.centre = middle + draw.Vector(1.2), .size = {2, 2, 2}};
      for (Vec3d& half : cell.half) half = draw.Vector(0.5 * size);
      std::vector<VolumePiece> pieces;
      const VolumeLattice::View view = lattice.Look(cell);
      lattice.AddPieces(cell, view, pieces);
      for (int sample = 0; sample < 50; ++sample) {
        const Vec3d t = draw.Vector(1);
        const Vec3d world =
            cell.centre + t.x * cell.half[0] + t.y * cell.half[1] + t.z * cell.half[2];
        const DeformedPoint point = EvaluateWorld(s, own, world);
        (point.inside ? inside : beyond) += 1;
        const auto holds = [&](const VolumePiece& piece) {
          for (size_t p = 0; p < piece.plane_count; ++p) {
            if (Dot(piece.planes[p].normal, t) > piece.planes[p].bound) return false;
          }
          for (size_t l = 0; l < 3; ++l) {
            const Vec3d e = cell.half[l];
            Vec3d rest = e.x * point.jacobian[0] + e.y * point.jacobian[1] +
                         e.z * point.jacobian[2] - e - piece.form.centre[l];
            Vec3d radius{1e-12, 1e-12, 1e-12};
            for (size_t k = 0; k < 3; ++k) {
              rest -= t[static_cast<int>(k)] * piece.form.slope[l][k];
              radius += piece.form.bend[l][k];
            }
            for (const int c : {0, 1, 2}) {
              if (std::abs(rest[c]) > radius[c]) return false;
            }
          }
          return true;
        };
        ASSERT_TRUE(std::ranges::any_of(pieces, holds) || (pieces.empty() && !point.inside));
      }
    }
  }
  EXPECT_GT(inside, 3000u);
  EXPECT_GT(beyond, 3000u);
}

}  // namespace
}  // namespace latticed
