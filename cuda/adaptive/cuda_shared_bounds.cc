// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/adaptive/cuda_shared_bounds.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"

namespace latticed {
namespace {

constexpr char kSharedPurpose[] = "levels";
constexpr char kCopy[] = "the copy of shared bounds";

}  // namespace

absl::StatusOr<CudaSharedBounds> CudaSharedBounds::Create(std::span<const uint32_t> edges,
                                                          uint32_t* edge_maxima,
                                                          CudaContext& context,
                                                          std::shared_ptr<CudaLane> lane) {
  const cudaStream_t stream = lane->stream().get();
  LATTICED_ASSIGN_OR_RETURN(auto of_device, DeviceBuffer<uint32_t>::Upload(
                                                context.memory(), kSharedPurpose, edges, stream));
  LATTICED_ASSIGN_OR_RETURN(
      auto bounds,
      DeviceBuffer<float>::Create(context.memory(), kSharedPurpose, edges.size(), stream));
  LATTICED_ASSIGN_OR_RETURN(auto pinned, context.pinned().Borrow(2 * edges.size_bytes()));
  LATTICED_ASSIGN_OR_RETURN(auto taken, CudaEvent::Create());
  return CudaSharedBounds(edge_maxima, std::move(lane), std::move(of_device), std::move(bounds),
                          std::move(pinned), std::move(taken));
}

CudaSharedBounds::CudaSharedBounds(uint32_t* edge_maxima, std::shared_ptr<CudaLane> lane,
                                   DeviceBuffer<uint32_t> edges, DeviceBuffer<float> bounds,
                                   PinnedBuffer pinned, CudaEvent taken)
    : edge_maxima_(edge_maxima),
      lane_(std::move(lane)),
      edges_(std::move(edges)),
      bounds_(std::move(bounds)),
      pinned_(std::move(pinned)),
      taken_(std::move(taken)) {}

kernels::SharedMaxima CudaSharedBounds::Launch() const {
  return {.edges = edges_.data(),
          .count = static_cast<uint32_t>(edges_.size()),
          .edge_maxima = edge_maxima_,
          .bounds = bounds_.data()};
}

absl::Status CudaSharedBounds::Take() {
  const cudaStream_t stream = lane_->stream().get();
  LATTICED_RETURN_IF_ERROR(CudaStatus(kernels::TakeSharedCall(Launch()).Launch(stream), kCopy));
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaMemcpyAsync(taken_bounds(), bounds_.data(), bounds_.size_bytes(),
                                 cudaMemcpyDeviceToHost, stream),
                 kCopy));
  lane_->Enqueued("shared");
  return taken_.Record(stream);
}

absl::StatusOr<std::span<const float>> CudaSharedBounds::Wait() const {
  LATTICED_RETURN_IF_ERROR(taken_.Synchronize());
  return std::span<const float>(taken_bounds(), edges_.size());
}

absl::Status CudaSharedBounds::Raise(std::span<const float> bounds) {
  const cudaStream_t stream = lane_->stream().get();
  std::ranges::copy(bounds, raised_bounds());
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaMemcpyAsync(bounds_.data(), raised_bounds(), bounds_.size_bytes(),
                                 cudaMemcpyHostToDevice, stream),
                 kCopy));
  LATTICED_RETURN_IF_ERROR(CudaStatus(kernels::RaiseSharedCall(Launch()).Launch(stream), kCopy));
  lane_->Enqueued("raise");
  return absl::OkStatus();
}

}  // namespace latticed
