// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/weighted_determinant.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace latticed {
namespace {

constexpr double kWeightedSlack = 6 * 2500 * 0x1p-53;
constexpr size_t kMostSum = BernsteinTriangle::kMostDegree;
constexpr size_t kSide = limits::kMaxDegree + 1;
constexpr size_t kAxisTerms = kSide * (kSide + 1) / 2;

constexpr auto kFactorials = [] {
  std::array<double, kMostSum + 1> result{1};
  for (size_t k = 1; k <= kMostSum; ++k) result[k] = result[k - 1] * static_cast<double>(k);
  return result;
}();

double Multinomial(size_t i, size_t j, size_t k) {
  return kFactorials[i + j + k] / (kFactorials[i] * kFactorials[j] * kFactorials[k]);
}

// Coefficients of b0^i b1^j b2^k: those of Bernstein times the multinomial. Products are then plain.
class Form {
 public:
  explicit Form(size_t degree) : degree_(degree), terms_((degree + 1) * (degree + 1)) {}
  size_t degree() const { return degree_; }
  double& at(size_t i, size_t j) { return terms_[i * (degree_ + 1) + j]; }
  double at(size_t i, size_t j) const { return terms_[i * (degree_ + 1) + j]; }

  // this += sign a b
  void AddProduct(const Form& a, const Form& b, double sign) {
    for (size_t i = 0; i <= a.degree_; ++i) {
      for (size_t j = 0; i + j <= a.degree_; ++j) {
        const double factor = sign * a.at(i, j);
        for (size_t p = 0; p <= b.degree_; ++p) {
          for (size_t q = 0; p + q <= b.degree_; ++q) at(i + p, j + q) += factor * b.at(p, q);
        }
      }
    }
  }

