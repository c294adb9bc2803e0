// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused pipeline on the CPU: from control points to vertices in one pass.
//
//   per frame  each knot box's control points become a polynomial about the box centre, in double
//   per group  of 16 patches of one box, in SIMD lanes (fused_kernel.h); with few segments R and its
//              Jacobian at each point (fused_direct-inl.h), otherwise:
//     compose  the box polynomial with each patch's affine map, exactly, into the bivariate power
//              basis of (x, t): x along the longest edge, t across it along the in-plane
//              perpendicular, so that normals do not depend on the triangle's shape
//     rows     collapse to polynomials in x, rows t and -t together; points by Horner with
//              derivative
//     edges    each from its own univariate polynomial about its midpoint, each corner by itself
//   In either form the points of edges and corners come from the same operations on the same bits,
//   whichever patch asks, so there are no cracks.
//   Edges and corners owned by another box (knot planes, seams) are evaluated there first and
//   copied in. Points whose normal is ill-conditioned go to the definition in double (DirectFfd).
//
// Threads  Evaluate may run on several threads for different vertices; it spreads over the arena
#ifndef LATTICED_CORE_CPU_FUSED_CPU_FUSED_H_
#define LATTICED_CORE_CPU_FUSED_CPU_FUSED_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "core/backend.h"
#include "core/view/cpu_arena.h"

namespace latticed {

enum class FusedOrder {
  kWire,   // point after point, as core/view/vertex_layout.h says
  kLanes,  // the kernel's own order, kFloat32 only: the fastest stores, for benchmarks
};

class FusedKernel {
 public:
  [[nodiscard]] static std::unique_ptr<FusedKernel> Create(std::shared_ptr<const DeformPlan> plan);
  virtual ~FusedKernel() = default;

  // Writes the vertices of `chunks` (and bit-identical ones of patches that share a lane group with
  // them). `vertices` holds the whole view in wire layout, chunk c from point
  // ChunkPatches(c)[0] * PointsPerPatch on; or, of kLanes, LaneOrderBytes.
  [[nodiscard]] virtual absl::Status Evaluate(std::span<const Vec3d> control_points,
                                              const QuantisationBox& box,
                                              std::span<const uint32_t> chunks,
                                              const ViewSpec& spec, std::span<uint8_t> vertices,
                                              CpuArena& arena,
                                              FusedOrder order = FusedOrder::kWire) const = 0;

  // The bytes of a whole view in lane order, kFloat32: for each group float [point][component][16
  // lanes].
  [[nodiscard]] virtual size_t LaneOrderBytes(const ViewSpec& spec) const = 0;
  // One chunk of lane-ordered vertices in wire layout.
  virtual void ReadLaneOrder(std::span<const uint8_t> vertices, const ViewSpec& spec,
                             uint32_t chunk, std::span<uint8_t> out) const = 0;

  [[nodiscard]] virtual uint64_t MemoryBytes() const = 0;
};

// "AVX-512", "AVX2", …: what run-time dispatch chose on this machine.
[[nodiscard]] std::string FusedTargetName();

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_FUSED_CPU_FUSED_H_
