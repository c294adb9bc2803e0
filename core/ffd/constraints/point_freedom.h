// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How the control points of one structure may move under constraints.
//
//   held      by index, by a layer, or because its mirror image is held
//   mirror    p' = p - 2 (n . (p - c)) n at the image, with n the direction of the axis and c the frame's centre. A
//             control point in the middle of the axis stays in the plane.
//
// Errors   none: the constraints were checked
// Threads  immutable
#ifndef LATTICED_CORE_FFD_CONSTRAINTS_POINT_FREEDOM_H_
#define LATTICED_CORE_FFD_CONSTRAINTS_POINT_FREEDOM_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/constraints/constraints.h"
#include "core/ffd/lattice.h"

namespace latticed {

class PointFreedom {
 public:
  PointFreedom(const Constraints& constraints, const LatticeStructure& structure);

  bool is_held(size_t index) const { return held_[index]; }
  bool is_mirrored() const { return mirror_.has_value(); }
  // The point's mirror image: itself in the middle of the axis. Only where is_mirrored().
  size_t ImageOf(size_t index) const;
  // A direction, seen in the mirror.
  Vec3d Reflect(Vec3d direction) const { return direction - 2 * Along(direction); }
  // The part of a direction across the mirror's plane.
  Vec3d Along(Vec3d direction) const { return Dot(direction, mirror_->normal) * mirror_->normal; }

  // After the control points `named` were written: takes their images with them. Where both of a pair were written, they
  // go half-way to each other's images, unless they are images to within rounding already. A point that lies bit for bit
  // at its identity position has its image there as well, so that seams stay attached. Returns the images that it wrote.
  std::vector<uint32_t> Symmetrise(std::span<const uint32_t> named,
                                   std::vector<Vec3d>& control_points) const;
  // Makes moves of all control points symmetric: the nearest ones that are.
  void SymmetriseMoves(std::vector<Vec3d>& moves) const;

 private:
  struct Mirror {
    size_t axis = 0;
    Vec3d normal;  // unit
    Vec3d centre;
    double rounding = 0;  // world units
  };
  Vec3d Image(Vec3d point) const { return mirror_->centre + Reflect(point - mirror_->centre); }

  std::array<size_t, 3> size_{};
  std::vector<bool> held_;
  std::optional<Mirror> mirror_;
  std::vector<Vec3d> identity_;  // with a mirror
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_CONSTRAINTS_POINT_FREEDOM_H_