 private:
  size_t degree_;
  std::vector<double> terms_;
};
using VectorForm = std::array<Form, 3>;
VectorForm MakeVectorForm(size_t degree) { return {Form(degree), Form(degree), Form(degree)}; }

// Of one axis of degree d: for each i + j + k = d, the weights of the Bernstein coefficients in the polar form, times the
// multinomial.
struct AxisTerm {
  size_t i = 0, j = 0;
  std::array<double, kSide> weight{};
};
struct AxisTerms {
  size_t count = 0;
  std::array<AxisTerm, kAxisTerms> term;
};
// `at`: the coordinates of the corners in the box, 0 to 1.
AxisTerms TermsOf(size_t degree, const std::array<double, 3>& at) {
  AxisTerms terms;
  for (size_t i = 0; i <= degree; ++i) {
    for (size_t j = 0; i + j <= degree; ++j) {
      AxisTerm& term = terms.term[terms.count++];
      const std::array<size_t, 3> power{i, j, degree - i - j};
      term.i = i;
      term.j = j;
      term.weight[0] = Multinomial(power[0], power[1], power[2]);
      // The product of (1 - t) + t z over all arguments t.
      for (size_t c = 0; c < 3; ++c) {
        for (size_t factor = 0; factor < power[c]; ++factor) {
          for (size_t k = degree; k > 0; --k) {
            term.weight[k] = (1 - at[c]) * term.weight[k] + at[c] * term.weight[k - 1];
          }
          term.weight[0] *= 1 - at[c];
        }
      }
    }
  }
  return terms;
}

// The polynomial of a box on the triangle with these corners: [axis][corner] in the box.
VectorForm Compose(const BezierBox& box, const std::array<std::array<double, 3>, 3>& corners) {
  std::array<size_t, 3> degree;
  std::array<AxisTerms, 3> terms;
  for (size_t a = 0; a < 3; ++a) {
    degree[a] = static_cast<size_t>(box.degree[a]);
    terms[a] = TermsOf(degree[a], corners[a]);
  }
  VectorForm result = MakeVectorForm(degree[0] + degree[1] + degree[2]);
  for (size_t u = 0; u < terms[0].count; ++u) {
    const AxisTerm& of_u = terms[0].term[u];
    Vec3d plane[kSide][kSide];  // [k][j]
    for (size_t k = 0; k <= degree[2]; ++k) {
      for (size_t j = 0; j <= degree[1]; ++j) {
        for (size_t i = 0; i <= degree[0]; ++i) {
          plane[k][j] += of_u.weight[i] * box.points[k][j][i];
        }
      }
    }
    for (size_t v = 0; v < terms[1].count; ++v) {
      const AxisTerm& of_v = terms[1].term[v];
      std::array<Vec3d, kSide> line{};
      for (size_t k = 0; k <= degree[2]; ++k) {
        for (size_t j = 0; j <= degree[1]; ++j) line[k] += of_v.weight[j] * plane[k][j];
      }
      for (size_t w = 0; w < terms[2].count; ++w) {
        const AxisTerm& of_w = terms[2].term[w];
        Vec3d value;
        for (size_t k = 0; k <= degree[2]; ++k) value += of_w.weight[k] * line[k];
        for (size_t c = 0; c < 3; ++c) {
          result[c].at(of_u.i + of_v.i + of_w.i, of_u.j + of_v.j + of_w.j) +=
              value[static_cast<int>(c)];
        }
      }
    }
  }
  return result;
}

double LargestComponent(Vec3d v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// The largest size(p) of the box's points p; not a number if one is.
template <class Size>
double Largest(const BezierBox& box, const Size& size) {
  double largest = 0;
  for (int k = 0; k <= box.degree[2]; ++k) {
    for (int j = 0; j <= box.degree[1]; ++j) {
      for (int i = 0; i <= box.degree[0]; ++i) {
        const double of_point = size(box.points[k][j][i]);
        if (std::isnan(of_point)) return of_point;
        largest = std::max(largest, of_point);
      }
    }
  }
  return largest;
}

// d / dl along an axis, l from 0 to 1 in the box.
BezierBox SlopeOf(const BezierBox& box, size_t axis) {
  BezierBox slope;
  slope.degree = box.degree;
  --slope.degree[axis];
  const std::array<int, 3> next{axis == 0, axis == 1, axis == 2};
  for (int k = 0; k <= slope.degree[2]; ++k) {
    for (int j = 0; j <= slope.degree[1]; ++j) {
      for (int i = 0; i <= slope.degree[0]; ++i) {
        slope.points[k][j][i] =
            static_cast<double>(box.degree[axis]) *
            (box.points[k + next[2]][j + next[1]][i + next[0]] - box.points[k][j][i]);
      }
    }
  }
  return slope;
}

}  // namespace

WeightedBox::WeightedBox(const DeformPlan& plan, uint32_t box, std::span<const Vec3d> offsets)
    : plan_(plan),
      knots_(plan.boxes[box]),
      offset_(RestrictVolume(plan.structure, offsets, knots_.span, knots_.lower, knots_.upper)),
      offset_length_(Largest(offset_, Norm)),
      most_offset_(Largest(offset_, [](Vec3d v) { return LargestComponent(v); })) {
  const FrameMap map(plan.structure);
  for (size_t a = 0; a < 3; ++a) {
    slopes_[a] = SlopeOf(offset_, a);
    most_slope_[a] = Largest(slopes_[a], [](Vec3d v) { return LargestComponent(v); });
    Vec3d end = knots_.lower;
    end[static_cast<int>(a)] = knots_.upper[static_cast<int>(a)];
    edges_[a] = map.ToWorld(end) - map.ToWorld(knots_.lower);
  }
  volume_ = Dot(edges_[0], Cross(edges_[1], edges_[2]));
  for (size_t a = 0; a < 3; ++a) {
    const double by_world =
        Norm(Cross(edges_[(a + 1) % 3], edges_[(a + 2) % 3])) / std::abs(volume_);
    slope_length_ += by_world * Largest(slopes_[a], Norm);
  }
}

bool WeightedBox::IsNearRest(size_t patch) const {
  constexpr double kSurely = 0.999;  // far from what rounding can do
  return std::ranges::max(plan_.CornerWeights(patch)) * slope_length_ +
             offset_length_ * Norm(plan_.PatchWeightGradient(patch)) <
         kSurely;
}

double WeightedBox::MakeDeterminant(size_t p, BernsteinTriangle& determinant) const {
  std::array<std::array<double, 3>, 3> corners;
  for (size_t c = 0; c < 3; ++c) {
    const Vec3d at = plan_.vertices[plan_.patches[p].vertex[c]].parameter;
    for (size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<int>(a);
      corners[a][c] = std::clamp(
          (at[axis] - knots_.lower[axis]) / (knots_.upper[axis] - knots_.lower[axis]), 0.0, 1.0);
    }
  }
  const std::array<double, 3> weights = plan_.CornerWeights(p);
  Form weight(1);
  weight.at(1, 0) = weights[0];
  weight.at(0, 1) = weights[1];
  weight.at(0, 0) = weights[2];
  const Vec3d gradient = plan_.PatchWeightGradient(p);
  const VectorForm offset = Compose(offset_, corners);
  const size_t n = offset[0].degree();
  std::array<VectorForm, 3> column{MakeVectorForm(n), MakeVectorForm(n), MakeVectorForm(n)};
  double most = 1;
  for (size_t a = 0; a < 3; ++a) {
    const VectorForm slope = Compose(slopes_[a], corners);
    const double rise = Dot(gradient, edges_[a]);
    for (size_t c = 0; c < 3; ++c) {
      column[a][c].AddProduct(weight, slope[c], 1);
      for (size_t i = 0; i <= n; ++i) {
        for (size_t j = 0; i + j <= n; ++j) {
          column[a][c].at(i, j) += Multinomial(i, j, n - i - j) * edges_[a][static_cast<int>(c)] +
                                   rise * offset[c].at(i, j);
        }
      }
    }
    const Vec3d edge = edges_[a];
    most *= LargestComponent(edge) + most_slope_[a] + std::abs(rise) * most_offset_;
  }
  Form sum(3 * n);
  for (size_t c = 0; c < 3; ++c) {
    Form cross(2 * n);  // component c of the cross product of the last two columns
    cross.AddProduct(column[1][(c + 1) % 3], column[2][(c + 2) % 3], 1);
    cross.AddProduct(column[1][(c + 2) % 3], column[2][(c + 1) % 3], -1);
    sum.AddProduct(column[0][c], cross, 1);
  }
  determinant.degree = 3 * n;
  for (size_t i = 0; i <= 3 * n; ++i) {
    for (size_t j = 0; i + j <= 3 * n; ++j) {
      determinant.at(i, j) = sum.at(i, j) / (Multinomial(i, j, 3 * n - i - j) * volume_);
    }
  }
  return kWeightedSlack * most / std::abs(volume_);
}

}  // namespace latticed
