// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The sums of reverse mode.
//
//   tile, one row a point   1 l l^2 l^3 | 1 m m^2 m^3 | 1 n n^2 n^3 | g | with normals G_l, G_m, G_n
//
//   thread (p, q, r, c)     S += l^p m^q n^r g_c + (l^p)' m^q n^r G_l,c + l^p (m^q)' n^r G_m,c + l^p m^q (n^r)' G_n,c
//
// G are the cotangents of dR/d(l, m, n) that come from those of normals (point_normal.cuh). Rows have an odd
// number of doubles, so that threads that write different rows do not meet in a bank of shared memory.
#include "cuda/device/launch.cuh"
#include "cuda/points/box_point.cuh"

namespace latticed::kernels {
namespace {

constexpr int kForces = 3 * static_cast<int>(kPowers);  // where g begins in a row
template <bool kNormals>
constexpr int kRowDoubles = kNormals ? kForces + 13 : kForces + 3;  // g, G and one of padding

// Shared variables of a kernel have no constructors.
template <bool kNormals>
struct Tile {
  double rows[kTilePoints][kRowDoubles<kNormals>];
};
template <>
struct Tile<true> {
  double rows[kTilePoints][kRowDoubles<true>];
  alignas(BoxPolynomial) unsigned char shape[sizeof(BoxPolynomial)];
};

__device__ inline void SetPowers(double t, double* to) {
  to[0] = 1;
  for (int k = 1; k < static_cast<int>(kPowers); ++k) to[k] = to[k - 1] * t;
}

__device__ inline void SetVector(Vec3d v, double* to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

// Which sum a thread has. `at`: its place in BoxNumbers.
struct SumPlace {
  int power[3], component, at;
  bool exists;

  __device__ explicit SumPlace(const int (&degree)[3]) {
    const int q_count = degree[1] + 1, r_count = degree[2] + 1;
    int rest = static_cast<int>(threadIdx.x);
    component = rest % 3, rest /= 3;
    power[2] = rest % r_count, rest /= r_count;
    power[1] = rest % q_count, power[0] = rest / q_count;
    exists = power[0] <= degree[0];
    const int side = static_cast<int>(kPowers);
    at = ((power[0] * side + power[1]) * side + power[2]) * 3 + component;
  }
};

// The derivative of t^k, from a row's powers of t.
__device__ inline double Slope(const double* powers, int k) {
  return k == 0 ? 0 : k * powers[k - 1];
}

template <bool kNormals>
__device__ inline double Term(const double* row, const SumPlace& place) {
  const double *l = row, *m = row + kPowers, *n = row + 2 * kPowers;
  const double* g = row + kForces + place.component;
  const auto [p, q, r] = place.power;
  const double by_l = l[p], by_m = m[q], by_n = n[r];
  double sum = by_l * by_m * by_n * g[0];
  if constexpr (kNormals) {
    const double first = Slope(l, p) * by_m * g[3] + by_l * Slope(m, q) * g[6];
    sum += first * by_n + by_l * by_m * Slope(n, r) * g[9];
  }
  return sum;
}

template <bool kNormals>
__global__ void __launch_bounds__(kPointThreads) SumKernel(const PointSums sums) {
  __shared__ Tile<kNormals> tile;
  const PointTables& tables = sums.tables;
  const PointPiece piece = tables.pieces[blockIdx.x];
  const LocalMap map = tables.maps[piece.slot];
  const SumPlace place(tables.degree);
  if constexpr (kNormals) {
    CopyToShared(sums.shape[piece.slot], *reinterpret_cast<BoxPolynomial*>(tile.shape));
    __syncthreads();
  }
  double sum = 0;
  for (uint32_t first = 0; first < piece.count; first += kTilePoints) {
    const uint32_t count = min(kTilePoints, piece.count - first);
    if (threadIdx.x < count) {
      const size_t at = piece.first + first + threadIdx.x, number = tables.order[at];
      double* const row = tile.rows[threadIdx.x];
      const Vec3d local = ToLocal(map, WorldAt(tables.world, at));
      SetPowers(local.x, row);
      SetPowers(local.y, row + kPowers);
      SetPowers(local.z, row + 2 * kPowers);
      SetVector(sums.cotangents[number], row + kForces);
      if constexpr (kNormals) {
        const auto& shape = *reinterpret_cast<const BoxPolynomial*>(tile.shape);
        const PointJet jet = EvaluateBox<true>(shape, tables.degree, local);
        const PointNormal normal(ToWorldColumns(map, jet.slopes), WorldAt(tables.normal, at));
        const auto forces =
            FromWorldColumns(map, normal.Cotangent(sums.cotangents[tables.points + number]));
        for (int a = 0; a < 3; ++a) {
          SetVector(forces[static_cast<size_t>(a)], row + kForces + 3 * (a + 1));
        }
      }
    }
    __syncthreads();
    if (place.exists) {
      for (uint32_t i = 0; i < count; ++i) sum += Term<kNormals>(tile.rows[i], place);
    }
    __syncthreads();
  }
  if (!place.exists) return;
  reinterpret_cast<double*>(sums.of_pieces + blockIdx.x)[place.at] = sum;
}

__global__ void __launch_bounds__(kPointThreads) AddKernel(const PointSums sums) {
  const SumPlace place(sums.tables.degree);
  auto* const out = reinterpret_cast<double*>(sums.of_boxes + blockIdx.x);
  out[threadIdx.x] = 0;
  __syncthreads();
  if (!place.exists) return;
  double sum = 0;
  for (uint32_t piece = sums.tables.first_piece[blockIdx.x];
       piece < sums.tables.first_piece[blockIdx.x + 1]; ++piece) {
    sum += reinterpret_cast<const double*>(sums.of_pieces + piece)[place.at];
  }
  out[place.at] = sum;
}

}  // namespace

KernelCall SumCall(const PointSums& sums) {
  return {sums.shape == nullptr ? SumKernel<false> : SumKernel<true>,
          Order::kAfter,
          sums.tables.piece_count,
          kPointThreads,
          0,
          sums};
}

KernelCall AddCall(const PointSums& sums) {
  return {AddKernel, Order::kAfter, sums.tables.slot_count, kPointThreads, 0, sums};
}

}  // namespace latticed::kernels
