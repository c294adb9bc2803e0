// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view on the CPU: one buffer in wire layout, a kernel that fills it, an encoder that reads it.
//
// Errors   those of core/view/checked_view.h, of the kernel and of the encoder
// Threads  one thread at a time; Evaluate and Encode use the backend's arena and return when done
#ifndef LATTICED_CORE_CPU_CPU_VIEW_H_
#define LATTICED_CORE_CPU_CPU_VIEW_H_

#include <memory>

#include "core/cpu/cpu_context.h"
#include "core/cpu/host_buffer.h"
#include "core/cpu/vertex_kernel.h"
#include "core/view/checked_view.h"
#include "core/view/vertex_layout.h"
#include "core/view/view_encoder.h"

namespace latticed {

class CpuView : public CheckedView {
 public:
  // `vertices` has room for the view in the layout of core/view/vertex_layout.h.
  CpuView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
          std::unique_ptr<VertexKernel> kernel, std::shared_ptr<CpuContext> context,
          HostBuffer vertices);

  MemoryUse memory() const override;

 private:
  absl::Status EvaluateChunks(std::span<const Vec3d> control_points, const QuantisationBox& box,
                              std::span<const uint32_t> chunks) override {
    return kernel_->Evaluate(control_points, box, chunks, vertices_.span());
  }
  absl::Status ReadChunk(uint32_t chunk, std::span<uint8_t> out) override;
  absl::Status EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results,
                            TakeEarly early) override;
  std::span<const uint8_t> ChunkBytes(uint32_t chunk) const;

  VertexLayout layout_;
  std::shared_ptr<CpuContext> context_;
  ViewEncoder encoder_;
  std::unique_ptr<VertexKernel> kernel_;
  HostBuffer vertices_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_CPU_VIEW_H_
