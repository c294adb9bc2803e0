// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/weighted_volume.h"

#include "core/ffd/box/box_contraction.h"
#include "core/measure/box_integral_kernel.h"

namespace latticed {
namespace {

using box_integral::CrossProducts;
using box_integral::ForTerms;
using box_integral::Narrow;
using box_integral::NarrowTerm;
using box_integral::Powers;
using box_integral::Wide;
using box_integral::WideTerm;

constexpr size_t kFamilies = SurfaceMoments::kWeightedFamilies;

class WeightedBoxMeasure {
 public:
  // `offsets`: where control points are, relative to where they leave the mesh as it is.
  WeightedBoxMeasure(const SurfaceMoments& moments, size_t n, std::span<const Vec3d> offsets)
      : moments_(moments), n_(n), contraction_(moments.contraction(n)) {
    const LatticeStructure& s = moments.plan().structure;
    const KnotBox& box = moments.plan().boxes[moments.boxes()[n]];
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<size_t>(a);
      degree_[axis] = static_cast<size_t>(s.degree[axis]);
      const double part = (box.upper[a] - box.lower[a]) / (s.domain_end(a) - s.domain_begin(a));
      rest_slope_[axis] = part * s.frame.edges[axis];
    }
    const BoxNumbers numbers = contraction_.Contract(offsets, {});
    ForTerms(degree_, [&](size_t a, size_t b, size_t c) {
      for (size_t k = 0; k < 3; ++k) offset_[k][NarrowTerm(a, b, c)] = numbers.at[a][b][c][k];
    });
  }

  // Returns integral w G . n dA, each term over its degree in G; adds the derivatives of V to add(i).
  template <typename Add>
  double Integrate(const Add& add) const {
    constexpr std::array<double, kFamilies> kDegrees = {1, 2, 3, 2, 3};
    double volume = 0;
    BoxNumbers total;
    std::array<Wide, 3> sums;
    for (size_t family = 0; family < kFamilies; ++family) {
      CrossProducts products{};
      const Powers powers = Multiply(family, products);
      box_integral::SumMoments(products, powers,
                               {{moments_.table(n_, 0, family), moments_.table(n_, 1, family),
                                 moments_.table(n_, 2, family)},
                                moments_.extent()},
                               {degree_[0] + 1, degree_[1] + 1, degree_[2] + 1}, sums);
      double across = 0;
      ForTerms(degree_, [&](size_t a, size_t b, size_t c) {
        for (size_t k = 0; k < 3; ++k) {
          const double sum = sums[k][WideTerm(a, b, c)];
          total.at[a][b][c][k] += sum;
          across += offset_[k][NarrowTerm(a, b, c)] * sum;
        }
      });
      volume += across / kDegrees[family];
    }
    contraction_.AddTransposed(total, add);
    return volume;
  }

 private:
  // What is multiplied by the moments of a family.
  Powers Multiply(size_t family, CrossProducts& products) const {
    Powers powers;
    for (auto& axes : powers) axes = {degree_[0] + 1, degree_[1] + 1, degree_[2] + 1};
    switch (family) {
      case 0:
        for (auto& axes : powers) axes = {1, 1, 1};
        ForComponents([&](size_t d, size_t k) {
          products[d][k][0] = Cross(RestSlope(d + 1), RestSlope(d + 2))[static_cast<int>(k)];
        });
        break;
      case 1:
        MultiplyRestSlopes(products);
        break;
      case 2:
        box_integral::MultiplySlopes(offset_, degree_, products);
        return box_integral::CrossPowers(degree_);
      case 3:
        ForComponents([&](size_t d, size_t k) {
          const size_t y = (k + 1) % 3, z = (k + 2) % 3;
          ForTerms(degree_, [&](size_t a, size_t b, size_t c) {
            const size_t term = NarrowTerm(a, b, c);
            products[d][k][WideTerm(a, b, c)] =
                RestSlope(d, y) * offset_[z][term] - RestSlope(d, z) * offset_[y][term];
          });
        });
        break;
      default:
        box_integral::MultiplyOffsets(offset_, degree_, products);
        for (size_t d = 0; d < 3; ++d) {
          for (size_t a = 0; a < 3; ++a) powers[d][a] = 2 * degree_[a] + (d == a ? 0 : 1);
        }
    }
    return powers;
  }

  // x_{d+1} x G_{d+2} + G_{d+1} x x_{d+2}
  void MultiplyRestSlopes(CrossProducts& products) const {
    ForComponents([&](size_t d, size_t k) {
      const size_t e = (d + 1) % 3, g = (d + 2) % 3, y = (k + 1) % 3, z = (k + 2) % 3;
      Wide& product = products[d][k];
      ForTerms(degree_, [&](size_t a, size_t b, size_t c) {
        const std::array<size_t, 3> power = {a, b, c};
        const double of_y = offset_[y][NarrowTerm(a, b, c)], of_z = offset_[z][NarrowTerm(a, b, c)];
        const auto add = [&](size_t axis, double value) {
          if (power[axis] == 0) return;
          std::array<size_t, 3> p = power;
          --p[axis];
          product[WideTerm(p[0], p[1], p[2])] += static_cast<double>(power[axis]) * value;
        };
        add(g, RestSlope(e, y) * of_z - RestSlope(e, z) * of_y);
        add(e, RestSlope(g, z) * of_y - RestSlope(g, y) * of_z);
      });
    });
  }

  template <typename Body>
  static void ForComponents(const Body& body) {
    for (size_t d = 0; d < 3; ++d) {
      for (size_t k = 0; k < 3; ++k) body(d, k);
    }
  }
  Vec3d RestSlope(size_t axis) const { return rest_slope_[axis % 3]; }
  double RestSlope(size_t axis, size_t k) const { return rest_slope_[axis][static_cast<int>(k)]; }

  const SurfaceMoments& moments_;
  const size_t n_;
  const BoxContraction contraction_;
  std::array<size_t, 3> degree_{};
  std::array<Vec3d, 3> rest_slope_;  // x_a
  std::array<Narrow, 3> offset_{};   // G
};

}  // namespace

EnclosedVolume MeasureWeightedVolume(const SurfaceMoments& moments,
                                     std::span<const Vec3d> control_points) {
  EnclosedVolume result{.volume = moments.rest_volume(),
                        .gradient = std::vector<Vec3d>(control_points.size())};
  std::vector<Vec3d> offsets(control_points.begin(), control_points.end());
  for (size_t i = 0; i < offsets.size(); ++i) offsets[i] -= moments.plan().identity_points[i];
  for (size_t n = 0; n < moments.boxes().size(); ++n) {
    const WeightedBoxMeasure box(moments, n, offsets);
    result.volume += box.Integrate([&](size_t i) -> Vec3d& { return result.gradient[i]; });
  }
  return result;
}

}  // namespace latticed
