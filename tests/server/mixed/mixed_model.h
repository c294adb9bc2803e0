// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a scene on the unit cube must be after edits of several lattices: the lattices by number, what undo and redo bring back,
// the weights of the vertices, and the deformation by its definition in double (tests/support/lattice_definition.h).
//
//   x -> x + w(x) sum_k s_k (F_k(x) - x)        w: 1 for points of the world
//   J  = I + w sum_k s_k (J_k - I) + (sum_k s_k (F_k(x) - x)) grad(w)^T
//
// Threads  one at a time
#ifndef LATTICED_TESTS_SERVER_MIXED_MIXED_MODEL_H_
#define LATTICED_TESTS_SERVER_MIXED_MIXED_MODEL_H_

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "core/ffd/lattice.h"
#include "tests/support/lattice_definition.h"

namespace latticed::testing {

// The unit cube of twelve triangles.
inline constexpr std::array<Vec3d, 8> kCubeVertices{
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
inline constexpr std::array<std::array<uint32_t, 3>, 12> kCubeTriangles{{{3, 2, 1},
                                                                         {3, 1, 0},
                                                                         {4, 5, 6},
                                                                         {4, 6, 7},
                                                                         {0, 1, 5},
                                                                         {0, 5, 4},
                                                                         {1, 2, 6},
                                                                         {1, 6, 5},
                                                                         {2, 3, 7},
                                                                         {2, 7, 6},
                                                                         {3, 0, 4},
                                                                         {3, 4, 7}}};
using CubeWeights = std::optional<std::array<float, 8>>;

// What the edits of one number make, and what undo of them brings back.
struct NumberState {
  bool present = false;
  Lattice lattice;
  double strength = 1;
  std::vector<uint32_t> held;  // control points, ascending
  std::optional<int> mirror;   // the axis along which control points are mirror images
  CubeWeights weights;         // of number 0 alone, also where its lattice is not there
};

// Whether the control point or its mirror image is held.
[[nodiscard]] bool IsHeld(const NumberState& state, uint32_t point);
// Moves those of the points that are not held, and takes their mirror images along. Where both images are named, they go
// half-way to each other's images.
void MoveAllowed(NumberState& state, const std::set<uint32_t>& points, Vec3d offset);
// The direction across the plane of the mirror, of length 1. There must be one.
[[nodiscard]] Vec3d MirrorNormal(const NumberState& state);

// A point of the cube's surface.
struct CubePlace {
  size_t triangle = 0;
  std::array<double, 3> barycentrics{};
  Vec3d rest;
};

class MixedModel {
 public:
  // A step of the number: its state becomes `next`.
  void Do(uint32_t number, NumberState next);
  // Whether there is such a step.
  bool CanUndo(uint32_t number) { return !numbers_[number].done.empty(); }
  bool CanRedo(uint32_t number) { return !numbers_[number].undone.empty(); }
  void Undo(uint32_t number);
  void Redo(uint32_t number);
  // As a cancelled gesture does.
  void ForgetUndone(uint32_t number) { numbers_[number].undone.clear(); }
  // Whether any lattice is there after an undo or redo of the number.
  [[nodiscard]] bool LeavesAny(uint32_t number, bool undo) const;

  // The first state of a number.
  void Begin(uint32_t number, NumberState state) { numbers_[number].now = std::move(state); }
  NumberState& Now(uint32_t number) { return numbers_[number].now; }
  // Those that have, or had, a lattice are 0 to this.
  uint32_t count() const { return static_cast<uint32_t>(numbers_.size()); }
  [[nodiscard]] std::vector<uint32_t> Present() const;
  const CubeWeights& weights() const { return numbers_.at(0).now.weights; }

  // The lattices as they are now.
  [[nodiscard]] std::vector<LatticeDefinition> Definitions() const;
  [[nodiscard]] double WeightAt(const CubePlace& place) const;
  // Where `lattices`, those of Definitions(), put it. `within`: as in LatticeDefinition. The Jacobian is that of a map of
  // space in which the weight changes in the triangle's plane alone.
  [[nodiscard]] DeformedPoint SurfaceAt(std::span<const LatticeDefinition> lattices,
                                        const CubePlace& place, Vec3d within) const;

 private:
  [[nodiscard]] Vec3d WeightGradient(size_t triangle) const;

  struct History {
    NumberState now;
    std::vector<NumberState> done, undone;
  };
  std::map<uint32_t, History> numbers_;
};

// The place of the surface at or next to `rest`; among several triangles of one plane the one that it is deepest in.
[[nodiscard]] CubePlace PlaceAt(Vec3d rest);
// The triangles that have the point, to within 1e-9.
[[nodiscard]] std::vector<CubePlace> PlacesAt(Vec3d rest);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_MIXED_MIXED_MODEL_H_
