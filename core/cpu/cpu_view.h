// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view on the CPU: one buffer in wire layout, a kernel that fills it, an encoder that reads it.
//
// Errors   those of core/view/view_contract.h; kResourceExhausted for memory
// Threads  one thread at a time; Evaluate and Encode use the backend's arena and return when done
#ifndef LATTICED_CORE_CPU_CPU_VIEW_H_
#define LATTICED_CORE_CPU_CPU_VIEW_H_

#include <memory>
#include <vector>

#include "core/backend.h"
#include "core/cpu/cpu_context.h"
#include "core/cpu/host_buffer.h"
#include "core/cpu/vertex_kernel.h"
#include "core/view/vertex_layout.h"
#include "core/view/view_contract.h"
#include "core/view/view_encoder.h"

namespace latticed {

class CpuView : public DeformView {
 public:
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CpuView>> Create(
      std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
      std::unique_ptr<VertexKernel> kernel, std::shared_ptr<CpuContext> context);

  const ViewSpec& spec() const override { return contract_.spec(); }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override;
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override;
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding,
                                                  std::span<VertexDigest> digests) override;
  MemoryUse memory() const override;

 private:
  CpuView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
          std::unique_ptr<VertexKernel> kernel, std::shared_ptr<CpuContext> context,
          HostBuffer vertices);

  std::span<const uint8_t> ChunkBytes(uint32_t chunk) const;

  std::shared_ptr<const DeformPlan> plan_;
  VertexLayout layout_;
  ViewContract contract_;
  std::shared_ptr<CpuContext> context_;
  ViewEncoder encoder_;
  std::unique_ptr<VertexKernel> kernel_;
  HostBuffer vertices_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_CPU_VIEW_H_
