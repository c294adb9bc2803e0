// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points that a device keeps and evaluates. Twin of core/points/host_points.h.
//
//   host                              bus        device, on a lane of the call
//   ──────────────────────────────────────────────────────────────────────────────────────────
//   polynomials of boxes             ───────>
//   cotangents of a direction        ───────>    SumCall, AddCall
//   transposed map, box after box    <───────    sums of boxes
//
//   polynomials, or their velocities ───────>    DeformCall, OutsideCall
//   the answer                       <───────    vectors of a direction
//
// Directions take turns, so a call takes device memory for one of them. The host's part depends on the number of boxes with
// points, not on the number of points.
//
// Errors   those of point_evaluator.h
// Threads  safe: each call borrows a lane and waits for it
#ifndef LATTICED_CUDA_POINTS_CUDA_POINTS_H_
#define LATTICED_CUDA_POINTS_CUDA_POINTS_H_

#include <memory>

#include "absl/status/statusor.h"
#include "core/points/point_evaluator.h"
#include "cuda/device/cuda_context.h"

namespace latticed {

// Waits for the upload.
[[nodiscard]] absl::StatusOr<std::shared_ptr<PointEvaluator>> MakeCudaPoints(
    std::shared_ptr<const SortedPoints> points, std::shared_ptr<CudaContext> context);

}  // namespace latticed

#endif  // LATTICED_CUDA_POINTS_CUDA_POINTS_H_
