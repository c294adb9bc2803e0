// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the edits of a lattice must keep: held control points, layers that are held at faces of the frame, mirror
// symmetry, the enclosed volume.
//
//   layers held at a face   1: C0, 2: C1, 3: C2 against the identity outside, as far as degree and simple knots allow,
//                           since the derivatives there depend on that many layers
//   mirror                  control points i and size - 1 - i of the axis move as mirror images
//
// Errors   Check: kInvalidArgument naming the field
// Threads  plain data and pure functions
#ifndef LATTICED_CORE_FFD_CONSTRAINTS_CONSTRAINTS_H_
#define LATTICED_CORE_FFD_CONSTRAINTS_CONSTRAINTS_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/ffd/lattice.h"

namespace latticed {

struct HeldLayers {
  int axis = 0;
  bool at_end = false;  // of the axis, else at its begin
  int layers = 1;       // 1 to kMostHeldLayers
  friend bool operator==(const HeldLayers&, const HeldLayers&) = default;
};
inline constexpr int kMostHeldLayers = 3;

struct KeptVolume {
  std::optional<int>
      axis;  // of the lattice, along which control points are moved; unset: in all directions
  std::optional<double> volume;  // world units cubed; unset: that of the mesh at rest
  friend bool operator==(const KeptVolume&, const KeptVolume&) = default;
};

struct Constraints {
  std::vector<uint32_t> held;  // control points
  std::vector<HeldLayers> held_layers;
  std::optional<int> mirror;  // axis
  std::optional<KeptVolume> volume;

  // Whether they say nothing of control points.
  bool points_are_free() const {
    return held.empty() && held_layers.empty() && !mirror.has_value();
  }
  size_t MemoryBytes() const {
    return held.size() * sizeof(uint32_t) + held_layers.size() * sizeof(HeldLayers);
  }
  friend bool operator==(const Constraints&, const Constraints&) = default;
};

// Whether a lattice of this structure can have them; `field` is their path.
[[nodiscard]] absl::Status Check(const Constraints& constraints, const LatticeStructure& structure,
                                 std::string_view field);
[[nodiscard]] absl::Status Check(const KeptVolume& kept, std::string_view field);

// The constraints after knots were inserted, which made `after` of `before`: a new control point is held if one that it
// is made from is held.
[[nodiscard]] Constraints AfterInsertion(const Constraints& constraints,
                                         const LatticeStructure& before,
                                         const LatticeStructure& after);
// Whether lattices of both structures have the same control points along the same knots. Frame and outside may differ.
[[nodiscard]] bool HaveSameNet(const LatticeStructure& a, const LatticeStructure& b);
// The constraints after a lattice of structure `after` took the place of one of `before`. The volume stays, and the layers, as
// many as there are. Single held points stay if both have the same net. Mirror symmetry ends where the new lattice cannot have
// it.
[[nodiscard]] Constraints AfterReplacement(const Constraints& constraints,
                                           const LatticeStructure& before,
                                           const LatticeStructure& after);

// The knot that mirrors `value`; nothing where that is `value` itself, to within kSameKnot of the domain.
[[nodiscard]] std::optional<double> MirroredKnot(const LatticeStructure& structure, int axis,
                                                 double value);
inline constexpr double kSameKnot = 1e-12;

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_CONSTRAINTS_CONSTRAINTS_H_
