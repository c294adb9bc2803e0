// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Control points of the paper's second comparator, in the layout that tessellation shaders read.
//                                      Cui & Feng 2014, doi:10.1007/s11766-014-3239-6, formula (6)
//
//   T = inv(B) Rs;  Rs: the m samples R(corner + j/n along + k/n across), i + j + k = n
//
// Samples are relative to that of corner 0, and in double until the result is rounded once: at
// n = 6, inv(B) would cost float32 a digit, which normals would show. Each function runs one index
// of a step, so that a test on the host runs the same code as a block on the device:
//
//   NetSample | NetControl          ( | : all indices of the group are done)
//
// Layout   a patch is m + 1 vectors of four floats: T in the order of bernstein.h, then corner 0
//          relative to the plan's local origin. The fourth float is 1
// Threads  distinct indices of a step may run at once
#ifndef LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NET_H_
#define LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NET_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/host_device.h"
#include "core/base/limits.h"
#include "core/base/vec.h"
#include "core/ffd/box/bernstein.h"
#include "core/ffd/box/volume_point.h"

namespace latticed {
struct DeformPlan;  // its header cannot be compiled for the device
}

namespace latticed::bench {

inline constexpr int kMostNet = BernsteinCount(3 * limits::kMaxDegree);
inline constexpr int kNetGroup = 4;  // patches per block

struct NetPatch {
  int span[3];
  int outside;  // 1: under the identity map; corner and edges are in the world
  Vec3d corner, along, across;
};

struct alignas(16) NetPoint {
  float x, y, z, w;
};

struct NetTables {
  int degree;
  int m;
  uint8_t j[kMostNet], k[kMostNet];     // indices of a sample and of a control point
  double inverse[kMostNet * kMostNet];  // m x m, column-major
};

struct NetJob {
  const NetPatch* patches;
  size_t count;
  VolumeView volume;
  const NetTables* tables;
  NetPoint* nets;  // m + 1 per patch
};

struct NetGroup {
  Vec3d sample[kNetGroup][kMostNet];
};

LATTICED_HD inline void NetSample(const NetJob& job, size_t first, int step, NetGroup& group) {
  const NetTables& tables = *job.tables;
  const int in_group = step / tables.m, i = step % tables.m;
  const size_t patch = first + static_cast<size_t>(in_group);
  if (patch >= job.count) return;
  const NetPatch& p = job.patches[patch];
  const double over = 1.0 / tables.degree;
  const Vec3d at = p.corner + (tables.j[i] * over) * p.along + (tables.k[i] * over) * p.across;
  group.sample[in_group][i] =
      p.outside != 0 ? at : EvaluateVolume<false>(job.volume, p.span, at).position;
}

LATTICED_HD inline void NetControl(const NetJob& job, size_t first, int step,
                                   const NetGroup& group) {
  const int m = job.tables->m, in_group = step / m, row = step % m;
  const size_t patch = first + static_cast<size_t>(in_group);
  if (patch >= job.count) return;
  const Vec3d* samples = group.sample[in_group];
  const Vec3d centre = samples[0];
  Vec3d sum;
  for (int i = 1; i < m; ++i) {  // the first sample is zero
    sum += job.tables->inverse[row + m * i] * (samples[i] - centre);
  }
  NetPoint* net = job.nets + patch * static_cast<size_t>(m + 1);
  const Vec3f rounded = ToFloat(sum), place = ToFloat(centre);
  net[row] = {rounded.x, rounded.y, rounded.z, 1};
  if (row == 0) net[m] = {place.x, place.y, place.z, 1};
}

// Computed once on the host, in double. degree is 3 … 9.
[[nodiscard]] NetTables MakeNetTables(int degree);
// World coordinates are relative to the plan's local origin.
[[nodiscard]] std::vector<NetPatch> MakeNetPatches(const DeformPlan& plan);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NET_H_
