// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view with a tolerance on the device. Twin of core/cpu/adaptive/adaptive_evaluator.h. An evaluation runs the kernels of
// adaptive_kernels.h, or those of another pipeline in their places (surface/cuda_adaptive_surface.h), one after the other,
// reads their results back once and waits for these, not for the vertices. It bounds the named chunks; levels, patterns and
// points are those of all patches.
//
// The tolerance is doubled until the view has at most as many points as spec.segments would give (ToleranceSteps of
// core/adaptive/edge_levels.h): a turn of the kernels after the bounds, and a read-back, for each doubling.
//
// A slice of a plan is evaluated in steps, and waits once more: for the bounds that it exchanges.
//
// Vertices get memory for the points that there are and a quarter more. An evaluation that has more points allocates
// anew, and runs the last kernel again.
//
// In float32, the error of a pattern is rounded by less than kFloatShare allows for.
//
// Errors   those of cuda_frame.h and device_buffer.h; kResourceExhausted where the vertices do not fit
// Threads  one at a time, on the lane
#ifndef LATTICED_CUDA_ADAPTIVE_CUDA_ADAPTIVE_EVALUATOR_H_
#define LATTICED_CUDA_ADAPTIVE_CUDA_ADAPTIVE_EVALUATOR_H_

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/backend.h"
#include "cuda/adaptive/adaptive_memory.h"
#include "cuda/adaptive/cuda_shared_bounds.h"
#include "cuda/adaptive/surface/cuda_adaptive_surface.h"
#include "cuda/device/launch_graph.h"
#include "cuda/device/pinned_memory.h"
#include "cuda/plan/device_plan.h"
#include "cuda/view/cuda_frame.h"

namespace latticed {

class CudaAdaptiveEvaluator {
 public:
  // spec.tolerance is above 0; `device_plan` was made for `pipeline`. Takes DeviceBytesFor, the plan's BytesToCome and
  // those of the surface from the reservation.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CudaAdaptiveEvaluator>> Create(
      std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
      Pipeline pipeline, const ViewSpec& spec, std::shared_ptr<CudaContext> context,
      std::shared_ptr<CudaLane> lane, DeviceReservation& from);
  // Waits for copies to its memory.
  ~CudaAdaptiveEvaluator();
  static absl::StatusOr<uint64_t> DeviceBytesFor(const DeformPlan& plan, Pipeline pipeline,
                                                 const ViewSpec& spec);
  // The most that HostBytes can be.
  static uint64_t HostBytesFor(const DeformPlan& plan);

  // As DeformView's. Waits for the results.
  [[nodiscard]] absl::Status Evaluate(std::span<const Vec3d> control_points,
                                      const QuantisationBox& box, std::span<const uint32_t> chunks);

  // For a slice, as in core/view/spanned/tolerance_slice.h.
  [[nodiscard]] absl::StatusOr<std::vector<Vec3d>> BoxReach() const;
  [[nodiscard]] absl::Status SetReach(std::span<const Vec3d> reach);
  [[nodiscard]] absl::Status ShareEdges(std::span<const uint32_t> edges);
  [[nodiscard]] absl::Status Bound(std::span<const Vec3d> control_points,
                                   const QuantisationBox& box, std::span<const uint32_t> chunks);
  [[nodiscard]] absl::StatusOr<std::span<const float>> SharedBounds() const;
  [[nodiscard]] absl::Status Choose(double curvature_tolerance,
                                    std::span<const float> shared_bounds);
  [[nodiscard]] absl::StatusOr<uint64_t> CountPoints() const;
  [[nodiscard]] absl::Status Finish();
  // Of the evaluation that runs.
  const QuantisationBox& box() const { return frame_->box; }

  std::span<const uint32_t> also_changed() const { return also_changed_; }
  PatternCodes Patterns() const;
  double certified_error() const { return certified_error_; }
  double curvature_tolerance() const { return curvature_tolerance_; }

  // The vertices of chunks [first, last), which lie one after the other. The stream may still compute them.
  DeviceSpan<const uint8_t> Vertices(uint32_t first, uint32_t last) const;
  // The number of a chunk's first point among all points; of chunk_count(), the number of points.
  uint64_t FirstPoint(uint32_t chunk) const { return chunk_first_[chunk]; }

  MemoryUse memory() const;

 private:
  struct Parts {
    CudaFrame frame;
    std::unique_ptr<CudaAdaptiveSurface> surface;
    AdaptiveMemory memory;
    DeviceBuffer<uint8_t> vertices;
    // Those of the last evaluation, whose codes others may keep, and room for the next ones: results_at_.
    std::array<std::shared_ptr<const PinnedBuffer>, 2> results;
    // The device copies results while it computes points.
    CudaStream copies;
    CudaEvent summed, read_back;
  };
  CudaAdaptiveEvaluator(std::shared_ptr<const DeformPlan> plan,
                        std::shared_ptr<DevicePlan> device_plan, const ViewSpec& spec,
                        std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
                        const kernels::PlanTables& tables, Parts parts);

  cudaStream_t stream() const { return lane_->stream().get(); }
  uint64_t capacity() const { return parts_.vertices.size() / BytesPerPoint(spec_); }
  absl::Status Launch(AdaptiveStage stage) const;
  kernels::AdaptiveLaunch LaunchFor(const QuantisationBox& box,
                                    std::span<const uint32_t> chunks) const;
  // The evaluation that runs.
  struct Frame {
    QuantisationBox box;
    std::span<const uint32_t> chunks;
    kernels::AdaptiveLaunch launch;
  };
  absl::Status Prepare(std::span<const Vec3d> control_points, const QuantisationBox& box,
                       std::span<const uint32_t> chunks);
  void SetTolerance(double curvature_tolerance);
  // The kernels up to the maxima, or up to the points of chunks, as one graph where no stages are marked.
  absl::Status LaunchBounds(bool with_patterns);
  // Patterns and the points of chunks, where LaunchBounds did without them or with another tolerance.
  absl::Status LaunchPatterns();
  // From the scan to the points.
  absl::Status LaunchPoints();
  // Allocates vertices for so many points, and computes them.
  absl::Status Grow(uint64_t points);
  void TakeResults();
  void KeepResults();
  // Of the evaluation that runs.
  uint8_t* incoming() const { return parts_.results[1 - results_at_]->data(); }
  AdaptiveResults results() const { return {*plan_, incoming()}; }

  const std::shared_ptr<const DeformPlan> plan_;
  const std::shared_ptr<DevicePlan> device_plan_;
  const ViewSpec spec_;
  const std::shared_ptr<CudaContext> context_;
  const std::shared_ptr<CudaLane> lane_;
  const kernels::PlanTables tables_;
  const uint64_t most_points_;
  Parts parts_;
  LaunchGraph graph_;
  std::optional<CudaSharedBounds> shared_;  // of a slice that has shared edges
  std::optional<Frame> frame_;
  // Of the last evaluation.
  size_t results_at_ = 0;
  std::span<const uint16_t> codes_;  // by patch, padded to whole chunks
  std::span<const uint64_t>
      chunk_first_;  // the first point of each chunk, then the number of points
  std::vector<uint32_t> also_changed_;
  double certified_error_ = 0;
  double curvature_tolerance_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_ADAPTIVE_CUDA_ADAPTIVE_EVALUATOR_H_
