// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Places: where vertices lie on an axis, as integers.
//
//   place   = 65535 span + round(65535 fraction), span the ordinal of a non-empty span of knots
//   span of a patch whose corners' places have the sum S = max(0, ceil(S / 196605) - 1)
//
// Knots are whole multiples of 65535. The outside box is one span on each axis.
//
// Threads  immutable after construction
#ifndef LATTICED_CORE_PATCHES_PATCH_PLACES_H_
#define LATTICED_CORE_PATCHES_PATCH_PLACES_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/bounds.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"

namespace latticed {

inline constexpr uint32_t kPlacesPerSpan = 65'535;

using Places = std::array<uint32_t, 3>;  // by axis

// The ordinal of the span in which a patch lies. sum: of the places of its corners on the axis.
constexpr uint32_t SpanOfPatch(uint64_t sum) {
  constexpr uint64_t kSumPerSpan = 3 * kPlacesPerSpan;
  return sum == 0 ? 0 : static_cast<uint32_t>((sum - 1) / kSumPerSpan);
}

// The distinct knots of the domain on each axis.
class KnotPlanes {
 public:
  explicit KnotPlanes(const LatticeStructure& structure);

  uint32_t spans(int axis) const {
    return static_cast<uint32_t>(planes_[static_cast<size_t>(axis)].size()) - 1;
  }
  // Where a non-empty span begins, by its ordinal.
  double lower(int axis, uint32_t ordinal) const {
    return planes_[static_cast<size_t>(axis)][ordinal];
  }
  double upper(int axis, uint32_t ordinal) const {
    return planes_[static_cast<size_t>(axis)][ordinal + 1];
  }
  // The index k of the knot at the begin of the span: knots[k] < knots[k + 1].
  int knot_span(int axis, uint32_t ordinal) const {
    return spans_[static_cast<size_t>(axis)][ordinal];
  }
  // `parameter` is in the domain.
  Places PlacesOf(Vec3d parameter) const;

 private:
  std::array<std::vector<double>, 3> planes_;
  std::array<std::vector<int>, 3> spans_;
};

// The box of patches outside the frame: their bounds, extended where they are flat.
[[nodiscard]] Bounds OutsideBox(const Bounds& outside_pieces);
// `world` is in the box.
[[nodiscard]] Places OutsidePlaces(const Bounds& outside_box, Vec3d world);

}  // namespace latticed

#endif  // LATTICED_CORE_PATCHES_PATCH_PLACES_H_
