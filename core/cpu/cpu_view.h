// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view on the CPU: one buffer in wire layout, a kernel that fills it, an encoder that reads it.
//
// Errors   kFailedPrecondition, reason NOT_EVALUATED, before the first Evaluate;
//          kInvalidArgument for a chunk that is not there, a first or re-boxed Evaluate that does
//          not name all chunks, or an encoding of another format; kResourceExhausted for memory
// Threads  one thread at a time; Evaluate and Encode use the backend's arena and return when done
#ifndef LATTICED_CORE_CPU_CPU_VIEW_H_
#define LATTICED_CORE_CPU_CPU_VIEW_H_

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/backend.h"
#include "core/cpu/cpu_context.h"
#include "core/cpu/host_buffer.h"
#include "core/cpu/vertex_kernel.h"
#include "core/cpu/vertex_layout.h"

namespace latticed {

class CpuView : public DeformView {
 public:
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<CpuView>> Create(
      std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
      std::unique_ptr<VertexKernel> kernel, std::shared_ptr<CpuContext> context);

  const ViewSpec& spec() const override { return spec_; }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override;
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override;
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding) override;
  MemoryUse memory() const override;

 private:
  CpuView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
          std::unique_ptr<VertexKernel> kernel, std::shared_ptr<CpuContext> context,
          HostBuffer vertices);

  absl::Status CheckChunk(uint32_t chunk) const;
  absl::Status CheckEvaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                             std::span<const uint32_t> chunks) const;
  // In wire order views only.
  std::span<const uint8_t> ChunkBytes(uint32_t chunk) const;
  void CopyChunk(uint32_t chunk, std::span<uint8_t> out) const;
  absl::StatusOr<std::vector<uint8_t>> EncodeChunk(uint32_t chunk, Encoding encoding) const;

  std::shared_ptr<const DeformPlan> plan_;
  ViewSpec spec_;
  VertexLayout layout_;
  std::shared_ptr<CpuContext> context_;
  std::unique_ptr<VertexKernel> kernel_;
  HostBuffer vertices_;
  std::vector<std::array<uint32_t, 3>> triangles_;  // of a full chunk; made for kDracoMesh
  std::optional<QuantisationBox> box_;              // of the last Evaluate
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_CPU_VIEW_H_
