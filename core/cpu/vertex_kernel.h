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
  // As DeformView::Evaluate. `vertices` is the whole view in the layout of core/view/vertex_layout.h.
  [[nodiscard]] virtual absl::Status Evaluate(std::span<const Vec3d> control_points,
                                              const QuantisationBox& box,
                                              std::span<const uint32_t> chunks,
                                              std::span<uint8_t> vertices) = 0;
  virtual MemoryUse memory() const = 0;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_VERTEX_KERNEL_H_
