// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Computes the polynomial of each knot box from its control points: one warp a box, at most two
// coefficients a lane, in double, rounded once. Twin of core/cpu/fused/box_polynomials.h.
//
// Every evaluation waits for this kernel, so its latency counts. It loads all that a box needs at
// once and contracts it axis by axis through shared memory: it takes as long as two loads, one after
// the other. It is a dependent launch after the copy of the control points, and reads the plan while
// that copy runs; a list of boxes comes with the copy and is read after it. The fused kernel may begin
// when the copy is over, because it reads the list of chunks before it waits.
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

// The index-th of (d0 + 1)(d1 + 1)(d2 + 1) triples of numbers, one a permuted axis; the last varies
// fastest.
struct Triple {
  int at[3];
};
__device__ Triple TripleAt(const int* degree, int index) {
  const int n1 = degree[1] + 1, n2 = degree[2] + 1;
  return {{index / (n1 * n2), index / n2 % n1, index % n2}};
}

template <bool kWeighted>
class BoxWarp {
 public:
  // Divides here, before the kernel waits for anything.
  __device__ BoxWarp(const Arguments& a, uint32_t box, Vec3d* tile)
      : a_(a),
        box_(box),
        tile_(tile),
        degree_(a.tables.degree),
        count_((degree_[0] + 1) * (degree_[1] + 1) * (degree_[2] + 1)),
        lane_(static_cast<int>(threadIdx.x % kLanes)) {
    float gradient[3];
#pragma unroll
    for (int i = 0; i < 3; ++i) {
      const Vec3f g = ToFloat(a.tables.boxes[box].gradient[i]);
      gradient[i] = norm3df(g.x, g.y, g.z);
    }
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
      power_[k] = TripleAt(degree_, min(Mine(k), count_ - 1));
      slope_[k] = SlopeOf(power_[k], gradient);
      if constexpr (kWeighted) size_[k] = SizeOf(power_[k]);
    }
  }

  __device__ void Run() {
    if (box_ == a_.plan.outside_box) {
      WaitForKernelBefore();
      LetNextKernelBegin();
      SetOutside();
    } else {
      ContractControlPoints();
    }
    Store();
  }

 private:
  static constexpr int kMine = kMost / kLanes;  // coefficients of a lane
  // Column `power` of the matrix of an axis, for each of the lane's coefficients.
  struct Column {
    double of[kMine][kSide];
  };

  __device__ int Mine(int k) const { return lane_ + k * kLanes; }

  // An upper bound of ||grad l0^a l1^b l2^c|| in the box, where |l| <= 1/2.
  __device__ static float SlopeOf(const Triple& power, const float (&gradient)[3]) {
    const int(&at)[3] = power.at;
    const float sum = static_cast<float>(at[0]) * gradient[0] +
                      static_cast<float>(at[1]) * gradient[1] +
                      static_cast<float>(at[2]) * gradient[2];
    return sum * ldexpf(1, 1 - at[0] - at[1] - at[2]);
  }
  // An upper bound of |l0^a l1^b l2^c| there.
  __device__ static float SizeOf(const Triple& power) {
    return ldexpf(1, -power.at[0] - power.at[1] - power.at[2]);
  }

  __device__ void ContractControlPoints() {
    int span[3];  // by permuted axis
    for (int i = 0; i < 3; ++i) span[i] = a_.plan.boxes[box_].span[a_.tables.axis[i]];
    int from[kMine];
#pragma unroll
    for (int k = 0; k < kMine; ++k) from[k] = ControlPoint(span, power_[k]);
    const int n1 = degree_[1] + 1, n2 = degree_[2] + 1;
    const Column last = LoadColumn(2, span[2]), middle = LoadColumn(1, span[1]),
                 first = LoadColumn(0, span[0]);
    // Only the plan was read before this line.
    WaitForKernelBefore();
    LetNextKernelBegin();
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
      if (Mine(k) >= count_) continue;
      Vec3d point = a_.control_points[from[k]];
      if constexpr (kWeighted) point -= a_.plan.weights.identity_points[from[k]];
      tile_[Mine(k)] = point;
    }
    __syncwarp();
    Contract(last, 2, 1);
    Contract(middle, 1, n2);
    Contract(first, 0, n1 * n2);
  }

  // For permuted axis i.
  __device__ Column LoadColumn(int i, int span) const {
    Column column;
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
#pragma unroll
      for (int r = 0; r < kSide; ++r) {
        column.of[k][r] = a_.tables.basis[i][16 * span + 4 * r + power_[k].at[i]];
      }
    }
    return column;
  }

  // The index of the control point at `local` within the box that ends at `span`.
  __device__ int ControlPoint(const int* span, const Triple& local) const {
    int at[3];  // by axis of the lattice
#pragma unroll
    for (int i = 0; i < 3; ++i) {
#pragma unroll
      for (int axis = 0; axis < 3; ++axis) {
        if (a_.tables.axis[i] == axis) at[axis] = span[i] - degree_[i] + local.at[i];
      }
    }
    const int* size = a_.plan.size;
    return at[0] + size[0] * (at[1] + size[1] * at[2]);
  }

  // Changes from basis functions to powers along permuted axis i; neighbours along it are `stride`
  // apart.
  __device__ void Contract(const Column& column, int i, int stride) {
    Vec3d sums[kMine];
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
      if (Mine(k) >= count_) continue;
      const Vec3d* line = tile_ + Mine(k) - power_[k].at[i] * stride;
#pragma unroll
      for (int r = 0; r < kSide; ++r) {
        if (r <= degree_[i]) sums[k] += column.of[k][r] * line[r * stride];
      }
    }
    __syncwarp();
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
      if (Mine(k) < count_) tile_[Mine(k)] = sums[k];
    }
    __syncwarp();
  }

  // The identity map, by box-local coordinates; its displacement is zero.
  __device__ void SetOutside() {
    const FusedBox& box = a_.tables.boxes[box_];
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
      if (Mine(k) >= count_) continue;
      const int(&power)[3] = power_[k].at, degree = power[0] + power[1] + power[2];
      Vec3d c = degree == 0 ? box.centre : Vec3d{};
      if (degree == 1) {
        const int axis = a_.tables.axis[power[0] == 1 ? 0 : power[1] == 1 ? 1 : 2];
        c[axis] = 1 / box.inverse_width[axis];
      }
      tile_[Mine(k)] = kWeighted ? Vec3d{} : c;
    }
    __syncwarp();
  }

  __device__ void Store() {
    const int stride = CoefficientStride(degree_[0], degree_[1], degree_[2]);
    float* row = a_.out.coefficients + size_t{box_} * 3 * static_cast<size_t>(stride);
    // This lane's parts of bounds of ||J|| and of the displacement.
    float slope = 0, length = 0;
#pragma unroll
    for (int k = 0; k < kMine; ++k) {
      const int index = Mine(k);
      if (index >= stride) continue;
      Vec3d c;
      if (index < count_) c = a_.out.scale * tile_[index];
      if (!kWeighted && index == 0) c += a_.out.offset;
      const Vec3f v = ToFloat(c);
      row[index] = v.x;
      row[stride + index] = v.y;
      row[2 * stride + index] = v.z;
      const float norm = norm3df(v.x, v.y, v.z);
      slope += slope_[k] * norm;
      if constexpr (kWeighted) length += size_[k] * norm;
    }
    slope = SumOfLanes(slope);
    // The spectral norm of cof J is at most half the squared Frobenius norm of J.
    if (lane_ == 0) a_.out.cofactor_bounds[box_] = 0.5f * slope * slope;
    if constexpr (kWeighted) {
      length = SumOfLanes(length);
      if (lane_ == 0) a_.out.length_bounds[box_] = length;
      StoreRest();
    }
  }
  __device__ void StoreRest() const {
    if (lane_ >= 12) return;
    const RestBox& box = a_.plan.weights.boxes[box_];
    const int component = lane_ / 4, k = lane_ % 4;
    const double value = a_.out.scale * (k == 0 ? box.centre : box.by_coordinate[k - 1])[component];
    a_.out.rest[box_ * 12 + static_cast<unsigned>(lane_)] =
        static_cast<float>(k == 0 ? value + a_.out.offset[component] : value);
  }

  __device__ static float SumOfLanes(float x) {
#pragma unroll
    for (int step = kLanes / 2; step > 0; step /= 2) x += __shfl_xor_sync(kAllLanes, x, step);
    return x;
  }

  const Arguments& a_;
  const uint32_t box_;
  Vec3d* const tile_;  // control points, then coefficients
  const int* const degree_;
  const int count_, lane_;
  Triple power_[kMine];  // of each of the lane's coefficients; past the end, of the last one
  float slope_[kMine];   // bounds of these powers' gradients by world position
  float size_[kMine];    // bounds of the powers; only with weights
};

