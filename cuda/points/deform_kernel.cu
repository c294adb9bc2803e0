// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points and their velocities: a block takes a piece, a thread every kPointThreads-th point of it.
#include "cuda/device/launch.cuh"
#include "cuda/points/box_point.cuh"

namespace latticed::kernels {
namespace {

// Shared variables of a kernel have no constructors.
struct Raw {
  alignas(BoxPolynomial) unsigned char bytes[sizeof(BoxPolynomial)];
  __device__ BoxPolynomial& polynomial() { return *reinterpret_cast<BoxPolynomial*>(bytes); }
};

template <bool kNormals>
__global__ void __launch_bounds__(kPointThreads) DeformKernel(const PointDeform deform) {
  __shared__ Raw raw[2];
  BoxPolynomial &values = raw[0].polynomial(), &shape = raw[1].polynomial();
  const PointTables& tables = deform.tables;
  const PointPiece piece = tables.pieces[blockIdx.x];
  const LocalMap map = tables.maps[piece.slot];
  const bool velocities = kNormals && deform.shape != nullptr;
  CopyToShared(deform.values[piece.slot], values);
  if (velocities) CopyToShared(deform.shape[piece.slot], shape);
  __syncthreads();
  for (uint32_t i = threadIdx.x; i < piece.count; i += kPointThreads) {
    const size_t place = piece.first + i, number = tables.order[place];
    const Vec3d local = ToLocal(map, WorldAt(tables.world, place));
    const PointJet jet = EvaluateBox<kNormals>(values, tables.degree, local);
    deform.out[number] = jet.value;
    if constexpr (kNormals) {
      const std::array<Vec3d, 3> columns = ToWorldColumns(map, jet.slopes);
      const Vec3d rest = WorldAt(tables.normal, place);
      Vec3d& out = deform.out[tables.points + number];
      if (velocities) {
        const PointJet at = EvaluateBox<true>(shape, tables.degree, local);
        out = PointNormal(ToWorldColumns(map, at.slopes), rest).Velocity(columns);
      } else {
        out = PointNormal(columns, rest).value();
      }
    }
  }
}

struct OutsidePoints {
  PointDeform deform;
  bool velocities;
};

__global__ void OutsideKernel(const OutsidePoints outside) {
  const PointTables& tables = outside.deform.tables;
  const size_t place = tables.inside + Item();
  if (place >= tables.points) return;
  const size_t number = tables.order[place];
  Vec3d* const out = outside.deform.out;
  out[number] = outside.velocities ? Vec3d{} : WorldAt(tables.world, place);
  if (!outside.deform.with_normals) return;
  out[tables.points + number] = outside.velocities ? Vec3d{} : WorldAt(tables.normal, place);
}

}  // namespace

KernelCall DeformCall(const PointDeform& deform) {
  return {deform.with_normals ? DeformKernel<true> : DeformKernel<false>,
          Order::kAfter,
          deform.tables.piece_count,
          kPointThreads,
          0,
          deform};
}

KernelCall OutsideCall(const PointDeform& deform, bool velocities) {
  const PointTables& tables = deform.tables;
  return {OutsideKernel,
          Order::kAfter,
          Blocks(tables.points - tables.inside),
          kBlockThreads,
          0,
          OutsidePoints{deform, velocities}};
}

}  // namespace latticed::kernels
