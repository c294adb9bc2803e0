// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view on the device. It has a vertex buffer, a kernel that fills it, and a lane of its own. Twin
// of core/cpu/cpu_view.h.
//
// Evaluate enqueues and returns. Read and Encode wait for this view's lane only, and report what
// failed on the device since the last wait. Streams are written on the device if HasDeviceWriter
// (device_writer.h), since the device writes the same bytes.
//
// Errors   those of core/view/checked_view.h; kResourceExhausted for device or pinned memory;
//          kUnavailable when the device is lost
// Threads  one thread at a time; Encode uses the context's arena and returns when done
#ifndef LATTICED_CUDA_VIEW_CUDA_VIEW_H_
#define LATTICED_CUDA_VIEW_CUDA_VIEW_H_

#include <memory>
#include <vector>

#include "core/view/checked_view.h"
#include "core/view/vertex_layout.h"
#include "core/view/view_encoder.h"
#include "cuda/view/cuda_frame.h"
#include "cuda/view/cuda_vertex_kernel.h"
#include "cuda/view/device_staging.h"
#include "cuda/view/device_view_encoder.h"

namespace latticed {

class CudaView : public CheckedView {
 public:
  // `kernel` works on `lane`. Takes DeviceBytesFor from the reservation, with the kernel's
  // OwnOrderBytes and whether it has chunk_needs.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<DeformView>> Create(
      std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
      std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
      std::unique_ptr<CudaVertexKernel> kernel, DeviceReservation& from);
  static uint64_t DeviceBytesFor(const DeformPlan& plan, const ViewSpec& spec,
                                 size_t own_order_bytes, bool has_chunk_needs);
  // host_bytes and encode_batch of ViewTraits.
  static uint64_t HostBytesFor(const DeformPlan& plan, const ViewSpec& spec);
  static size_t EncodeBatch(const CudaContext& context);
  ~CudaView() override;

  MemoryUse memory() const override;

  // For measurements: the lane that Evaluate enqueues on. It marks the stages.
  CudaLane& lane() const { return *lane_; }

 private:
  CudaView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
           std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
           std::unique_ptr<CudaVertexKernel> kernel, CudaFrame frame,
           DeviceBuffer<uint8_t> vertices);
  absl::Status EvaluateChunks(std::span<const Vec3d> control_points, const QuantisationBox& box,
                              std::span<const uint32_t> chunks) override;
  absl::Status ReadChunk(uint32_t chunk, std::span<uint8_t> out) override;
  absl::Status EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results,
                            TakeEarly early) override;
  absl::Status EncodeOnHost(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results);

  // The context comes first: members are destroyed in reverse order, and all others use it.
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
  VertexLayout layout_;
  ViewEncoder encoder_;
  std::unique_ptr<CudaVertexKernel> kernel_;
  CudaFrame frame_;
  DeviceBuffer<uint8_t> vertices_;
  DeviceStaging staging_;
  DeviceViewEncoder device_encoder_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_VIEW_CUDA_VIEW_H_
