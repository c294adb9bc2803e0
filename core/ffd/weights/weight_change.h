// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How much the weight of a patch changes along a side of it.
//
// Threads  pure functions, host and device
#ifndef LATTICED_CORE_FFD_WEIGHTS_WEIGHT_CHANGE_H_
#define LATTICED_CORE_FFD_WEIGHTS_WEIGHT_CHANGE_H_

#include <cmath>

#include "core/base/host_device.h"

namespace latticed {

// Whether the two are one, but for rounding. They are not where the source triangle is so thin that its gradient means
// nothing.
LATTICED_HD inline bool IsByGradient(double by_gradient, double by_corners) {
  constexpr double kRounding = 1e-6;  // of corners in float32
  return std::abs(by_gradient - by_corners) <= kRounding;
}

// By the gradient of the source triangle, which a thin piece of the triangle keeps exactly, or by the weights of the
// patch's corners where the two differ.
LATTICED_HD inline double WeightChange(double by_gradient, double by_corners) {
  return IsByGradient(by_gradient, by_corners) ? by_gradient : by_corners;
}

// How steeply the weight of a patch may change: |gradient|, or by its climb over the patch's height if that is more.
LATTICED_HD inline double WeightSteepness(double gradient, double climb, double height) {
  return std::fmax(gradient, height > 0 ? std::abs(climb) / height : 0.0);
}

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_WEIGHTS_WEIGHT_CHANGE_H_
