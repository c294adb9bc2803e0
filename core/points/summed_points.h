// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points under several lattices that are turned against each other (core/ffd/turned/turned_lattice.h):
//
//   F(x) = x + sum_g (F_g(x) - x),   dx = sum_g dx_g
//
// Each lattice has an evaluator of its own, of the same points sorted by its own boxes; positions are sums of what these say,
// in their order. Normals are carried by the sum of all Jacobians, on the threads of the arena (point_columns.h).
//
// Layout   as point_derivatives.h; the control points of the lattices follow each other
// Memory   ForwardBytes and TransposeBytes: 24 bytes a point and direction, with normals 144 a point more
// Errors   those of the evaluators
// Threads  safe. The arena must outlive it.
#ifndef LATTICED_CORE_POINTS_SUMMED_POINTS_H_
#define LATTICED_CORE_POINTS_SUMMED_POINTS_H_

#include <memory>
#include <vector>

#include "core/points/point_evaluator.h"

namespace latticed {

class SummedPoints : public PointEvaluator {
 public:
  // One evaluator per lattice, in the order of their control points. Normals are those of the first one's points.
  SummedPoints(std::vector<std::shared_ptr<PointEvaluator>> lattices, CpuArena* arena);

  const SortedPoints& points() const override { return parts_[0].evaluator->points(); }
  size_t points_outside() const override { return points_outside_; }
  absl::Status Deform(std::span<const Vec3d> control_points, PointNormals normals, StopCheck stop,
                      std::span<Vec3d> out) override;
  absl::Status ApplyJacobian(std::span<const Vec3d> control_points, std::span<const Vec3d> tangents,
                             PointNormals normals, StopCheck stop, std::span<Vec3d> out) override;
  absl::Status ApplyJacobianTranspose(std::span<const Vec3d> control_points,
                                      std::span<const Vec3d> cotangents, PointNormals normals,
                                      StopCheck stop, std::span<Vec3d> gradients) override;
  uint64_t ForwardBytes(size_t directions, PointNormals normals) const override;
  uint64_t TransposeBytes(size_t directions, PointNormals normals) const override;
  uint64_t device_bytes() const override;

 private:
  struct Part {
    std::shared_ptr<PointEvaluator> evaluator;
    size_t first = 0, count = 0;  // its control points

    const SortedPoints& points() const { return evaluator->points(); }
    // Of one direction.
    std::span<const Vec3d> Own(std::span<const Vec3d> of_all) const {
      return of_all.subspan(first, count);
    }
  };

  // Of the sum, by point_columns.h.
  std::vector<Vec3d> Columns(std::span<const Vec3d> control_points) const;
  // The part of ApplyJacobian that one lattice is: adds how positions move, and how columns do unless `rates` is empty.
  absl::Status AddVelocities(const Part& part, std::span<const Vec3d> control_points,
                             std::span<const Vec3d> own_tangents, StopCheck stop,
                             std::span<Vec3d> velocities, std::span<Vec3d> rates) const;
  size_t MostControlPoints() const;

  std::vector<Part> parts_;
  CpuArena* const arena_;
  size_t control_points_ = 0;
  size_t points_outside_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_POINTS_SUMMED_POINTS_H_
