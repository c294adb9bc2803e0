// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/cpp/library/patches/point_block.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target, as Highway asks.
#include <algorithm>
#include <cmath>

#include "client/cpp/library/patches/point_block.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::client {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// One point.
struct ScalarOps {
  using V = float;
  static V Set(float x) { return x; }
  static V Load(const float* from) { return *from; }
  static void Store(V x, float* to) { *to = x; }
  static V Add(V a, V b) { return a + b; }
  static V Sub(V a, V b) { return a - b; }
  static V Mul(V a, V b) { return a * b; }
  static V Div(V a, V b) { return a / b; }
  static V Abs(V a) { return std::abs(a); }
  static V Max(V a, V b) { return std::max(a, b); }
  static V Sqrt(V a) { return std::sqrt(a); }
  static V IfPositive(V a, V yes, V no) { return a > 0 ? yes : no; }
};

// A vector of points. No fused multiply-add, which only some instruction sets have.
struct VectorOps {
  using D = hn::CappedTag<float, kBlockPoints>;
  using V = hn::Vec<D>;
  static V Set(float x) { return hn::Set(D(), x); }
  static V Load(const float* from) { return hn::Load(D(), from); }
  static void Store(V x, float* to) { hn::Store(x, D(), to); }
  static V Add(V a, V b) { return hn::Add(a, b); }
  static V Sub(V a, V b) { return hn::Sub(a, b); }
  static V Mul(V a, V b) { return hn::Mul(a, b); }
  static V Div(V a, V b) { return hn::Div(a, b); }
  static V Abs(V a) { return hn::Abs(a); }
  static V Max(V a, V b) { return hn::Max(a, b); }
  static V Sqrt(V a) { return hn::Sqrt(a); }
  static V IfPositive(V a, V yes, V no) { return hn::IfThenElse(hn::Gt(a, Set(0)), yes, no); }
};

template <class Ops>
struct Formulas {
  using V = typename Ops::V;

  static HWY_INLINE V MulAdd(V a, V b, V c) { return Ops::Add(Ops::Mul(a, b), c); }

  // One component of the position, and of its derivatives by l_0, l_1, l_2. `c` is after the last coefficient.
  template <bool kDerivatives>
  static HWY_INLINE V Component(const std::array<int, 3>& degree, const float* c, const V* l,
                                V* derivatives) {
    V value = Ops::Set(0), by_0 = value, by_1 = value, by_2 = value;
    for (int k = degree[2]; k >= 0; --k) {
      V plane = Ops::Set(0), plane_0 = plane, plane_1 = plane;
      for (int j = degree[1]; j >= 0; --j) {
        V line = Ops::Set(0), line_0 = line;
        for (int i = degree[0]; i >= 0; --i) {
          if constexpr (kDerivatives) line_0 = MulAdd(line_0, l[0], line);
          line = MulAdd(line, l[0], Ops::Set(*--c));
        }
        if constexpr (kDerivatives) {
          plane_1 = MulAdd(plane_1, l[1], plane);
          plane_0 = MulAdd(plane_0, l[1], line_0);
        }
        plane = MulAdd(plane, l[1], line);
      }
      if constexpr (kDerivatives) {
        by_2 = MulAdd(by_2, l[2], value);
        by_1 = MulAdd(by_1, l[2], plane_1);
        by_0 = MulAdd(by_0, l[2], plane_0);
      }
      value = MulAdd(value, l[2], plane);
    }
    derivatives[0] = by_0;
    derivatives[1] = by_1;
    derivatives[2] = by_2;
    return value;
  }

  static HWY_INLINE V Largest(const V* v) {
    return Ops::Max(Ops::Max(Ops::Abs(v[0]), Ops::Abs(v[1])), Ops::Abs(v[2]));
  }

  // From R and its derivatives, d[component][axis], to X + w (R - X) and its derivatives, with X the point at rest.
  template <bool kDerivatives>
  static HWY_INLINE void Weigh(const float* rest, V weight, const V* slope, const V* l, V* position,
                               V (&d)[3][3]) {
    V rises[3];  // of the weight, by axis
    for (size_t a = 0; a < 3; ++a) {
      const float* edge = rest + 3 * (a + 1);
      rises[a] = Ops::Mul(slope[0], Ops::Set(edge[0]));
      rises[a] = MulAdd(slope[1], Ops::Set(edge[1]), rises[a]);
      rises[a] = MulAdd(slope[2], Ops::Set(edge[2]), rises[a]);
    }
    for (size_t c = 0; c < 3; ++c) {
      V at_rest = Ops::Set(rest[c]);
      for (size_t a = 0; a < 3; ++a)
        at_rest = MulAdd(l[a], Ops::Set(rest[3 * (a + 1) + c]), at_rest);
      const V offset = Ops::Sub(position[c], at_rest);
      position[c] = MulAdd(weight, offset, at_rest);
      if constexpr (kDerivatives) {
        for (size_t a = 0; a < 3; ++a) {
          const V edge = Ops::Set(rest[3 * (a + 1) + c]);
          d[c][a] = MulAdd(weight, Ops::Sub(d[c][a], edge), edge);
          d[c][a] = MulAdd(offset, rises[a], d[c][a]);
        }
      }
    }
  }

