// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The pattern of each patch of an exported surface: one for all, or with a tolerance one of its own.
//
// Threads  immutable once made
#ifndef LATTICED_SERVER_ENGINE_EXPORTS_SURFACE_PATTERNS_H_
#define LATTICED_SERVER_ENGINE_EXPORTS_SURFACE_PATTERNS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/adaptive/adaptive_pattern.h"
#include "core/ffd/plan/deform_plan.h"

namespace latticed {

class SurfacePatterns {
 public:
  // All patches of the plan have so many segments.
  SurfacePatterns(const DeformPlan& plan, int segments);
  // `codes`: PatternKey::Code of each patch, in plan order.
  explicit SurfacePatterns(std::vector<uint16_t> codes);

  size_t size() const { return patches_; }
  const AdaptivePattern& Of(size_t patch) const {
    return codes_.empty() ? uniform_ : AdaptivePattern::Get(*PatternKey::FromCode(codes_[patch]));
  }
  // Of all patches together.
  uint64_t PointCount() const;
  uint64_t TriangleCount() const;

 private:
  size_t patches_;
  AdaptivePattern uniform_;  // without a key
  std::vector<uint16_t> codes_;
};

// The points of a pattern that are on none of its edges.
[[nodiscard]] size_t InnerPointCount(const AdaptivePattern& pattern);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_EXPORTS_SURFACE_PATTERNS_H_
