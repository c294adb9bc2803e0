// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a CPU view computes its vertices: one implementation per kind of pipeline.
#ifndef LATTICED_CORE_CPU_VERTEX_KERNEL_H_
#define LATTICED_CORE_CPU_VERTEX_KERNEL_H_

#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "core/backend.h"

namespace latticed {

class VertexKernel {
 public:
  virtual ~VertexKernel() = default;
  // As DeformView::EvaluateInParts; `vertices` is the whole view in the layout of
  // core/view/vertex_layout.h.
  [[nodiscard]] virtual absl::Status Evaluate(std::span<const Vec3d> control_points,
                                              const QuantisationBox& box,
                                              std::span<const uint32_t> chunks,
                                              std::span<uint8_t> vertices,
                                              DeformView::Between between) = 0;
  virtual MemoryUse memory() const = 0;

  // Bytes of `vertices` where they are not those of the wire layout, else 0. A kernel that keeps an
  // order of its own copies chunks out by ReadChunk.
  virtual size_t OwnOrderBytes() const { return 0; }
  virtual void ReadChunk(std::span<const uint8_t> /*vertices*/, uint32_t /*chunk*/,
                         std::span<uint8_t> /*out*/) const {}
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_VERTEX_KERNEL_H_
