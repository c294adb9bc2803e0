// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Adaptive tessellation in double precision: from control points to levels, patterns and certificates. Backends do the
// same in float32, with larger bounds (core/adaptive/curvature_slack.h). At a threshold their levels may differ; both
// certificates hold.
//
// With vertex weights a patch is P = x + w G, G = F - x the offset (core/ffd/weights/). Its second derivatives are those of
// w G, one polynomial of degree n + 1. The CPU backend takes them from here.
//
// Patches outside the frame have bounds and certificates 0: they do not move. Their edges still take the levels of
// neighbours inside, so that an attached seam has no cracks.
//
// Units    world
// Threads  pure; the constructor does all work that does not depend on control points
#ifndef LATTICED_CORE_ADAPTIVE_ADAPTIVE_REFERENCE_H_
#define LATTICED_CORE_ADAPTIVE_ADAPTIVE_REFERENCE_H_

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/adaptive/patch_curvature.h"
#include "core/adaptive/pattern_key.h"
#include "core/ffd/box/box_basis.h"

namespace latticed {

struct AdaptiveTessellation {
  std::vector<uint8_t> edge_levels;  // by edge of the plan
  std::vector<PatternKey> patterns;  // by patch
  std::vector<double> errors;        // by patch: PatternError
  double largest_error = 0;          // exceeds the tolerance where level 5 does not suffice
};

class AdaptiveReference {
 public:
  explicit AdaptiveReference(std::shared_ptr<const DeformPlan> plan);

  using BoxCoefficients = std::array<Vec3d, BoxBasis::kMostTerms>;
  // C of a box inside the frame; with weights that of the offset.
  [[nodiscard]] BoxCoefficients Polynomial(uint32_t box,
                                           std::span<const Vec3d> control_points) const;
  // Of one patch of the box that has this polynomial.
  [[nodiscard]] CurvatureBounds<double> BoundPatch(size_t patch,
                                                   std::span<const Vec3d> polynomial) const;
  // Of every patch.
  [[nodiscard]] std::vector<CurvatureBounds<double>> Bounds(
      std::span<const Vec3d> control_points) const;

  // tolerance: the part for curvature, see CurvatureTolerance.
  [[nodiscard]] AdaptiveTessellation Tessellate(std::span<const CurvatureBounds<double>> bounds,
                                                double tolerance) const;

 private:
  std::shared_ptr<const DeformPlan> plan_;
  BoxBasis basis_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_ADAPTIVE_ADAPTIVE_REFERENCE_H_
