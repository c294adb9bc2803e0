// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/enclosed_volume.h"

#include <cstring>

#include "core/base/limits.h"

namespace latticed {
namespace {

constexpr size_t kMostSide = limits::kMaxDegree + 1;
constexpr size_t kMostTerms = kMostSide * kMostSide * kMostSide;
// Terms of the cross products, and of what is summed with the moments: powers up to 2 n on each axis.
constexpr size_t kMostDouble = (2 * limits::kMaxDegree + 1) * (2 * limits::kMaxDegree + 1) *
                               (2 * limits::kMaxDegree + 1);
constexpr size_t kPowers = 4;  // summed side by side

using Sides = std::array<size_t, 3>;  // number of powers on each axis

size_t Term(const Sides& sides, size_t p, size_t q, size_t r) {
  return (p * sides[1] + q) * sides[2] + r;
}

// A box of control points and its polynomial.
class BoxMeasure {
 public:
  BoxMeasure(const SurfaceMoments& moments, size_t n, std::span<const Vec3d> control_points,
             Vec3d origin)
      : moments_(moments), n_(n), box_(moments.boxes()[n]) {
    const LatticeStructure& s = moments.plan().structure;
    for (size_t a = 0; a < 3; ++a) {
      sides_[a] = static_cast<size_t>(s.degree[a]) + 1;
      twice_[a] = 2 * sides_[a] - 1;
      first_[a] = moments.plan().boxes[box_].span[a] - s.degree[a];
      basis_[a] = &moments.basis(box_, a);
    }
    SetPolynomial(control_points, origin);
    SetCrossProducts();
  }

  // sums[k][c] = integral of l^c (n dA)_k for the powers c below `count` on each axis.
  void Integrate(const Sides& count, double (*sums)[kMostDouble]) const {
    const Sides& extent = moments_.extent();
    for (size_t p = 0; p < count[0]; ++p) {
      for (size_t q = 0; q < count[1]; ++q) {
        for (size_t r = 0; r < count[2]; r += kPowers) {
          double sum[3][kPowers] = {};
          for (size_t d = 0; d < 3; ++d) {
            const double* table = moments_.table(n_, d) + Term(extent, p, q, r);
            const Sides have{twice_[0] - (d != 0), twice_[1] - (d != 1), twice_[2] - (d != 2)};
            for (size_t a = 0; a < have[0]; ++a) {
              for (size_t b = 0; b < have[1]; ++b) {
                const double* moment = table + Term(extent, a, b, 0);
                const size_t row = Term(twice_, a, b, 0);
                for (size_t c = 0; c < have[2]; ++c) {
                  for (size_t k = 0; k < 3; ++k) {
                    for (size_t i = 0; i < kPowers; ++i) {
                      sum[k][i] += cross_[d][k][row + c] * moment[c + i];
                    }
                  }
                }
              }
            }
          }
          for (size_t i = 0; i < kPowers && r + i < count[2]; ++i) {
            for (size_t k = 0; k < 3; ++k) sums[k][Term(count, p, q, r + i)] = sum[k][i];
          }
        }
      }
    }
  }

  // sums[k][c] of the powers that a basis function has, times component j of the polynomial.
  void Multiply(size_t j, const double (*sums)[kMostDouble], double (*products)[kMostTerms]) const {
    for (size_t k = 0; k < 3; ++k) {
      for (size_t p = 0; p < sides_[0]; ++p) {
        for (size_t q = 0; q < sides_[1]; ++q) {
          for (size_t r = 0; r < sides_[2]; ++r) {
            double sum = 0;
            for (size_t a = 0; a < sides_[0]; ++a) {
              for (size_t b = 0; b < sides_[1]; ++b) {
                for (size_t c = 0; c < sides_[2]; ++c) {
                  sum += polynomial_[j][Term(sides_, a, b, c)] *
                         sums[k][Term(twice_, p + a, q + b, r + c)];
                }
              }
            }
            products[k][Term(sides_, p, q, r)] = sum;
          }
        }
      }
    }
  }

