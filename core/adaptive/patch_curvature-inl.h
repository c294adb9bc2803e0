// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bounds of the second derivatives of a patch, from its composed polynomial.
//
//   P(x, t) = sum_ij p_ij x^i t^j, i + j <= n      x = b1 + s b2 - 1/2,  t = b2 - 1/2,  s the shear in [0, 1]
//   edge[0], edge[1], edge[2]       sup |d^2 P| along edges 01, 12 and 20
//   mixed[0], mixed[1], mixed[2]    sup |d^2 P| along both edges that leave corner 0, 1 and 2
//
// Derivatives are by barycentrics: d P along edge 01 is P's derivative by b1 - b0. Each second derivative is a
// polynomial of degree m = n - 2. Its norm is at most the largest norm of its Bernstein coefficients over the patch.
//
// Derivation. With h and g half the steps of x and t, and O the point x = t = 0, corners and halves of edges are
//
//   V0 = O - g - h      V1 = O - g + h      V2 = O + g + (2s - 1) h
//   e01 / 2 = h         e02 / 2 = g + s h   e12 / 2 = e02 / 2 - h
//
// The polar form of P at i times h, j times g and n - i - j times O is p_ij 2^-(i+j) i! j! (n-i-j)! / n!. Scaled by
// 4 n (n - 1), its entries with two more factors h h, h g or g g are the polar forms of the second derivatives along
// 2h 2h, 2h 2g and 2g 2g. Three changes of arguments take each to the corners, where it is the Bernstein coefficient:
//
//   O, g -> U = O - g, T = O + g      a butterfly per power of h: k and L - k times T share even and odd parts
//   T    -> V2 = T + (2s - 1) h       one step per V2
//   U, h -> V0 = U - h, V1 = U + h    a butterfly per power of V2
//
// All of these points lie in |x|, |t| <= 1/2, so no intermediate value exceeds sum_ij |p_ij| 2^-(i+j) of a second
// derivative. A conversion that began at a corner could exceed it by a factor 3^m, and round as much more.
// Derivatives along edges follow from the three as vectors: e02 = 2g + s 2h, and so on.
//
// Operations a patch (multiply-adds, additions, multiplications and maxima), and no roots:
//   n      3      4      5      6      7      8      9
//        212    470    890  1,463  2,252  3,248  4,514
//
// Arithmetic is what Ops says: Ops::V is the number type (a float, a double, or a vector of lanes), with static
// functions Set(double), Add, Sub, Mul, MulAdd(a, b, c) = a b + c, and Max.
//
// This file has no include guard and no namespace. Code for several instruction sets must lie in a namespace of each,
// so each includer includes it in its own: core/adaptive/patch_curvature.h for the host and CUDA, and a backend's SIMD
// code once per instruction set.
// Threads  pure functions

template <int kDegree, typename Ops>
class PatchCurvature {
 public:
  using V = typename Ops::V;
  static constexpr int kOrder = kDegree - 2;  // m
  static constexpr size_t kCoefficients = (kDegree + 1) * (kDegree + 2) / 2;

  // Squares of the bounds. p[component] has kCoefficients entries, that of x^i t^j at At(i, j).
  LATTICED_HD static inline void SquaredBounds(const V* const* p, V shear, V* edge, V* mixed) {
    V second[3][3][kTerms];  // [2h 2h, 2h 2g, 2g 2g][component]: Bernstein coefficients
    const V skew = Ops::Sub(Ops::Add(shear, shear), Ops::Set(1));
    LATTICED_UNROLL for (int c = 0; c < 3; ++c) {
      V polar[kCoefficients];
      ScaleToPolarForm(p[c], polar);
      LATTICED_UNROLL for (int d = 0; d < 3; ++d) {
        V* f = second[d][c];
        LATTICED_UNROLL for (int j = 0; j <= kOrder; ++j) {
          LATTICED_UNROLL for (int i = 0; i <= kOrder - j; ++i) {
            f[At(i, j)] = polar[At(i + 2 - d, j + d)];
          }
        }
        ToBernstein(f, skew);
      }
    }
    LargestNorms(second, shear, edge, mixed);
  }

 private:
  static constexpr size_t kLine = kOrder + 1;  // coefficients of a row
  static constexpr size_t kTerms = kLine * (kLine + 1) / 2;
  LATTICED_HD static constexpr int At(int i, int j) { return (i + j) * (i + j + 1) / 2 + j; }

  struct PolarWeights {
    double weight[kCoefficients] = {};
    LATTICED_HD constexpr PolarWeights() {
      for (int i = 0; i <= kDegree; ++i) {
        for (int j = 0; j <= kDegree - i; ++j) {
          double w = 4;
          for (int k = 2; k <= i; ++k) w *= k;
          for (int k = 2; k <= j; ++k) w *= k;
          for (int k = 2; k <= kDegree - i - j; ++k) w *= k;
          for (int k = 2; k <= kDegree - 2; ++k) w /= k;
          for (int k = 0; k < i + j; ++k) w /= 2;
          weight[At(i, j)] = w;
        }
      }
    }
  };