  // d[component][axis]
  static HWY_INLINE void Carry(const float* conormals, const V (&d)[3][3], const V* rest,
                               V* normal) {
    for (size_t k = 0; k < 3; ++k) normal[k] = Ops::Set(0);
    for (size_t a = 0; a < 3; ++a) {
      const size_t b = (a + 1) % 3, c = (a + 2) % 3;
      V h = Ops::Mul(Ops::Set(conormals[3 * a]), rest[0]);
      h = MulAdd(Ops::Set(conormals[3 * a + 1]), rest[1], h);
      h = MulAdd(Ops::Set(conormals[3 * a + 2]), rest[2], h);
      for (size_t k = 0; k < 3; ++k) {
        const size_t p = (k + 1) % 3, q = (k + 2) % 3;
        const V cross = Ops::Sub(Ops::Mul(d[p][b], d[q][c]), Ops::Mul(d[q][b], d[p][c]));
        normal[k] = MulAdd(h, cross, normal[k]);
      }
    }
    const V largest = Largest(normal);
    for (size_t k = 0; k < 3; ++k) normal[k] = Ops::IfPositive(largest, normal[k], rest[k]);
  }

  // Divides by the largest component first, because squares of small ones would vanish.
  static HWY_INLINE void Normalise(V* v) {
    const V largest = Largest(v), divisor = Ops::IfPositive(largest, largest, Ops::Set(1));
    for (size_t k = 0; k < 3; ++k) v[k] = Ops::Div(v[k], divisor);
    const V squares = MulAdd(v[2], v[2], MulAdd(v[1], v[1], Ops::Mul(v[0], v[0])));
    const V length = Ops::Sqrt(Ops::IfPositive(squares, squares, Ops::Set(1)));
    for (size_t k = 0; k < 3; ++k) v[k] = Ops::Div(v[k], length);
  }

  // The points from `i` on.
  template <bool kNormals, size_t kPoints>
  static HWY_INLINE void Evaluate(const BoxPolynomial& box, size_t i, PointBlock<kPoints>* block) {
    const auto terms =
        static_cast<size_t>((box.degree[0] + 1) * (box.degree[1] + 1) * (box.degree[2] + 1));
    V l[3], d[3][3], position[3];
    for (size_t a = 0; a < 3; ++a) l[a] = Ops::Load(&block->local[a][i]);
    for (size_t c = 0; c < 3; ++c) {
      const float* end = box.coefficients + (c + 1) * terms;
      position[c] = Component<kNormals>(box.degree, end, l, d[c]);
    }
    if (box.rest != nullptr) {
      const V slope[3] = {Ops::Load(&block->slope[0][i]), Ops::Load(&block->slope[1][i]),
                          Ops::Load(&block->slope[2][i])};
      Weigh<kNormals>(box.rest, Ops::Load(&block->weight[i]), slope, l, position, d);
    }
    for (size_t c = 0; c < 3; ++c) Ops::Store(position[c], &block->position[c][i]);
    if constexpr (kNormals) {
      V rest[3], normal[3];
      for (size_t c = 0; c < 3; ++c) rest[c] = Ops::Load(&block->rest[c][i]);
      Carry(box.conormals, d, rest, normal);
      Normalise(normal);
      for (size_t c = 0; c < 3; ++c) Ops::Store(normal[c], &block->normal[c][i]);
    }
  }
};

void EvaluateVectors(const BoxPolynomial& box, bool with_normals, PointBlock<kBlockPoints>* block) {
  for (size_t i = 0; i < kBlockPoints; i += hn::Lanes(VectorOps::D())) {
    if (with_normals) {
      Formulas<VectorOps>::Evaluate<true>(box, i, block);
    } else {
      Formulas<VectorOps>::Evaluate<false>(box, i, block);
    }
  }
}

void EvaluateOne(const BoxPolynomial& box, bool with_normals, PointBlock<1>* block) {
  if (with_normals) {
    Formulas<ScalarOps>::Evaluate<true>(box, 0, block);
  } else {
    Formulas<ScalarOps>::Evaluate<false>(box, 0, block);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::client
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::client {

HWY_EXPORT(EvaluateVectors);

void EvaluateBlock(const BoxPolynomial& box, bool with_normals, PointBlock<kBlockPoints>* block) {
  HWY_DYNAMIC_DISPATCH(EvaluateVectors)(box, with_normals, block);
}

void EvaluateBlock(const BoxPolynomial& box, bool with_normals, PointBlock<1>* block) {
  HWY_STATIC_DISPATCH(EvaluateOne)(box, with_normals, block);
}

}  // namespace latticed::client
#endif  // HWY_ONCE