  // Adds integral of N_i (n dA)_k, from that of the powers, to component k of add(i) for each control point i.
  template <typename Add>
  void AddToPoints(const double* const (&powers)[3], const Add& add) const {
    const LatticeStructure& s = moments_.plan().structure;
    const SpanBasis &u = *basis_[0], &v = *basis_[1], &w = *basis_[2];
    for (size_t i = 0; i < sides_[0]; ++i) {
      Vec3d plane[kMostSide][kMostSide];
      for (size_t a = 0; a < sides_[0]; ++a) {
        for (size_t b = 0; b < sides_[1]; ++b) {
          for (size_t c = 0; c < sides_[2]; ++c) {
            const size_t at = Term(sides_, a, b, c);
            plane[b][c] += u[i][a] * Vec3d{powers[0][at], powers[1][at], powers[2][at]};
          }
        }
      }
      for (size_t j = 0; j < sides_[1]; ++j) {
        Vec3d line[kMostSide];
        for (size_t b = 0; b < sides_[1]; ++b) {
          for (size_t c = 0; c < sides_[2]; ++c) line[c] += v[j][b] * plane[b][c];
        }
        for (size_t k = 0; k < sides_[2]; ++k) {
          Vec3d sum;
          for (size_t c = 0; c < sides_[2]; ++c) sum += w[k][c] * line[c];
          add(static_cast<size_t>(s.Index(first_[0] + static_cast<int>(i),
                                          first_[1] + static_cast<int>(j),
                                          first_[2] + static_cast<int>(k)))) += sum;
        }
      }
    }
  }

  const Sides& sides() const { return sides_; }
  const Sides& twice() const { return twice_; }

 private:
  void SetPolynomial(std::span<const Vec3d> control_points, Vec3d origin) {
    const LatticeStructure& s = moments_.plan().structure;
    const SpanBasis &u = *basis_[0], &v = *basis_[1], &w = *basis_[2];
    for (size_t i = 0; i < sides_[0]; ++i) {
      Vec3d plane[kMostSide][kMostSide];
      for (size_t j = 0; j < sides_[1]; ++j) {
        Vec3d line[kMostSide];
        for (size_t k = 0; k < sides_[2]; ++k) {
          const Vec3d p = control_points[static_cast<size_t>(s.Index(
                              first_[0] + static_cast<int>(i), first_[1] + static_cast<int>(j),
                              first_[2] + static_cast<int>(k)))] -
                          origin;
          for (size_t c = 0; c < sides_[2]; ++c) line[c] += w[k][c] * p;
        }
        for (size_t b = 0; b < sides_[1]; ++b) {
          for (size_t c = 0; c < sides_[2]; ++c) plane[b][c] += v[j][b] * line[c];
        }
      }
      for (size_t a = 0; a < sides_[0]; ++a) {
        for (size_t b = 0; b < sides_[1]; ++b) {
          for (size_t c = 0; c < sides_[2]; ++c) {
            const Vec3d term = u[i][a] * plane[b][c];
            for (size_t k = 0; k < 3; ++k) {
              polynomial_[k][Term(sides_, a, b, c)] += term[static_cast<int>(k)];
            }
          }
        }
      }
    }
  }

  void SetCrossProducts() {
    double slope[3][3][kMostTerms] = {};  // [component][axis]
    for (size_t k = 0; k < 3; ++k) {
      for (size_t a = 0; a < sides_[0]; ++a) {
        for (size_t b = 0; b < sides_[1]; ++b) {
          for (size_t c = 0; c < sides_[2]; ++c) {
            const double term = polynomial_[k][Term(sides_, a, b, c)];
            if (a > 0) slope[k][0][Term(sides_, a - 1, b, c)] = static_cast<double>(a) * term;
            if (b > 0) slope[k][1][Term(sides_, a, b - 1, c)] = static_cast<double>(b) * term;
            if (c > 0) slope[k][2][Term(sides_, a, b, c - 1)] = static_cast<double>(c) * term;
          }
        }
      }
    }
    for (size_t d = 0; d < 3; ++d) {
      const size_t e = (d + 1) % 3, f = (d + 2) % 3;
      for (size_t k = 0; k < 3; ++k) {
        const auto &y = slope[(k + 1) % 3], &z = slope[(k + 2) % 3];
        AddProduct(y[e], e, z[f], f, 1, cross_[d][k]);
        AddProduct(y[f], f, z[e], e, -1, cross_[d][k]);
      }
    }
  }

  // A factor is a derivative by one axis, where it has one power less.
  void AddProduct(const double* x, size_t x_axis, const double* y, size_t y_axis, double sign,
                  double* product) const {
    const Sides m{sides_[0] - (x_axis == 0), sides_[1] - (x_axis == 1), sides_[2] - (x_axis == 2)};
    const Sides n{sides_[0] - (y_axis == 0), sides_[1] - (y_axis == 1), sides_[2] - (y_axis == 2)};
    for (size_t a = 0; a < m[0]; ++a) {
      for (size_t b = 0; b < m[1]; ++b) {
        for (size_t c = 0; c < m[2]; ++c) {
          const double factor = sign * x[Term(sides_, a, b, c)];
          for (size_t p = 0; p < n[0]; ++p) {
            for (size_t q = 0; q < n[1]; ++q) {
              const double* from = y + Term(sides_, p, q, 0);
              double* to = product + Term(twice_, a + p, b + q, c);
              for (size_t r = 0; r < n[2]; ++r) to[r] += factor * from[r];
            }
          }
        }
      }
    }
  }

