// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/octahedral.h"

#include <cmath>

namespace latticed {
Vec3f DequantiseNormal(OctahedralNormal n, int bits) {
  const float scale = 2.0f / static_cast<float>(OctahedralMax(bits));
  float y = static_cast<float>(n.s) * scale - 1.0f;
  float z = static_cast<float>(n.t) * scale - 1.0f;
  const float x = 1.0f - std::abs(y) - std::abs(z);
  // Outside the diamond x is negative: fold y and z back over its nearest edge.
  const float fold = x < 0 ? -x : 0.0f;
  y += y < 0 ? fold : -fold;
  z += z < 0 ? fold : -fold;
  const float inverse_length = 1.0f / std::sqrt(x * x + y * y + z * z);  // L1 norm 1: never zero
  return {x * inverse_length, y * inverse_length, z * inverse_length};
}

}  // namespace latticed
