// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The polynomial of each knot box from its control points, one warp a box, a lane a coefficient; in
// double, rounded once. Twin of core/cpu/box_polynomials.h.
//
// All that a box needs is loaded at once, then contracted axis by axis through shared memory: the
// kernel is over when two loads in a row are, and it stands before every evaluation. By a dependent
// launch after the copy of the control points: what it reads of the plan is loaded meanwhile, unless
// that copy has to bring the list of boxes first. The fused kernel may begin once that copy is over,
// for it reads the list of chunks before it waits.
#include "core/base/limits.h"
#include "cuda/device/dependent_launch.cuh"
#include "cuda/device/launch.cuh"
#include "cuda/fused/fused_kernels.h"

namespace latticed::kernels {
namespace {

constexpr int kLanes = 32;
constexpr unsigned kAllLanes = ~0u;
constexpr int kSide = limits::kMaxDegree + 1, kMost = kSide * kSide * kSide;
constexpr int kBoxesPerBlock = kBlockThreads / kLanes;

struct Arguments {
  PlanTables plan;
  FusedTables tables;
  const Vec3d* control_points;
  BoxList boxes;
  BoxPolynomials out;
};

// One number an axis, permuted.
struct Triple {
  int at[3];
};

// The index-th of (d0 + 1)(d1 + 1)(d2 + 1) triples, the last axis fastest.
__device__ Triple TripleAt(const int* degree, int index) {
  const int n1 = degree[1] + 1, n2 = degree[2] + 1;
  return {{index / (n1 * n2), index / n2 % n1, index % n2}};
}

class BoxWarp {
 public:
  __device__ BoxWarp(const Arguments& a, uint32_t box, Vec3d* tile)
      : a_(a),
        box_(box),
        tile_(tile),
        degree_(a.tables.degree),
        count_((degree_[0] + 1) * (degree_[1] + 1) * (degree_[2] + 1)),
        lane_(static_cast<int>(threadIdx.x % kLanes)) {}

  __device__ void Run() {
    if (box_ == a_.plan.outside_box) {
      WaitForKernelBefore();
      LetNextKernelBegin();
      SetIdentity();
    } else {
      ContractControlPoints();
    }
    Store();
  }

 private:
  static constexpr int kMine = kMost / kLanes;  // numbers of a lane
  // Column `power` of the matrix of an axis, for each of the lane's numbers.
  struct Column {
    double of[kMine][kSide];
  };

  __device__ void ContractControlPoints() {
    int span[3];  // by permuted axis
    for (int i = 0; i < 3; ++i) span[i] = a_.plan.boxes[box_].span[a_.tables.axis[i]];
    const int n1 = degree_[1] + 1, n2 = degree_[2] + 1;
    const Column last = LoadColumn(2, span[2], 1), middle = LoadColumn(1, span[1], n2),
                 first = LoadColumn(0, span[0], n1 * n2);
    // Up to here only of the plan was read.
    WaitForKernelBefore();
    LetNextKernelBegin();
    LoadControlPoints(span);
    Contract(last, 2, 1);
    Contract(middle, 1, n2);
    Contract(first, 0, n1 * n2);
  }

  // Of permuted axis i, along which neighbours lie `stride` apart.
  __device__ Column LoadColumn(int i, int span, int stride) const {
    Column column;
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
      const int power = (lane_ + k * kLanes) / stride % (degree_[i] + 1);
#pragma unroll
      for (int r = 0; r < kSide; ++r) {
        column.of[k][r] = a_.tables.basis[i][16 * span + 4 * r + power];
      }
    }
    return column;
  }

  __device__ void LoadControlPoints(const int* span) {
    for (int index = lane_; index < count_; index += kLanes) {
      const Triple local = TripleAt(degree_, index);
      int at[3];  // by axis of the lattice
      for (int i = 0; i < 3; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
          if (a_.tables.axis[i] == axis) at[axis] = span[i] - degree_[i] + local.at[i];
        }
      }
      const int* size = a_.plan.size;
      tile_[index] = a_.control_points[at[0] + size[0] * (at[1] + size[1] * at[2])];
    }
    __syncwarp();
  }