// For all boxes, or for a list of them. The list takes registers, so these are two kernels, and two with weights.
template <bool kListed, bool kWeighted>
__global__ void __launch_bounds__(kBlockThreads)
    BoxPolynomialsKernel(const __grid_constant__ Arguments arguments) {
  // Bytes, since Vec3d has a constructor.
  __shared__ alignas(Vec3d) unsigned char tiles[kBoxesPerBlock * kMost * sizeof(Vec3d)];
  auto box = static_cast<uint32_t>(Item() / kLanes);
  if (box >= (kListed ? arguments.boxes.count : arguments.tables.box_count)) return;
  if constexpr (kListed) {
    // BoxWarp::Run does both again, which has no effect.
    WaitForKernelBefore();
    LetNextKernelBegin();
    box = arguments.boxes.numbers[box];
  }
  BoxWarp<kWeighted>(arguments, box, reinterpret_cast<Vec3d*>(tiles) + threadIdx.x / kLanes * kMost)
      .Run();
}

}  // namespace

KernelCall BoxPolynomialsCall(const PlanTables& plan, const FusedTables& tables,
                              const Vec3d* control_points, const BoxList& boxes,
                              const BoxPolynomials& polynomials) {
  const bool listed = boxes.numbers != nullptr;
  const size_t threads = size_t{listed ? boxes.count : tables.box_count} * kLanes;
  const bool weighted = plan.weights.vertices != nullptr;
  return {listed
              ? (weighted ? BoxPolynomialsKernel<true, true> : BoxPolynomialsKernel<true, false>)
              : (weighted ? BoxPolynomialsKernel<false, true> : BoxPolynomialsKernel<false, false>),
          Order::kDependent,
          Blocks(threads),
          kBlockThreads,
          0,
          Arguments{plan, tables, control_points, boxes, polynomials}};
}

}  // namespace latticed::kernels
