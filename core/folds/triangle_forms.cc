// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/folds/triangle_forms.h"

#include "core/base/limits.h"

namespace latticed {
namespace {

constexpr size_t kMostSum = BernsteinTriangle::kMostDegree;
constexpr size_t kSide = limits::kMaxDegree + 1;
constexpr size_t kAxisTerms = kSide * (kSide + 1) / 2;

constexpr auto kFactorials = [] {
  std::array<double, kMostSum + 1> result{1};
  for (size_t k = 1; k <= kMostSum; ++k) result[k] = result[k - 1] * static_cast<double>(k);
  return result;
}();

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

}  // namespace

double Multinomial(size_t i, size_t j, size_t k) {
  return kFactorials[i + j + k] / (kFactorials[i] * kFactorials[j] * kFactorials[k]);
}

void TriangleForm::AddProduct(const TriangleForm& a, const TriangleForm& b, double sign) {
  for (size_t i = 0; i <= a.degree_; ++i) {
    for (size_t j = 0; i + j <= a.degree_; ++j) {
      const double factor = sign * a.at(i, j);
      for (size_t p = 0; p <= b.degree_; ++p) {
        for (size_t q = 0; p + q <= b.degree_; ++q) at(i + p, j + q) += factor * b.at(p, q);
      }
    }
  }
}

TriangleForm LinearForm(const std::array<double, 3>& corners) {
  TriangleForm form(1);
  form.at(1, 0) = corners[0];
  form.at(0, 1) = corners[1];
  form.at(0, 0) = corners[2];
  return form;
}

VectorForm MakeVectorForm(size_t degree) {
  return {TriangleForm(degree), TriangleForm(degree), TriangleForm(degree)};
}

VectorForm Compose(const BezierBox& box, const TriangleInBox& corners) {
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

void SetDeterminant(const std::array<VectorForm, 3>& column, double divisor,
                    BernsteinTriangle& determinant) {
  const size_t n = column[0][0].degree();
  TriangleForm sum(3 * n);
  for (size_t c = 0; c < 3; ++c) {
    TriangleForm cross(2 * n);  // component c of the cross product of the last two columns
    cross.AddProduct(column[1][(c + 1) % 3], column[2][(c + 2) % 3], 1);
    cross.AddProduct(column[1][(c + 2) % 3], column[2][(c + 1) % 3], -1);
    sum.AddProduct(column[0][c], cross, 1);
  }
  determinant.degree = 3 * n;
  for (size_t i = 0; i <= 3 * n; ++i) {
    for (size_t j = 0; i + j <= 3 * n; ++j) {
      determinant.at(i, j) = sum.at(i, j) / (Multinomial(i, j, 3 * n - i - j) * divisor);
    }
  }
}

}  // namespace latticed
