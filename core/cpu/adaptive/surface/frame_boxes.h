// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The polynomials of the boxes that one evaluation needs, each made once.
//
// Threads  one thread at a time; MakeNeeded uses those of the arena
#ifndef LATTICED_CORE_CPU_ADAPTIVE_SURFACE_FRAME_BOXES_H_
#define LATTICED_CORE_CPU_ADAPTIVE_SURFACE_FRAME_BOXES_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/cpu/fused/fused_plan.h"
#include "core/view/cpu_arena.h"

namespace latticed::fused {

class FrameBoxes {
 public:
  // Keeps references to both.
  FrameBoxes(const FusedPlan& plan, std::span<const Vec3d> control_points)
      : plan_(plan), control_points_(control_points), number_(plan.plan->boxes.size(), kNoIndex) {}

  void Need(uint32_t box) {
    if (number_[box] != kNoIndex) return;
    number_[box] = static_cast<uint32_t>(needed_.size());
    needed_.push_back(box);
  }
  // Makes the polynomials of all boxes that were needed since the last call.
  void MakeNeeded(CpuArena& arena) {
    const size_t made = polynomials_.size();
    polynomials_.resize(needed_.size());
    arena.ForEach(needed_.size() - made, [&](size_t i) {
      polynomials_[made + i] = plan_.polynomials.Make(needed_[made + i], control_points_);
    });
  }
  bool IsMade(uint32_t box) const { return number_[box] < polynomials_.size(); }
  const BoxPolynomial& operator[](uint32_t box) const { return polynomials_[number_[box]]; }

 private:
  const FusedPlan& plan_;
  const std::span<const Vec3d> control_points_;
  std::vector<uint32_t> number_;  // by box: its place in both lists
  std::vector<uint32_t> needed_;
  std::vector<BoxPolynomial> polynomials_;
};

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_ADAPTIVE_SURFACE_FRAME_BOXES_H_
