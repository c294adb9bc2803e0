// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Normals or texture coordinates of corners: those that are nearly the same at one vertex become one value.
//
// Nearly the same: normals within 0.001 rad, texture coordinates within 2^-20 of their size or of 1. Two patches compute
// the values of a point that they share in different orders, so they differ in the last bits.
//
// The newest 32 values of a vertex are compared, so a vertex of more may have some twice.
//
// Threads  not safe
#ifndef LATTICED_CORE_MESH_VERTEX_VALUES_H_
#define LATTICED_CORE_MESH_VERTEX_VALUES_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/vec.h"

namespace latticed {

[[nodiscard]] inline bool NearlySame(Vec3f a, Vec3f b) {  // unit vectors
  constexpr double kMostDistance = 1e-3;
  return Norm(ToDouble(a) - ToDouble(b)) <= kMostDistance;
}
[[nodiscard]] inline bool NearlySame(Vec2f a, Vec2f b) {
  constexpr float kMostRatio = 1.0f / (1 << 20);
  const auto near = [](float p, float q) {
    return std::abs(p - q) <= kMostRatio * std::max(1.0f, std::abs(p));
  };
  return near(a.x, b.x) && near(a.y, b.y);
}

template <typename T>
class VertexValues {
 public:
  // `most`: of different values; memory for them is taken at once.
  VertexValues(size_t vertices, size_t most) : first_(vertices, kNone) {
    values_.reserve(most);
    next_.reserve(most);
  }

  // The index of the value at this vertex.
  uint32_t Add(uint32_t vertex, T value) {
    int left = kMostCompared;
    for (uint32_t i = first_[vertex]; i != kNone && left > 0; i = next_[i], --left) {
      if (NearlySame(values_[i], value)) return i;
    }
    const auto index = static_cast<uint32_t>(values_.size());
    values_.push_back(value);
    next_.push_back(std::exchange(first_[vertex], index));
    return index;
  }

  std::vector<T> Take() && { return std::move(values_); }

 private:
  static constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  // Values of one vertex. The hub of a hostile fan has as many as the mesh has faces.
  static constexpr int kMostCompared = 32;

  std::vector<uint32_t> first_, next_;  // lists of the values of a vertex, the newest first
  std::vector<T> values_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_VERTEX_VALUES_H_
