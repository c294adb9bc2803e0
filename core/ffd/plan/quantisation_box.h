// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The cube that defines the grid to which all streamed positions of a scene are rounded.
//
//   position = origin + integer * step,   step = range / (2^bits - 1),   integer in 0 … 2^bits - 1
//
// range is a power of two and each coordinate of origin is a multiple of range/64, so both are exact in a Draco stream.
// Units: world units.
#ifndef LATTICED_CORE_FFD_PLAN_QUANTISATION_BOX_H_
#define LATTICED_CORE_FFD_PLAN_QUANTISATION_BOX_H_

#include <cstdint>
#include <optional>

#include "core/base/bounds.h"
#include "core/base/vec.h"

namespace latticed {

struct QuantisationBox {
  uint64_t id = 0;  // rises with every new box of a scene
  Vec3d origin;
  double range = 1;

  double step(int bits) const { return range / static_cast<double>((uint64_t{1} << bits) - 1); }
  bool Contains(const Bounds& bounds) const;
};

// Returns the smallest legal box around the bounds that leaves at least a quarter of its range as margin.
[[nodiscard]] QuantisationBox FitQuantisationBox(const Bounds& bounds, uint64_t id);

// Returns the box for new bounds, or nullopt to keep the current one. The box is replaced when the bounds leave it. It
// shrinks only when less than a quarter of the range is used and no gesture is open.
[[nodiscard]] std::optional<QuantisationBox> NextQuantisationBox(const QuantisationBox& current,
                                                                 const Bounds& bounds,
                                                                 bool gesture_open);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_QUANTISATION_BOX_H_