  // value[length][k][i]: the coefficient of O^(length-i) g^i in (O - g)^(length-k) (O + g)^k. They are integers, at
  // most the binomial of length and i.
  struct Butterfly {
    double value[kLine][kLine][kLine] = {};
    LATTICED_HD constexpr Butterfly() {
      for (int length = 0; length <= kOrder; ++length) {
        for (int k = 0; k <= length; ++k) {
          double* row = value[length][k];
          row[0] = 1;
          for (int factor = 0; factor < length; ++factor) {
            const double sign = factor < k ? 1 : -1;
            for (int i = factor + 1; i > 0; --i) row[i] += sign * row[i - 1];
          }
        }
      }
    }
  };

  LATTICED_HD static inline void ScaleToPolarForm(const V* p, V* polar) {
    constexpr PolarWeights kWeights;
    LATTICED_UNROLL for (size_t k = At(2, 0); k < kCoefficients; ++k) {
      polar[k] = Ops::Mul(p[k], Ops::Set(kWeights.weight[k]));
    }
  }

  // In place: from arguments (h, g, O) to (V1, V2, V0), with entry At(i, j) for i and j of the first two.
  LATTICED_HD static inline void ToBernstein(V* f, V skew) {
    Lines<true, 0>(f);
    LATTICED_UNROLL for (int factor = 1; factor <= kOrder; ++factor) {
      LATTICED_UNROLL for (int j = kOrder; j >= factor; --j) {
        LATTICED_UNROLL for (int i = 0; i <= kOrder - j; ++i) {
          f[At(i, j)] = Ops::MulAdd(skew, f[At(i + 1, j - 1)], f[At(i, j)]);
        }
      }
    }
    Lines<false, 0>(f);
  }

  // The butterflies of all lines of entries that have one index in common, from kFixed on.
  template <bool kSecondIndex, int kFixed>
  LATTICED_HD static inline void Lines(V* f) {
    if constexpr (kFixed < kOrder) {
      Line<kSecondIndex, kFixed>(f);
      Lines<kSecondIndex, kFixed + 1>(f);
    }
  }

  template <bool kSecondIndex, int kFixed>
  LATTICED_HD static inline void Line(V* f) {
    constexpr Butterfly kButterfly;
    constexpr int length = kOrder - kFixed;
    V in[kLine];
    LATTICED_UNROLL for (int k = 0; k <= length; ++k) {
      in[k] = f[kSecondIndex ? At(kFixed, k) : At(k, kFixed)];
    }
    LATTICED_UNROLL for (int k = 0; 2 * k <= length; ++k) {
      const double* row = kButterfly.value[length][k];
      V even = in[0];
      LATTICED_UNROLL for (int i = 2; i <= length; i += 2) {
        even = Ops::MulAdd(in[i], Ops::Set(row[i]), even);
      }
      const int low = kSecondIndex ? At(kFixed, k) : At(k, kFixed);
      if (2 * k == length) {  // the odd part vanishes
        f[low] = even;
        continue;
      }
      V odd = Ops::Mul(in[1], Ops::Set(row[1]));
      LATTICED_UNROLL for (int i = 3; i <= length; i += 2) {
        odd = Ops::MulAdd(in[i], Ops::Set(row[i]), odd);
      }
      f[low] = Ops::Add(even, odd);
      f[kSecondIndex ? At(kFixed, length - k) : At(length - k, kFixed)] = Ops::Sub(even, odd);
    }
  }

  LATTICED_HD static inline V LargerNorm(const V* v, V largest) {
    return Ops::Max(largest,
                    Ops::MulAdd(v[0], v[0], Ops::MulAdd(v[1], v[1], Ops::Mul(v[2], v[2]))));
  }

  LATTICED_HD static inline void LargestNorms(const V second[3][3][kTerms], V shear, V* edge,
                                              V* mixed) {
    LATTICED_UNROLL for (int e = 0; e < 3; ++e) edge[e] = mixed[e] = Ops::Set(0);
    LATTICED_UNROLL for (size_t k = 0; k < kTerms; ++k) {
      V edge_01[3], edge_12[3], edge_20[3], corner_0[3], corner_1[3], corner_2[3];
      LATTICED_UNROLL for (int c = 0; c < 3; ++c) {
        edge_01[c] = second[0][c][k];
        const V along_across = second[1][c][k];
        corner_0[c] = Ops::MulAdd(shear, edge_01[c], along_across);
        edge_20[c] = Ops::MulAdd(shear, Ops::Add(along_across, corner_0[c]), second[2][c][k]);
        corner_1[c] = Ops::Sub(corner_0[c], edge_01[c]);
        corner_2[c] = Ops::Sub(edge_20[c], corner_0[c]);
        edge_12[c] = Ops::Sub(corner_2[c], corner_1[c]);
      }
      edge[0] = LargerNorm(edge_01, edge[0]);
      edge[1] = LargerNorm(edge_12, edge[1]);
      edge[2] = LargerNorm(edge_20, edge[2]);
      mixed[0] = LargerNorm(corner_0, mixed[0]);
      mixed[1] = LargerNorm(corner_1, mixed[1]);
      mixed[2] = LargerNorm(corner_2, mixed[2]);
    }
  }
};
