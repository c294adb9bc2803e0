// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/adaptive/surface/sampled_kernels.h"

#include "core/adaptive/curvature_slack.h"
#include "core/adaptive/net_curvature.h"
#include "core/adaptive/net_slack.h"
#include "cuda/adaptive/point_site.cuh"
#include "cuda/adaptive/store_bounds.cuh"
#include "cuda/device/launch.cuh"
#include "cuda/plan/definition_normal.cuh"
#include "cuda/plan/plan_point.cuh"

namespace latticed::kernels {
namespace {

constexpr int kWarpLanes = 32, kBoundWarps = 4;
constexpr unsigned kAllOfWarp = ~0u;
constexpr int kMostNetPoints = BernsteinCount(3 * limits::kMaxDegree + 1);

// One number of all lanes: the largest, or the sum. Each lane gets it.
__device__ double LargestOfWarp(double value) {
  for (int step = kWarpLanes / 2; step > 0; step /= 2) {
    value = fmax(value, __shfl_xor_sync(kAllOfWarp, value, step));
  }
  return value;
}
__device__ double SumOfWarp(double value) {
  for (int step = kWarpLanes / 2; step > 0; step /= 2) {
    value += __shfl_xor_sync(kAllOfWarp, value, step);
  }
  return value;
}

// What NetSlack adds for a lattice. Tables: PlanTables or a TurnedTable.
template <class Tables>
__device__ double SlackOfSpans(const Tables& lattice, const Vec3d* points, const int* span,
                               double mesh_reach, int lane) {
  int first[3], count[3];
  double ratio = 0, largest = mesh_reach;
  for (int axis = 0; axis < 3; ++axis) {
    count[axis] = lattice.degree[axis] + 1;
    first[axis] = span[axis] - lattice.degree[axis];
    ratio = fmax(ratio, KnotRatio(lattice.knots[axis], span[axis]));
  }
  for (int k = lane; k < count[0] * count[1] * count[2]; k += kWarpLanes) {
    const int i = first[0] + k % count[0], j = first[1] + k / count[0] % count[1];
    const int l = first[2] + k / count[0] / count[1];
    largest = fmax(largest, Norm(points[i + lattice.size[0] * (j + lattice.size[1] * l)]));
  }
  return SlackOfLattice(ratio, LargestOfWarp(largest));
}

__device__ double SlackOf(const SampledLaunch& launch, uint32_t index, int lane) {
  const PlanTables& plan = launch.adaptive.fused.plan;
  const Vec3d* const points = launch.adaptive.fused.control_points;
  const double reach = launch.tables.mesh_reach;
  const uint32_t box = plan.patches[index].Box();
  double slack = SlackAtRest(reach);
  if (box != plan.outside_box) {
    slack += SlackOfSpans(plan, points, plan.boxes[box].span, reach, lane);
  }
  for (int g = 0; g < launch.tables.turned->count; ++g) {
    const TurnedTable& lattice = launch.tables.turned->lattices[g];
    const int* const span = lattice.spans[index].span;
    if (span[0] < 0) continue;
    slack += SlackOfSpans(lattice, points + lattice.first_point, span, reach, lane);
  }
  return launch.tables.slack_of_net * slack;
}

// The samples of a patch, then its control net, made by one warp.
class WarpNet {
 public:
  __device__ WarpNet(const SampledLaunch& launch, Vec3d* samples, Vec3d* net, int lane)
      : launch_(launch), samples_(samples), net_(net), lane_(lane) {}

  __device__ void Make(uint32_t index) const {
    const SampledTables& tables = launch_.tables;
    const FusedLaunch& fused = launch_.adaptive.fused;
    const double over = 1.0 / tables.degree;
    for (int i = lane_; i < tables.m; i += kWarpLanes) {
      const uchar4 t = tables.samples[i];
      samples_[i] = PlanPoint(fused.plan, *tables.turned, fused.control_points, index,
                              {t.x * over, t.y * over, t.z * over});
    }
    __syncwarp();
    for (int i = lane_; i < tables.m; i += kWarpLanes) {
      Vec3d sum;
      for (int j = 0; j < tables.m; ++j) sum += tables.inverse[j * tables.m + i] * samples_[j];
      net_[i] = sum;
    }
    __syncwarp();
  }

  // BoundNet of core/adaptive/net_curvature.h.
  __device__ CurvatureBounds<double> Bound() const {
    const int n = launch_.tables.degree;
    CurvatureBounds<double> bounds;
    double check = 0;
    for (int at = lane_; at < BernsteinCount(n - 2); at += kWarpLanes) {
      int row = 0;
      while ((row + 1) * (row + 2) / 2 <= at) ++row;
      const int j = row - (at - row * (row + 1) / 2);
      const CurvatureBounds<double> squared =
          SquaredDifferences(n, n - 2 - row, j, [&](int k) { return net_[k]; });
      for (int e = 0; e < 3; ++e) {
        check += 0 * squared.edge[e] + 0 * squared.mixed[e];
        bounds.edge[e] = fmax(bounds.edge[e], squared.edge[e]);
        bounds.mixed[e] = fmax(bounds.mixed[e], squared.mixed[e]);
      }
    }
    check = SumOfWarp(check);
    for (int e = 0; e < 3; ++e) {
      bounds.edge[e] = n * (n - 1) * sqrt(LargestOfWarp(bounds.edge[e])) + check;
      bounds.mixed[e] = n * (n - 1) * sqrt(LargestOfWarp(bounds.mixed[e])) + check;
    }
    return bounds;
  }

