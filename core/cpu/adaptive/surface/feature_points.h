// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edges and corners that patches take from another box: on knot planes, and on seams (core/cpu/fused/fused_layout.h).
//
// Layout  positions relative to the local origin. An edge of level k has 2^k - 1 inner points, in canonical order
// Threads Need and MakeNeeded by one thread; then At by any
#ifndef LATTICED_CORE_CPU_ADAPTIVE_SURFACE_FEATURE_POINTS_H_
#define LATTICED_CORE_CPU_ADAPTIVE_SURFACE_FEATURE_POINTS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/cpu/adaptive/kernel/run_buffer.h"
#include "core/cpu/adaptive/surface/frame_boxes.h"

namespace latticed::fused {

class FeaturePoints {
 public:
  // Keeps references to both. `boxes` gets the boxes that features need.
  FeaturePoints(const FusedPlan& plan, std::span<const Vec3d> control_points, FrameBoxes& boxes);

  // Asks for what `fix` takes, if it takes anything; of an edge, its inner points at this level.
  void Need(const Fix& fix, int level);
  // Evaluates what was asked for. The polynomials of its boxes are made.
  void MakeNeeded(CpuArena& arena);

  // The points that `fix` takes: one for a corner, the inner points of an edge. Empty if it takes none.
  std::span<const Vec3f> At(const Fix& fix) const;

 private:
  struct Place {
    uint32_t first = kNoIndex;  // in points_
    uint32_t count = 0;
  };
  // 16 features of one box.
  struct Work {
    uint32_t group;
    bool is_edge;
  };

  uint32_t FeatureOf(const Fix& fix) const;
  void Evaluate(const Work& work, RunBuffer& run);

  const FusedPlan& plan_;
  FrameBoxes& boxes_;
  std::vector<bool> attached_;          // by seam
  std::vector<Place> edges_, corners_;  // by feature
  std::vector<bool> edge_groups_, corner_groups_;
  std::vector<Work> work_;
  std::vector<Vec3f> points_;
};

}  // namespace latticed::fused

#endif  // LATTICED_CORE_CPU_ADAPTIVE_SURFACE_FEATURE_POINTS_H_
