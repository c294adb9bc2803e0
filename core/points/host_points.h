// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points that the host evaluates, on the threads of an arena.
//
// Errors   those of point_derivatives.h
// Threads  safe. The arena must outlive it.
#ifndef LATTICED_CORE_POINTS_HOST_POINTS_H_
#define LATTICED_CORE_POINTS_HOST_POINTS_H_

#include <memory>
#include <utility>

#include "core/points/point_evaluator.h"

namespace latticed {

class HostPoints : public PointEvaluator {
 public:
  HostPoints(std::shared_ptr<const SortedPoints> points, CpuArena* arena)
      : points_(std::move(points)), arena_(arena) {}

  const SortedPoints& points() const override { return *points_; }
  absl::Status Deform(std::span<const Vec3d> control_points, PointNormals normals, StopCheck stop,
                      std::span<Vec3d> out) override {
    return latticed::Deform(*points_, control_points, normals, *arena_, stop, out);
  }
  absl::Status ApplyJacobian(std::span<const Vec3d> control_points, std::span<const Vec3d> tangents,
                             PointNormals normals, StopCheck stop, std::span<Vec3d> out) override {
    return latticed::ApplyJacobian(*points_, control_points, tangents, normals, *arena_, stop, out);
  }
  absl::Status ApplyJacobianTranspose(std::span<const Vec3d> control_points,
                                      std::span<const Vec3d> cotangents, PointNormals normals,
                                      StopCheck stop, std::span<Vec3d> gradients) override {
    return latticed::ApplyJacobianTranspose(*points_, control_points, cotangents, normals, *arena_,
                                            stop, gradients);
  }
  uint64_t TransposeBytes(size_t directions, PointNormals /*normals*/) const override {
    return SumBytes(*points_, directions);
  }

 private:
  const std::shared_ptr<const SortedPoints> points_;
  CpuArena* const arena_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_POINTS_HOST_POINTS_H_
