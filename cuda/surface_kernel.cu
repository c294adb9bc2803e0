// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From the products to vertices: rearrangement and normals.          Cui & Feng 2014, §3.6
//
//   facet   Pu x Pv
//   smooth  with N the interpolated vertex normal, e1, e2 the rest edges and f the facet normal,
//           cof(J) N ~ (N.f) Pu x Pv + (N.e1) Pv x Pf + (N.e2) Pf x Pu        DESIGN §2 "Normals"
//   Where the float products cancel beyond kMostCondition, the definition in double answers: folds,
//   collapsed lattices and extreme slivers. As in core/cpu/gemm_kernel.h.
#include "cuda/definition_normal.cuh"

namespace latticed::kernels {
namespace {

constexpr double kMostCondition = 1e3;

// Row `row` of the patch's columns x, y and z.
__device__ Vec3d Column(const float* products, size_t rows, size_t row, size_t patch,
                        size_t patches) {
  const float* x = products + patch * rows + row;
  const size_t stride = patches * rows;
  return {double{x[0]}, double{x[stride]}, double{x[2 * stride]}};
}

// A vector along the normal and a bound of what its terms were before they cancelled.
struct RawNormal {
  Vec3d direction;
  double bound;
};

__device__ RawNormal FacetNormal(Vec3d pu, Vec3d pv) {
  return {Cross(pu, pv), Norm(pu) * Norm(pv)};
}

__device__ RawNormal SmoothNormal(const PlanTables& plan, size_t patch, Vec3d b, Vec3d pu, Vec3d pv,
                                  Vec3d pf) {
  const DevicePatch p = plan.patches[patch];
  const Vec3d corner = plan.vertices[p.vertex[0]].world;
  const Vec3d n = RestSmoothNormal(plan, patch, b);
  const double by_f = Dot(n, ToDouble(plan.facet_normals[patch]));
  const double by_1 = Dot(n, plan.vertices[p.vertex[1]].world - corner);
  const double by_2 = Dot(n, plan.vertices[p.vertex[2]].world - corner);
  const double u = Norm(pu), v = Norm(pv), f = Norm(pf);
  return {by_f * Cross(pu, pv) + by_1 * Cross(pv, pf) + by_2 * Cross(pf, pu),
          std::abs(by_f) * u * v + f * (std::abs(by_1) * v + std::abs(by_2) * u)};
}

template <Normals kNormals>
__global__ void __launch_bounds__(kBlockThreads)
    SurfaceKernel(const __grid_constant__ Tile tile, const __grid_constant__ Surface surface) {
  const size_t i = Item(), q = static_cast<size_t>(surface.q);
  if (i >= q * tile.count) return;
  const size_t in_tile = i / q, point = i % q, patch = tile.first + in_tile;
  const auto row = [&](size_t block) {
    return Column(surface.products, surface.rows, block * q + point, in_tile, tile.count);
  };
  const PatchPlace place = surface.layout.Place(surface.vertices, patch);
  surface.writer.WritePosition(place, point, surface.centres[in_tile] + row(0));
  if constexpr (kNormals == Normals::kNone) return;

  const Vec3d pu = row(1), pv = row(2);
  const uchar4 t = surface.pattern[point];
  const double over = 1.0 / surface.segments;
  const Vec3d b{t.x * over, t.y * over, t.z * over};
  constexpr bool kIsSmooth = kNormals == Normals::kSmooth;
  RawNormal raw;
  if constexpr (kIsSmooth) {
    raw = SmoothNormal(tile.plan, patch, b, pu, pv,
                       Column(surface.across, q, point, in_tile, tile.count));
  } else {
    raw = FacetNormal(pu, pv);
  }
  const double length = Norm(raw.direction);
  const bool sound = std::isfinite(length) && length > 0 && raw.bound <= kMostCondition * length;
  const Vec3d normal = sound
                           ? raw.direction / length
                           : DefinitionNormal(tile.plan, tile.control_points, patch, b, kIsSmooth);
  surface.writer.WriteNormal(place, point, ToFloat(normal));
}

}  // namespace

cudaError_t LaunchSurface(const Tile& tile, const Surface& surface, cudaStream_t stream) {
  const size_t points = tile.count * static_cast<size_t>(surface.q);
  if (points == 0) return cudaSuccess;
  switch (surface.normals) {
    case Normals::kNone:
      SurfaceKernel<Normals::kNone><<<Blocks(points), kBlockThreads, 0, stream>>>(tile, surface);
      break;
    case Normals::kFacet:
      SurfaceKernel<Normals::kFacet><<<Blocks(points), kBlockThreads, 0, stream>>>(tile, surface);
      break;
    case Normals::kSmooth:
      SurfaceKernel<Normals::kSmooth><<<Blocks(points), kBlockThreads, 0, stream>>>(tile, surface);
      break;
  }
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
