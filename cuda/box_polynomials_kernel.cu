// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The polynomial of each knot box from its control points, one warp a box, a lane a coefficient; in
// double, rounded once. Twin of core/cpu/box_polynomials.h.
#include "cuda/fused_kernels.h"
#include "cuda/launch.cuh"

namespace latticed::kernels {
namespace {

constexpr unsigned kLanes = 32, kAllLanes = ~0u;

struct Coefficient {
  int power[3];  // of l0, l1, l2
  bool used;     // the last lanes have none
};

__device__ Coefficient CoefficientAt(const FusedTables& tables, int index) {
  const int n1 = tables.degree[1] + 1, n2 = tables.degree[2] + 1;
  const int a = index / (n1 * n2);
  return {{a, index / n2 % n1, index % n2}, a <= tables.degree[0]};
}

__device__ Vec3d Contract(const PlanTables& plan, const FusedTables& tables,
                          const Vec3d* control_points, const int* span, const int* power) {
  const double* basis[3];
  int step[3];
  size_t first = 0;
  for (int i = 0; i < 3; ++i) {
    const int axis = tables.axis[i];
    basis[i] = tables.basis[i] + 16 * span[axis] + power[i];
    step[i] = axis == 0 ? 1 : axis == 1 ? plan.size[0] : plan.size[0] * plan.size[1];
    first += static_cast<size_t>((span[axis] - tables.degree[i]) * step[i]);
  }
  Vec3d sum;
  for (int r = 0; r <= tables.degree[0]; ++r) {
    for (int s = 0; s <= tables.degree[1]; ++s) {
      const double weight = basis[0][4 * r] * basis[1][4 * s];
      const Vec3d* row = control_points + first + r * step[0] + s * step[1];
#pragma unroll
      for (int t = 0; t <= limits::kMaxDegree; ++t) {
        if (t <= tables.degree[2]) sum += (weight * basis[2][4 * t]) * row[t * step[2]];
      }
    }
  }
  return sum;
}

// The identity map: l0, l1, l2 scaled to the box.
__device__ Vec3d Identity(const PlanTables&, const FusedTables& tables, const FusedBox& box,
                          const int* power) {
  const int degree = power[0] + power[1] + power[2];
  if (degree == 0) return box.centre;
  Vec3d result;
  if (degree > 1) return result;
  const int axis = tables.axis[power[0] == 1 ? 0 : power[1] == 1 ? 1 : 2];
  result[axis] = 1 / box.inverse_width[axis];
  return result;
}

__device__ double WarpSum(double x) {
  for (unsigned step = kLanes / 2; step > 0; step /= 2) x += __shfl_xor_sync(kAllLanes, x, step);
  return x;
}

// Length of the gradient of l_i by world position.
__device__ double Gradient(const PlanTables& plan, const FusedTables& tables, const FusedBox& box,
                           bool outside, int i) {
  const int axis = tables.axis[i];
  if (outside) return box.inverse_width[axis];
  const Vec3d row{plan.parameter_by_world[0][axis], plan.parameter_by_world[1][axis],
                  plan.parameter_by_world[2][axis]};
  return Norm(row) * box.inverse_width[axis];
}

__global__ void __launch_bounds__(kBlockThreads)
    BoxPolynomialsKernel(const __grid_constant__ PlanTables plan,
                         const __grid_constant__ FusedTables tables, const Vec3d* control_points,
                         BoxPolynomials out) {
  const size_t number = Item() / kLanes;
  if (number >= tables.box_count) return;
  const int lane = static_cast<int>(threadIdx.x % kLanes);
  const bool outside = number == plan.outside_box;
  const FusedBox box = tables.boxes[number];
  const int stride = CoefficientStride(tables.degree[0], tables.degree[1], tables.degree[2]);
  float* row = out.coefficients + number * 3 * static_cast<size_t>(stride);
  Vec3d slope[3];  // this lane's part of a bound of |dR / dl_i|, by component; |l| <= 1/2
  for (int index = lane; index < stride; index += kLanes) {
    const Coefficient at = CoefficientAt(tables, index);
    Vec3d c;
    if (at.used) {
      c = outside ? Identity(plan, tables, box, at.power)
                  : Contract(plan, tables, control_points, plan.boxes[number].span, at.power);
      c = out.scale * c;
      if (index == 0) c += out.offset;
    }
    const Vec3d size{std::abs(c.x), std::abs(c.y), std::abs(c.z)};
    const int degree = at.power[0] + at.power[1] + at.power[2];
    for (int i = 0; i < 3; ++i) slope[i] += ldexp(double(at.power[i]), 1 - degree) * size;
    for (int component = 0; component < 3; ++component) {
      row[component * stride + index] = static_cast<float>(c[component]);
    }
  }
  double norm = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3d sum{WarpSum(slope[i].x), WarpSum(slope[i].y), WarpSum(slope[i].z)};
    norm += Norm(sum) * Gradient(plan, tables, box, outside, i);
  }
  // ||cof J|| <= ||J||^2 / 2, Frobenius.
  if (lane == 0) out.cofactor_bounds[number] = static_cast<float>(0.5 * norm * norm);
}

}  // namespace

cudaError_t LaunchBoxPolynomials(const PlanTables& plan, const FusedTables& tables,
                                 const Vec3d* control_points, const BoxPolynomials& polynomials,
                                 cudaStream_t stream) {
  const size_t threads = size_t{tables.box_count} * kLanes;
  BoxPolynomialsKernel<<<Blocks(threads), kBlockThreads, 0, stream>>>(plan, tables, control_points,
                                                                      polynomials);
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
