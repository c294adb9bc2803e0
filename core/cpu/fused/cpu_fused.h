// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused pipeline on the CPU: from control points to vertices in one pass.
//
//   per frame  The control points of each knot box become a polynomial about the box's centre, in double.
//   per group  A group is 16 patches of one box, one per SIMD lane (fused_kernel.h). With few segments the kernel
//              evaluates R and its Jacobian at each point (fused_direct-inl.h). With more it takes these steps:
//     compose  Compose the box polynomial with each patch's affine map, exactly. The result is a bivariate
//              polynomial in (x, t): x runs along the first edge, t along its perpendicular in the plane of
//              the source triangle. Normals therefore do not depend on the triangle's shape.
//     rows     Collapse it to polynomials in x, for the rows t and -t together. Evaluate the points of a row by
//              Horner's rule, with the derivative.
//     edges    Evaluate each edge from its own univariate polynomial about its midpoint, each corner by itself.
//
// In either form, all patches compute a shared point by the same operations on the same bits: there are no cracks.
// An edge or corner that another box owns (knot planes, seams) is evaluated there first and then copied.
// An ill-conditioned normal is replaced by that of the definition in double (DirectFfd).
//
// Threads  Evaluate may run on several threads for different vertices; it uses the threads of the arena
#ifndef LATTICED_CORE_CPU_FUSED_CPU_FUSED_H_
#define LATTICED_CORE_CPU_FUSED_CPU_FUSED_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "core/backend.h"
#include "core/cpu/fused/fused_plan.h"
#include "core/view/cpu_arena.h"

namespace latticed {

enum class FusedOrder {
  kWire,   // point after point, as core/view/vertex_layout.h says
  kLanes,  // the kernel's own order, kFloat32 only: the fastest stores, for benchmarks
};

class FusedKernel {
 public:
  [[nodiscard]] static std::unique_ptr<FusedKernel> Create(
      std::shared_ptr<const fused::FusedPlan> plan);
  virtual ~FusedKernel() = default;

  // Writes the vertices of `chunks`. Patches that share a lane group with them are written too, with the same bits.
  // `vertices` holds the whole view: in wire layout, where chunk c begins at point ChunkPatches(c)[0] * PointsPerPatch,
  // or with kLanes the LaneOrderBytes of lane order.
  [[nodiscard]] virtual absl::Status Evaluate(std::span<const Vec3d> control_points,
                                              const QuantisationBox& box,
                                              std::span<const uint32_t> chunks,
                                              const ViewSpec& spec, std::span<uint8_t> vertices,
                                              CpuArena& arena,
                                              FusedOrder order = FusedOrder::kWire) const = 0;

  // The size of a whole view in lane order, kFloat32: float [group][point][component][16 lanes].
  [[nodiscard]] virtual size_t LaneOrderBytes(const ViewSpec& spec) const = 0;
  // Copies one chunk of lane-ordered vertices to `out`, in wire layout.
  virtual void ReadLaneOrder(std::span<const uint8_t> vertices, const ViewSpec& spec,
                             uint32_t chunk, std::span<uint8_t> out) const = 0;
};

// The instruction set that was chosen at run time on this machine: "AVX-512", "AVX2", ….
[[nodiscard]] std::string FusedTargetName();

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_FUSED_CPU_FUSED_H_
