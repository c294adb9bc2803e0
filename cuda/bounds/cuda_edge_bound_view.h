// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view of bounds alone on the device: one byte per edge, and no vertices. Twin of core/cpu/adaptive/bounds/edge_bound_view.h.
//
// An evaluation bounds the named patches, takes the largest bounds of all edges, and waits. Bytes that changed are in the
// host's memory then, so Read and Encode ask nothing of the device.
//
//   device   polynomials | bounds of patches | maxima, bytes of edges          host, pinned   bytes of edges | chunks changed
//
// Errors   those of core/view/checked_view.h; kResourceExhausted for device or pinned memory; kUnavailable when the device
//          is lost
// Threads  one thread at a time
#ifndef LATTICED_CUDA_BOUNDS_CUDA_EDGE_BOUND_VIEW_H_
#define LATTICED_CUDA_BOUNDS_CUDA_EDGE_BOUND_VIEW_H_

#include <memory>
#include <string_view>
#include <vector>

#include "core/view/checked_view.h"
#include "core/view/spanned/reach_slice.h"
#include "cuda/bounds/edge_bound_memory.h"
#include "cuda/device/launch_graph.h"
#include "cuda/device/pinned_memory.h"
#include "cuda/fused/polynomial_memory.h"
#include "cuda/plan/device_plan.h"
#include "cuda/view/cuda_frame.h"

namespace latticed {

class CudaEdgeBoundView : public CheckedView, public ReachSlice {
 public:
  // `device_plan` was made for kFused. Takes DeviceBytesFor, and the plan's
  // BytesToCome without normals, from the reservation.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CudaEdgeBoundView>> Create(
      std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
      const ViewSpec& spec, std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
      DeviceReservation& from);
  ~CudaEdgeBoundView() override;
  static uint64_t DeviceBytesFor(const DeformPlan& plan);
  // The most host memory that a view takes.
  static uint64_t HostBytesFor(const DeformPlan& plan);

  std::span<const uint32_t> also_changed() const override { return also_changed_; }
  MemoryUse memory() const override;
  ReachSlice* reach_slice() override { return this; }

  absl::StatusOr<std::vector<Vec3d>> BoxReach() override;
  absl::Status SetReach(std::span<const Vec3d> reach) override;

  // For measurements: the lane that Evaluate enqueues on. It marks the stages.
  CudaLane& lane() const { return *lane_; }

 private:
  struct Parts {
    CudaFrame frame;
    PolynomialMemory polynomials;
    EdgeBoundMemory memory;
    PinnedBuffer pinned;
  };
  CudaEdgeBoundView(std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
                    const ViewSpec& spec, std::shared_ptr<CudaContext> context,
                    std::shared_ptr<CudaLane> lane, const kernels::PlanTables& tables,
                    std::vector<uint32_t> first_edges, Parts parts);

  absl::Status EvaluateChunks(std::span<const Vec3d> control_points, const QuantisationBox& box,
                              std::span<const uint32_t> chunks) override;
  absl::Status ReadChunk(uint32_t chunk, std::span<uint8_t> out) override;
  size_t SizeOf(uint32_t chunk) const override { return Bytes(chunk).size(); }
  absl::Status EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results,
                            TakeEarly early) override;

  // `chunks`: how many are named.
  kernels::AdaptiveLaunch LaunchFor(size_t chunks) const;
  // All kernels, as one graph where no stages are marked.
  absl::Status Launch(const kernels::AdaptiveLaunch& launch);
  absl::Status LaunchStage(kernels::KernelCall call, std::string_view name) const;
  void FindAlsoChanged(std::span<const uint32_t> named);
  // Of the edges that a chunk uses first.
  std::span<const uint8_t> Bytes(uint32_t chunk) const;
  const uint32_t* changed() const;
  cudaStream_t stream() const { return lane_->stream().get(); }

  // The context comes first: members are destroyed in reverse order, and all others use it.
  const std::shared_ptr<CudaContext> context_;
  const std::shared_ptr<DevicePlan> device_plan_;
  const std::shared_ptr<CudaLane> lane_;
  const kernels::PlanTables tables_;
  const std::vector<uint32_t> first_edges_;  // by chunk
  Parts parts_;
  LaunchGraph graph_;
  std::vector<uint32_t> also_changed_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_BOUNDS_CUDA_EDGE_BOUND_VIEW_H_
