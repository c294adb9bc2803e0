// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From bounds in double to those that a surface hands on, in float32 and with their slack.
//
// Threads  pure function
#ifndef LATTICED_CORE_CPU_ADAPTIVE_SURFACE_RAISED_BOUNDS_H_
#define LATTICED_CORE_CPU_ADAPTIVE_SURFACE_RAISED_BOUNDS_H_

#include "core/adaptive/curvature_slack.h"

namespace latticed {

[[nodiscard]] inline CurvatureBounds<float> RaisedBounds(const CurvatureBounds<double>& exact,
                                                         double slack) {
  CurvatureBounds<float> bounds;
  for (int e = 0; e < 3; ++e) {
    bounds.edge[e] = static_cast<float>(kBoundFactor * (exact.edge[e] + slack));
    bounds.mixed[e] = static_cast<float>(kBoundFactor * (exact.mixed[e] + slack));
  }
  return bounds;
}

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_ADAPTIVE_SURFACE_RAISED_BOUNDS_H_
