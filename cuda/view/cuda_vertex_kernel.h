// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Computes the vertices of a CUDA view. Each kind of pipeline has an implementation. Twin of
// core/cpu/vertex_kernel.h.
//
// Threads  one at a time; work is enqueued on the lane that the kernel was made with; nothing
//          waits, except that ToWireOrder may wait until the list of its last call is copied
#ifndef LATTICED_CUDA_VIEW_CUDA_VERTEX_KERNEL_H_
#define LATTICED_CUDA_VIEW_CUDA_VERTEX_KERNEL_H_

#include <cstdint>
#include <memory>
#include <span>

#include "absl/status/status.h"
#include "core/backend.h"
#include "cuda/device/device_span.h"
#include "cuda/plan/plan_tables.h"
#include "cuda/view/cuda_frame.h"

namespace latticed {

// The mode of normals as the kernels name it.
[[nodiscard]] inline kernels::Normals NormalsOf(NormalMode mode) {
  if (mode == NormalMode::kNone) return kernels::Normals::kNone;
  return mode == NormalMode::kFacet ? kernels::Normals::kFacet : kernels::Normals::kSmooth;
}

class CudaVertexKernel {
 public:
  virtual ~CudaVertexKernel() = default;
  // As DeformView::Evaluate. Sends `frame`, which is staged. `vertices` is the whole view, in the
  // layout of core/view/vertex_layout.h or in the kernel's own order.
  [[nodiscard]] virtual absl::Status Evaluate(const CudaFrame& frame, const QuantisationBox& box,
                                              std::span<const uint32_t> chunks,
                                              DeviceSpan<uint8_t> vertices) = 0;
  virtual MemoryUse memory() const = 0;
  // For CudaFrame. Null where the kernel reads the whole lattice.
  virtual std::shared_ptr<const ChunkNeeds> chunk_needs() const { return nullptr; }

  // The size of `vertices` if the kernel keeps them in its own order, else 0. ToWireOrder of these
  // kernels writes chunks in wire order, one after the other.
  virtual size_t OwnOrderBytes() const { return 0; }
  [[nodiscard]] virtual absl::Status ToWireOrder(DeviceSpan<const uint8_t> /*vertices*/,
                                                 std::span<const uint32_t> /*chunks*/,
                                                 DeviceSpan<uint8_t> /*out*/) {
    return absl::InternalError("the vertices are in wire order already");
  }
};

}  // namespace latticed

#endif  // LATTICED_CUDA_VIEW_CUDA_VERTEX_KERNEL_H_
