// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Vertices from the products: rearrangement and normals.             Cui & Feng 2014, §3.6
//
//   facet   Pu x Pv
//   smooth  with N the interpolated vertex normal, e1, e2 the rest edges and f the facet normal,
//           cof(J) N ~ (N.f) Pu x Pv + (N.e1) Pv x Pf + (N.e2) Pf x Pu
//
// Where the float products cancel beyond kMostCondition, the normal is computed by its definition in
// double: at folds, in collapsed lattices and on extreme slivers, and in triangles whose weight has no
// gradient. As in core/cpu/gemm/gemm_kernel.h.
// One kernel marks these points, one bit each, and a second kernel computes them: in one kernel, all
// points would pay for the registers of the definition.
#include "core/ffd/weights/weight_change.h"
#include "cuda/device/launch.cuh"
#include "cuda/gemm/gemm_kernels.h"
#include "cuda/plan/definition_normal.cuh"

namespace latticed::kernels {
namespace {

constexpr double kMostCondition = 1e3;
constexpr unsigned kLanes = 32;
constexpr unsigned kAllLanes = ~0u;

// Row `row` of the patch's three columns x, y and z.
__device__ Vec3d Column(const float* products, size_t rows, size_t row, size_t patch,
                        size_t patches) {
  const float* x = products + patch * rows + row;
  const size_t stride = patches * rows;
  return {double{x[0]}, double{x[stride]}, double{x[2 * stride]}};
}

// A vector along the normal, and an upper bound of its squared length if no terms cancel.
struct RawNormal {
  Vec3d direction;
  double bound2;
};

__device__ RawNormal FacetNormal(Vec3d pu, Vec3d pv) {
  return {Cross(pu, pv), Dot(pu, pu) * Dot(pv, pv)};
}

__device__ RawNormal SmoothNormal(const PlanTables& plan, size_t patch, Vec3d b, Vec3d pu, Vec3d pv,
                                  Vec3d pf) {
  const DevicePatch p = plan.patches[patch];
  const Vec3d corner = plan.vertices[p.Vertex(0)].world;
  const Vec3d n = RestSmoothNormal(plan, patch, b);
  const double by_f = Dot(n, UnpackDirection(plan.facet_normals[patch]));
  const double by_1 = Dot(n, plan.vertices[p.Vertex(1)].world - corner);
  const double by_2 = Dot(n, plan.vertices[p.Vertex(2)].world - corner);
  const double u = Norm(pu), v = Norm(pv), f = Norm(pf);
  const double bound = std::abs(by_f) * u * v + f * (std::abs(by_1) * v + std::abs(by_2) * u);
  return {by_f * Cross(pu, pv) + by_1 * Cross(pv, pf) + by_2 * Cross(pf, pu), bound * bound};
}

// As in core/cpu/gemm/gemm_kernel.cc.
__device__ bool HasGradient(const PlanTables& plan, size_t patch) {
  const DevicePatch p = plan.patches[patch];
  const Vec3d gradient = plan.weights.gradients[patch], corner = plan.vertices[p.Vertex(0)].world;
  const double weight = plan.weights.vertices[p.Vertex(0)];
  const auto is_steady = [&](uint32_t v) {
    return IsByGradient(Dot(gradient, plan.vertices[v].world - corner),
                        plan.weights.vertices[v] - weight);
  };
  return is_steady(p.Vertex(1)) && is_steady(p.Vertex(2));
}

__device__ Vec3d Barycentrics(const Surface& surface, size_t point) {
  const uchar4 t = surface.pattern[point];
  const double over = 1.0 / surface.segments;
  return {t.x * over, t.y * over, t.z * over};
}

template <Normals kNormals, bool kWeighted>
__global__ void __launch_bounds__(kBlockThreads)
    SurfaceKernel(const __grid_constant__ Tile tile, const __grid_constant__ Surface surface) {
  const size_t i = Item(), q = static_cast<size_t>(surface.q);
  const unsigned here = __ballot_sync(kAllLanes, i < q * tile.count);
  if (i >= q * tile.count) return;
  const size_t in_tile = i / q, point = i % q, patch = tile.first + in_tile;
  const auto row = [&](size_t block) {
    return Column(surface.products, surface.rows, block * q + point, in_tile, tile.count);
  };
  const PatchPlace place = surface.layout.Place(surface.vertices, patch);
  surface.writer.WritePosition(place, point, surface.centres[in_tile] + row(0));
  if constexpr (kNormals == Normals::kNone) return;

  RawNormal raw;
  if constexpr (kNormals == Normals::kSmooth) {
    raw = SmoothNormal(tile.plan, patch, Barycentrics(surface, point), row(1), row(2),
                       Column(surface.across, q, point, in_tile, tile.count));
  } else {
    raw = FacetNormal(row(1), row(2));
  }
  const double length2 = Dot(raw.direction, raw.direction);
  bool sound = std::isfinite(length2) && length2 > 0 &&
               raw.bound2 <= kMostCondition * kMostCondition * length2;
  if constexpr (kWeighted) sound = sound && HasGradient(tile.plan, patch);
  const unsigned ill = __ballot_sync(here, !sound);
  if (i % kLanes == 0) surface.ill[i / kLanes] = ill;
  if (!sound) return;
  surface.writer.WriteNormal(place, point, ToFloat(rsqrt(length2) * raw.direction));
}

// Each thread reads one word of marks. Then its warp takes the marked words one after the other, a
// lane per point.
template <bool kSmooth>
__global__ void __launch_bounds__(kBlockThreads)
    IllKernel(const __grid_constant__ Tile tile, const __grid_constant__ Surface surface) {
  const size_t q = static_cast<size_t>(surface.q), words = IllWords(q * tile.count);
  const size_t word = Item(), lane = threadIdx.x % kLanes, first_word = word - lane;
  const unsigned marks = word < words ? surface.ill[word] : 0;
  for (unsigned busy = __ballot_sync(kAllLanes, marks != 0); busy != 0; busy &= busy - 1) {
    const int owner = __ffs(static_cast<int>(busy)) - 1;
    const unsigned owned = __shfl_sync(kAllLanes, marks, owner);
    if ((owned >> lane & 1) == 0) continue;
    const size_t i = (first_word + static_cast<size_t>(owner)) * kLanes + lane;
    const size_t point = i % q, patch = tile.first + i / q;
    const Vec3d normal =
        DefinitionNormal(tile.plan, tile.control_points, patch, Barycentrics(surface, point),
                         kSmooth, Turned{tile.turned});
    surface.writer.WriteNormal(surface.layout.Place(surface.vertices, patch), point,
                               ToFloat(normal));
  }
}

template <Normals kNormals>
void Launch(const Tile& tile, const Surface& surface, size_t points, cudaStream_t stream) {
  constexpr bool kHasNormals = kNormals != Normals::kNone;
  const auto kernel = kHasNormals && tile.plan.weights.vertices != nullptr
                          ? SurfaceKernel<kNormals, kHasNormals>
                          : SurfaceKernel<kNormals, false>;
  kernel<<<Blocks(points), kBlockThreads, 0, stream>>>(tile, surface);
  if constexpr (kHasNormals) {
    IllKernel<kNormals == Normals::kSmooth>
        <<<Blocks(IllWords(points)), kBlockThreads, 0, stream>>>(tile, surface);
  }
}

}  // namespace

cudaError_t LaunchSurface(const Tile& tile, const Surface& surface, cudaStream_t stream) {
  const size_t points = tile.count * static_cast<size_t>(surface.q);
  if (points == 0) return cudaSuccess;
  switch (surface.normals) {
    case Normals::kNone:
      Launch<Normals::kNone>(tile, surface, points, stream);
      break;
    case Normals::kFacet:
      Launch<Normals::kFacet>(tile, surface, points, stream);
      break;
    case Normals::kSmooth:
      Launch<Normals::kSmooth>(tile, surface, points, stream);
      break;
  }
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