 private:
  const SampledLaunch& launch_;
  Vec3d *const samples_, *const net_;
  const int lane_;
};

__global__ void __launch_bounds__(kBoundWarps* kWarpLanes)
    SampledBoundsKernel(const __grid_constant__ SampledLaunch launch) {
  // Vec3d has a constructor, which shared memory must not.
  __shared__ alignas(Vec3d) unsigned char memory[kBoundWarps][2][kMostNetPoints * sizeof(Vec3d)];
  const int warp = static_cast<int>(threadIdx.x) / kWarpLanes;
  const int lane = static_cast<int>(threadIdx.x) % kWarpLanes;
  const FusedLaunch& fused = launch.adaptive.fused;
  const size_t item = size_t{blockIdx.x} * kBoundWarps + static_cast<size_t>(warp);
  const size_t place = item / kChunkPatches;
  if (place >= fused.chunk_count) return;
  const size_t chunk = fused.chunks != nullptr ? fused.chunks[place] : place;
  const size_t index = chunk * kChunkPatches + item % kChunkPatches;
  if (index >= fused.patch_count) return;
  const WarpNet net(launch, reinterpret_cast<Vec3d*>(memory[warp][0]),
                    reinterpret_cast<Vec3d*>(memory[warp][1]), lane);
  net.Make(static_cast<uint32_t>(index));
  const CurvatureBounds<double> exact = net.Bound();
  const double slack = SlackOf(launch, static_cast<uint32_t>(index), lane);
  if (lane != 0) return;
  CurvatureBounds<float> bounds;
  for (int e = 0; e < 3; ++e) {
    bounds.edge[e] = __double2float_ru(kBoundFactor * (exact.edge[e] + slack));
    bounds.mixed[e] = __double2float_ru(kBoundFactor * (exact.mixed[e] + slack));
  }
  StoreBounds(launch.adaptive.state, index, bounds);
}

// A corner, or a point of an edge: the same bits in all patches that have it.
__device__ Vec3d SharedPoint(const SampledLaunch& launch, const PointSite& site,
                             const Between& between, int kind) {
  const FusedLaunch& fused = launch.adaptive.fused;
  const DevicePatch patch = fused.plan.patches[site.patch];
  const int corner = kind % 3;
  const bool is_edge = kind >= 3;
  const SharedPlace place =
      is_edge ? launch.tables.edges[launch.adaptive.tables.edges[3 * site.patch + corner]]
              : launch.tables.vertices[patch.Vertex(corner)];
  double t = is_edge ? 0.5 + between.along : 0;
  if (is_edge && place.vertex[0] != patch.Vertex(corner)) t = 1 - t;
  const bool rests = patch.Box() == fused.plan.outside_box ||
                     (place.seam != kNoSharedSeam && fused.attached[place.seam] != 0);
  return PlanPointOnEdge(fused.plan, *launch.tables.turned, fused.control_points,
                         rests ? fused.plan.outside_box : place.box, place.vertex[0],
                         place.vertex[1], t);
}

__global__ void __launch_bounds__(kBlockThreads)
    SampledPointsKernel(const __grid_constant__ SampledLaunch launch) {
  const AdaptiveLaunch& adaptive = launch.adaptive;
  const FusedLaunch& fused = adaptive.fused;
  const uint64_t total = adaptive.state.chunk_first[adaptive.plan_chunks], point = Item();
  if (point >= total || total > adaptive.most_points) return;
  const PointSite site = SiteOf(adaptive, point);
  const Between between(site.place);
  const Vec3d b = between.Barycentrics();
  const int kind = site.place.Kind();
  const Vec3d position =
      kind == PatternPlace::kInside
          ? PlanPoint(fused.plan, *launch.tables.turned, fused.control_points, site.patch, b)
          : SharedPoint(launch, site, between, kind);
  const PatchPlace chunk{launch.vertices + site.chunk_first * launch.point_bytes, site.chunk_points,
                         0};
  launch.writer.WritePosition(chunk, site.in_chunk, position);
  if (fused.normals == Normals::kNone) return;
  const Vec3d normal =
      DefinitionNormal(fused.plan, fused.control_points, site.patch, b,
                       fused.normals == Normals::kSmooth, Turned{*launch.tables.turned});
  launch.writer.WriteNormal(chunk, site.in_chunk, ToFloat(normal));
}

}  // namespace

KernelCall SampledBoundsCall(const SampledLaunch& launch) {
  // One at least, which does nothing where a slice has no named chunk.
  const size_t patches = size_t{launch.adaptive.fused.chunk_count} * kChunkPatches;
  const size_t blocks = patches > 0 ? (patches + kBoundWarps - 1) / kBoundWarps : 1;
  return {SampledBoundsKernel,
          Order::kAfter,
          static_cast<unsigned>(blocks),
          kBoundWarps * kWarpLanes,
          0,
          launch};
}

KernelCall SampledPointsCall(const SampledLaunch& launch) {
  const uint64_t points = launch.adaptive.most_points;
  return {SampledPointsKernel,
          Order::kAfter,
          Blocks(points > 0 ? points : 1),
          kBlockThreads,
          0,
          launch};
}

}  // namespace latticed::kernels