  // From basis functions to powers along permuted axis i.
  __device__ void Contract(const Column& column, int i, int stride) {
    Vec3d sums[kMine];
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
      const int index = lane_ + k * kLanes;
      if (index >= count_) continue;
      const int power = index / stride % (degree_[i] + 1);
      const Vec3d* line = tile_ + index - power * stride;
#pragma unroll
      for (int r = 0; r < kSide; ++r) {
        if (r <= degree_[i]) sums[k] += column.of[k][r] * line[r * stride];
      }
    }
    __syncwarp();
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
      if (lane_ + k * kLanes < count_) tile_[lane_ + k * kLanes] = sums[k];
    }
    __syncwarp();
  }

  // l0, l1, l2 scaled to the box.
  __device__ void SetIdentity() {
    const FusedBox& box = a_.tables.boxes[box_];
    for (int index = lane_; index < count_; index += kLanes) {
      const Triple power = TripleAt(degree_, index);
      const int degree = power.at[0] + power.at[1] + power.at[2];
      Vec3d c = degree == 0 ? box.centre : Vec3d{};
      if (degree == 1) {
        const int axis = a_.tables.axis[power.at[0] == 1 ? 0 : power.at[1] == 1 ? 1 : 2];
        c[axis] = 1 / box.inverse_width[axis];
      }
      tile_[index] = c;
    }
    __syncwarp();
  }

  __device__ void Store() {
    const int stride = CoefficientStride(degree_[0], degree_[1], degree_[2]);
    float* row = a_.out.coefficients + size_t{box_} * 3 * static_cast<size_t>(stride);
    float slope[3][3] = {};  // this lane's part of a bound of |dR / dl_i|, by component
    for (int index = lane_; index < stride; index += kLanes) {
      Vec3d c;
      if (index < count_) c = a_.out.scale * tile_[index];
      if (index == 0) c += a_.out.offset;
      const float v[3] = {static_cast<float>(c.x), static_cast<float>(c.y),
                          static_cast<float>(c.z)};
      const Triple power = TripleAt(degree_, index);
      // |l| <= 1/2.
      const float size = ldexpf(1, 1 - power.at[0] - power.at[1] - power.at[2]);
      for (int k = 0; k < 3; ++k) {
        row[k * stride + index] = v[k];
        for (int i = 0; i < 3; ++i) {
          slope[i][k] += static_cast<float>(power.at[i]) * size * fabsf(v[k]);
        }
      }
    }
    StoreBound(slope);
  }

  // ||cof J|| <= ||J||^2 / 2, Frobenius.
  __device__ void StoreBound(float (&slope)[3][3]) {
    float norm = 0;
#pragma unroll
    for (int i = 0; i < 3; ++i) {
#pragma unroll
      for (int k = 0; k < 3; ++k) {
#pragma unroll
        for (int step = kLanes / 2; step > 0; step /= 2) {
          slope[i][k] += __shfl_xor_sync(kAllLanes, slope[i][k], step);
        }
      }
      norm += norm3df(slope[i][0], slope[i][1], slope[i][2]) * Gradient(i);
    }
    if (lane_ == 0) a_.out.cofactor_bounds[box_] = 0.5f * norm * norm;
  }

  // Length of the gradient of l_i by world position.
  __device__ float Gradient(int i) const {
    const Vec3f gradient = ToFloat(a_.tables.boxes[box_].gradient[i]);
    return norm3df(gradient.x, gradient.y, gradient.z);
  }

  const Arguments& a_;
  const uint32_t box_;
  Vec3d* const tile_;  // control points, then coefficients
  const int* const degree_;
  const int count_, lane_;
};

// Of all boxes, or of those listed: two kernels, so that the former's registers are its own.
template <bool kListed>
__global__ void __launch_bounds__(kBlockThreads)
    BoxPolynomialsKernel(const __grid_constant__ Arguments arguments) {
  // Bytes, since Vec3d has a constructor.
  __shared__ alignas(Vec3d) unsigned char tiles[kBoxesPerBlock * kMost * sizeof(Vec3d)];
  auto box = static_cast<uint32_t>(Item() / kLanes);
  if (box >= (kListed ? arguments.boxes.count : arguments.tables.box_count)) return;
  if constexpr (kListed) {
    // To wait and let begin once more, as all do, changes nothing.
    WaitForKernelBefore();
    LetNextKernelBegin();
    box = arguments.boxes.numbers[box];
  }
  BoxWarp(arguments, box, reinterpret_cast<Vec3d*>(tiles) + threadIdx.x / kLanes * kMost).Run();
}

}  // namespace

KernelCall BoxPolynomialsCall(const PlanTables& plan, const FusedTables& tables,
                              const Vec3d* control_points, const BoxList& boxes,
                              const BoxPolynomials& polynomials) {
  const bool listed = boxes.numbers != nullptr;
  const size_t threads = size_t{listed ? boxes.count : tables.box_count} * kLanes;
  return {listed ? BoxPolynomialsKernel<true> : BoxPolynomialsKernel<false>,
          Order::kDependent,
          Blocks(threads),
          kBlockThreads,
          0,
          Arguments{plan, tables, control_points, boxes, polynomials}};
}

}  // namespace latticed::kernels