  const SurfaceMoments& moments_;
  const size_t n_;
  const uint32_t box_;
  Sides sides_{}, twice_{};
  std::array<int, 3> first_{};
  std::array<const SpanBasis*, 3> basis_{};
  double polynomial_[3][kMostTerms] = {};
  double cross_[3][3][kMostDouble] = {};  // [axis of the area element][component]
};

// The sums lose the fewest digits about a point near the surface. Where pieces lie outside the frame, their sums have the
// plan's origin.
Vec3d OriginFor(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  if (plan.outside_patches > 0) return plan.local_origin;
  const Vec3d first = control_points.front();
  Vec3d sum;
  for (const Vec3d p : control_points) sum += p - first;
  return first + sum / static_cast<double>(control_points.size());
}

// 1/3 integral x . n dA, from the gradient.
double VolumeOf(const SurfaceMoments& moments, std::span<const Vec3d> control_points, Vec3d origin,
                std::span<const Vec3d> gradient) {
  double sum = moments.outside_volume();
  for (size_t i = 0; i < gradient.size(); ++i) sum += Dot(control_points[i] - origin, gradient[i]);
  return sum / 3;
}

}  // namespace

EnclosedVolume MeasureVolume(const SurfaceMoments& moments, std::span<const Vec3d> control_points) {
  EnclosedVolume result{.gradient = std::vector<Vec3d>(control_points.size())};
  const Vec3d origin = OriginFor(moments.plan(), control_points);
  double sums[3][kMostDouble];
  for (size_t n = 0; n < moments.boxes().size(); ++n) {
    const BoxMeasure box(moments, n, control_points, origin);
    box.Integrate(box.sides(), sums);
    box.AddToPoints({sums[0], sums[1], sums[2]},
                    [&](size_t i) -> Vec3d& { return result.gradient[i]; });
  }
  result.volume = VolumeOf(moments, control_points, origin, result.gradient);
  return result;
}

EnclosedCentroid MeasureCentroid(const SurfaceMoments& moments,
                                 std::span<const Vec3d> control_points) {
  const size_t count = control_points.size();
  EnclosedCentroid result{.volume = {.gradient = std::vector<Vec3d>(count)}};
  std::vector<std::array<Vec3d, 3>> first(count);  // [j][k] = dS_j / d coordinate k
  const Vec3d origin = OriginFor(moments.plan(), control_points);
  double sums[3][kMostDouble], lower[3][kMostTerms], products[3][kMostTerms];
  for (size_t n = 0; n < moments.boxes().size(); ++n) {
    const BoxMeasure box(moments, n, control_points, origin);
    box.Integrate(box.twice(), sums);
    for (size_t k = 0; k < 3; ++k) {
      for (size_t a = 0; a < box.sides()[0]; ++a) {
        for (size_t b = 0; b < box.sides()[1]; ++b) {
          std::memcpy(&lower[k][Term(box.sides(), a, b, 0)], &sums[k][Term(box.twice(), a, b, 0)],
                      box.sides()[2] * sizeof(double));
        }
      }
    }
    box.AddToPoints({lower[0], lower[1], lower[2]},
                    [&](size_t i) -> Vec3d& { return result.volume.gradient[i]; });
    for (size_t j = 0; j < 3; ++j) {
      box.Multiply(j, sums, products);
      box.AddToPoints({products[0], products[1], products[2]},
                      [&](size_t i) -> Vec3d& { return first[i][j]; });
    }
  }
  const double volume = VolumeOf(moments, control_points, origin, result.volume.gradient);
  result.volume.volume = volume;
  Vec3d moment = moments.outside_centroid();
  for (size_t i = 0; i < count; ++i) {
    for (int j = 0; j < 3; ++j) {
      moment[j] += Dot(control_points[i] - origin, first[i][static_cast<size_t>(j)]);
    }
  }
  const Vec3d centroid = moment / (4 * volume);  // relative to the origin
  result.centroid = origin + centroid;
  result.gradient.resize(count);
  for (size_t i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 3; ++j) {
        result.gradient[i][static_cast<size_t>(k)][j] =
            (first[i][static_cast<size_t>(j)][k] - centroid[j] * result.volume.gradient[i][k]) /
            volume;
      }
    }
  }
  return result;
}

}  // namespace latticed
