// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A run: points of up to kRunPatches patches of one box, or of edges and corners alone, and what was computed for them. The
// memory is kept for the next run.
//
// Threads  one thread at a time
#ifndef LATTICED_CORE_CPU_ADAPTIVE_KERNEL_RUN_BUFFER_H_
#define LATTICED_CORE_CPU_ADAPTIVE_KERNEL_RUN_BUFFER_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "core/cpu/adaptive/kernel/adaptive_kernel.h"
#include "core/cpu/adaptive/kernel/pattern_places.h"

namespace latticed::fused {

class RunBuffer {
 public:
  RunPatches patches;
  RunWeights weights;  // only where the mesh has weights

  size_t size() const { return patch_.size(); }
  void Clear();
  // Adds the points of a pattern in patch number `patch` of the run. Returns the number of the first.
  size_t Add(size_t patch, const PatternPlaces& places);
  void Add(size_t patch, int32_t code, float along, float up);

  // Evaluates all points. The patches of the run must be filled in.
  void Evaluate(const std::array<int, 3>& degree, const BoxPolynomial& box, NormalMode normals,
                bool weighted);

  // After Evaluate: a value of every point. Components are x y z relative to the local origin, then the unit normal.
  float* Row(size_t component) { return rows_ + component * padded_; }
  // Points whose normals must come from the definition.
  std::span<const WeakNormal> weak() const { return {weak_.data(), weak_count_}; }
  static size_t PointOf(const WeakNormal& weak) { return weak.point * kLanes + weak.lane; }
  size_t PatchOf(size_t point) const { return static_cast<size_t>(patch_[point]); }

 private:
  static constexpr size_t kComponents = 6;

  std::vector<int32_t> patch_, code_;
  std::vector<float> along_, up_;
  std::vector<float> memory_;
  float* rows_ = nullptr;  // in memory_, aligned
  size_t padded_ = 0;
  std::vector<WeakNormal> weak_;
  size_t weak_count_ = 0;
};

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_ADAPTIVE_KERNEL_RUN_BUFFER_H_
