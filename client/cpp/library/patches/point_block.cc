// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/patches/point_block.h"

#include <algorithm>
#include <cmath>

namespace latticed::client {
namespace {

template <size_t n>
struct Lanes {
  float at[n] = {};

  // this = this * l + c
  void Step(const float* l, const Lanes& c) {
    for (size_t i = 0; i < n; ++i) at[i] = at[i] * l[i] + c.at[i];
  }
  void Step(const float* l, float c) {
    for (size_t i = 0; i < n; ++i) at[i] = at[i] * l[i] + c;
  }
};

// One component of the position and of its derivatives by l_0, l_1, l_2.
template <size_t n, bool kWithNormals>
void EvaluateComponent(const std::array<int, 3>& degree, const float* c, const float (&l)[3][n],
                       Lanes<n>* value, Lanes<n>* derivatives) {
  c += (degree[0] + 1) * (degree[1] + 1) * (degree[2] + 1);
  for (int k = degree[2]; k >= 0; --k) {
    Lanes<n> plane, plane_0, plane_1;
    for (int j = degree[1]; j >= 0; --j) {
      Lanes<n> line, line_0;
      for (int i = degree[0]; i >= 0; --i) {
        if constexpr (kWithNormals) line_0.Step(l[0], line);
        line.Step(l[0], *--c);
      }
      if constexpr (kWithNormals) {
        plane_1.Step(l[1], plane);
        plane_0.Step(l[1], line_0);
      }
      plane.Step(l[1], line);
    }
    if constexpr (kWithNormals) {
      derivatives[2].Step(l[2], *value);
      derivatives[1].Step(l[2], plane_1);
      derivatives[0].Step(l[2], plane_0);
    }
    value->Step(l[2], plane);
  }
}

// derivatives[component][axis]
template <size_t n>
void CarryNormals(const float* conormals, const Lanes<n> (&derivatives)[3][3],
                  PointBlock<n>* block) {
  for (size_t i = 0; i < n; ++i) {
    const float x = block->rest[0][i], y = block->rest[1][i], z = block->rest[2][i];
    float normal[3] = {};
    for (size_t a = 0; a < 3; ++a) {
      const float h = conormals[3 * a] * x + conormals[3 * a + 1] * y + conormals[3 * a + 2] * z;
      const size_t b = (a + 1) % 3, c = (a + 2) % 3;
      for (size_t k = 0; k < 3; ++k) {
        const size_t p = (k + 1) % 3, q = (k + 2) % 3;
        normal[k] += h * (derivatives[p][b].at[i] * derivatives[q][c].at[i] -
                          derivatives[q][b].at[i] * derivatives[p][c].at[i]);
      }
    }
    const float largest = std::max({std::abs(normal[0]), std::abs(normal[1]), std::abs(normal[2])});
    const bool carried = largest > 0;
    for (size_t k = 0; k < 3; ++k) block->normal[k][i] = carried ? normal[k] : block->rest[k][i];
  }
}

// Divides by the largest component first, because squares of small ones would vanish.
template <size_t n>
void Normalise(float (&v)[3][n]) {
  for (size_t i = 0; i < n; ++i) {
    const float largest = std::max({std::abs(v[0][i]), std::abs(v[1][i]), std::abs(v[2][i])});
    const float divisor = largest > 0 ? largest : 1.0f;
    const float x = v[0][i] / divisor, y = v[1][i] / divisor, z = v[2][i] / divisor;
    const float length2 = x * x + y * y + z * z;
    const float length = std::sqrt(length2 > 0 ? length2 : 1.0f);
    v[0][i] = x / length;
    v[1][i] = y / length;
    v[2][i] = z / length;
  }
}

template <size_t n, bool kWithNormals>
void Evaluate(const BoxPolynomial& box, PointBlock<n>* block) {
  const size_t terms =
      static_cast<size_t>((box.degree[0] + 1) * (box.degree[1] + 1) * (box.degree[2] + 1));
  Lanes<n> derivatives[3][3];
  for (size_t component = 0; component < 3; ++component) {
    Lanes<n> value;
    EvaluateComponent<n, kWithNormals>(box.degree, box.coefficients + component * terms,
                                       block->local, &value, derivatives[component]);
    std::copy_n(value.at, n, block->position[component]);
  }
  if constexpr (kWithNormals) {
    CarryNormals(box.conormals, derivatives, block);
    Normalise(block->normal);
  }
}

}  // namespace

void EvaluateBlock(const BoxPolynomial& box, bool with_normals, PointBlock<kBlockPoints>* block) {
  with_normals ? Evaluate<kBlockPoints, true>(box, block)
               : Evaluate<kBlockPoints, false>(box, block);
}

void EvaluateBlock(const BoxPolynomial& box, bool with_normals, PointBlock<1>* block) {
  with_normals ? Evaluate<1, true>(box, block) : Evaluate<1, false>(box, block);
}

}  // namespace latticed::client
