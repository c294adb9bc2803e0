// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points of the world at rest, sorted by the knot box that holds them, for point_derivatives.h.
//
//   place      0 ............................................. size()
//   points     | box 0 | box 1        | ...      | outside the frame |
//   runs       | 0     | 1     | 2    | ...      |                        at most kRunPoints of one box each
//
// The sort is stable, so the order depends on the points and the structure alone. Runs are the unit of work and of sums:
// their number does not depend on the number of threads.
//
// Points of a mesh with vertex weights (core/ffd/weights/vertex_weights.h) have weights. Points without follow the lattice.
//
// Layout   per place: x, y, z in three arrays; the normal in three more, if there are normals; the point's number; its
//          weight, if there are weights
// Memory   28 bytes a point, with normals 24 more, with weights 32 more; Make takes 4 more a point while it runs
// Units    world units
// Errors   none: points are finite and fewer than 2^32
// Threads  immutable; Make runs on the threads of the arena
#ifndef LATTICED_CORE_POINTS_SORTED_POINTS_H_
#define LATTICED_CORE_POINTS_SORTED_POINTS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/points/box_map.h"
#include "core/view/cpu_arena.h"

namespace latticed {

// The weight at a point of a mesh, and its gradient in the triangle that has the point.
struct PointWeight {
  double weight = 1;
  Vec3d gradient;
};

class SortedPoints {
 public:
  static constexpr size_t kRunPoints = 8'192;
  struct Run {
    size_t first = 0;
    uint32_t count = 0;
    uint32_t box = 0;
  };

  // `normals` is empty, or has one per point: of unit length, or zero where a point has none. `weights` is empty, or has
  // one per point.
  SortedPoints(const LatticeStructure& structure, std::span<const Vec3d> points,
               std::span<const Vec3d> normals, CpuArena& arena,
               std::span<const PointWeight> weights = {});
  // The same points under another structure, with their normals or without. Takes 24 bytes a point more while it runs, with
  // normals 24 more, with weights 32 more.
  [[nodiscard]] SortedPoints Resorted(const LatticeStructure& structure, CpuArena& arena,
                                      bool with_normals = true) const;

  const BoxMaps& boxes() const { return boxes_; }
  size_t size() const { return order_.size(); }
  // Points in the frame come first; those from this place on are outside.
  size_t inside() const { return inside_; }
  bool has_normals() const { return !normal_[0].empty(); }
  bool has_weights() const { return !weight_.empty(); }
  // Of the points inside.
  const std::vector<Run>& runs() const { return runs_; }
  // The number of the point at each place, in the order in which they were given.
  const std::vector<uint32_t>& order() const { return order_; }
  const double* world(size_t axis) const { return world_[axis].data(); }
  const double* normal(size_t axis) const {
    return normal_[axis].data();
  }  // only if it has normals
  Vec3d WorldAt(size_t place) const { return At(world_, place); }
  Vec3d NormalAt(size_t place) const { return At(normal_, place); }
  // By place; empty without weights.
  std::span<const PointWeight> weights() const { return weight_; }
  [[nodiscard]] uint64_t MemoryBytes() const;
  [[nodiscard]] static uint64_t BytesFor(uint64_t points, bool with_normals, bool with_weights);

 private:
  using Arrays = std::array<std::vector<double>, 3>;
  static Vec3d At(const Arrays& arrays, size_t place) {
    return {arrays[0][place], arrays[1][place], arrays[2][place]};
  }
  void MakeRuns(std::span<const size_t> first_of_box);

  BoxMaps boxes_;
  Arrays world_, normal_;
  std::vector<PointWeight> weight_;
  std::vector<uint32_t> order_;
  std::vector<Run> runs_;
  size_t inside_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_POINTS_SORTED_POINTS_H_
