// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Brings every shared position in a view's vertices to its owner's, by the tables of
// core/ffd/shared_points.h.
//
// Threads  uses those of the arena and returns when done
#ifndef LATTICED_CORE_CPU_GEMM_COPY_SHARED_POINTS_H_
#define LATTICED_CORE_CPU_GEMM_COPY_SHARED_POINTS_H_

#include <cstdint>
#include <span>

#include "core/ffd/shared_points.h"
#include "core/view/cpu_arena.h"
#include "core/view/vertex_layout.h"

namespace latticed {

void CopySharedPoints(const SharedPoints& shared, const DeformPlan& plan,
                      std::span<const Vec3d> control_points, const VertexLayout& layout,
                      const VertexWriter& writer, int segments, std::span<uint8_t> vertices,
                      CpuArena& arena);

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_GEMM_COPY_SHARED_POINTS_H_
