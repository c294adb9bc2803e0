// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/point_derivatives.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/status_macros.h"
#include "core/points/normal_kernel.h"
#include "core/points/point_blocks.h"
#include "core/points/point_kernel.h"

namespace latticed {
namespace {

using points::Block;
using points::BlockNormals;
using points::BlockSlopes;
using points::BlockVec;
using points::ForBlocks;
using points::Gather;
using points::Scatter;
using points::SetValues;
using points::SetVelocities;

constexpr size_t kOutsideGrain = 16'384;  // points of one part of a loop that copies

// From the derivatives by l, m, n.
void SetNormals(const Block& block, const BlockSlopes& slopes, BlockNormals& normals) {
  points::MakeNormals(block.map, slopes, block.normals(), block.count, normals);
}

// The normals of a block, which its directions share.
void SetNormals(const Block& block, const BoxPolynomial& polynomial, BlockNormals& normals) {
  BlockVec values;
  BlockSlopes slopes;
  SetValues(block, polynomial, values, &slopes);
  SetNormals(block, slopes, normals);
}

// Calls body(place) for the points outside the frame.
template <class Body>
void ForOutside(const SortedPoints& points, CpuArena& arena, const Body& body) {
  arena.ForEach(
      points.size() - points.inside(), [&](size_t i) { body(points.inside() + i); }, kOutsideGrain);
}

}  // namespace

absl::Status Deform(const SortedPoints& points, std::span<const Vec3d> control_points,
                    PointNormals normals, CpuArena& arena, StopCheck stop, std::span<Vec3d> out) {
  LATTICED_RETURN_IF_ERROR(stop());
  const bool with_normals = normals == PointNormals::kWanted;
  const BoxMaps& boxes = points.boxes();
  arena.ForEach(points.runs().size(), [&](size_t r) {
    const SortedPoints::Run& run = points.runs()[r];
    const BoxPolynomial polynomial = boxes.PolynomialOf(run.box, control_points);
    BlockVec values;
    BlockSlopes slopes;
    BlockNormals carried;
    ForBlocks(points, run, [&](const Block& block) {
      SetValues(block, polynomial, values, with_normals ? &slopes : nullptr);
      Scatter(block, values, out);
      if (!with_normals) return;
      SetNormals(block, slopes, carried);
      Scatter(block, carried.value, out.subspan(points.size()));
    });
  });
  ForOutside(points, arena, [&](size_t place) {
    const size_t number = points.order()[place];
    out[number] = points.WorldAt(place);
    if (with_normals) out[points.size() + number] = points.NormalAt(place);
  });
  return absl::OkStatus();
}

absl::Status ApplyJacobian(const SortedPoints& points, std::span<const Vec3d> control_points,
                           std::span<const Vec3d> tangents, PointNormals normals, CpuArena& arena,
                           StopCheck stop, std::span<Vec3d> out) {
  const bool with_normals = normals == PointNormals::kWanted;
  const BoxMaps& boxes = points.boxes();
  const size_t per_direction = VectorsPerDirection(points, normals);
  const size_t directions = tangents.size() / control_points.size();
  for (size_t first = 0; first < directions; first += kDirectionsTogether) {
    LATTICED_RETURN_IF_ERROR(stop());
    const size_t together = std::min(kDirectionsTogether, directions - first);
    arena.ForEach(points.runs().size(), [&](size_t r) {
      const SortedPoints::Run& run = points.runs()[r];
      std::array<BoxPolynomial, kDirectionsTogether> velocity;
      for (size_t d = 0; d < together; ++d) {
        velocity[d] = boxes.VelocityOf(
            run.box, tangents.subspan((first + d) * control_points.size(), control_points.size()));
      }
      const BoxPolynomial polynomial =
          with_normals ? boxes.PolynomialOf(run.box, control_points) : BoxPolynomial();
      BlockVec values;
      BlockSlopes slopes;
      BlockNormals carried;
      ForBlocks(points, run, [&](const Block& block) {
        if (with_normals) SetNormals(block, polynomial, carried);
        for (size_t d = 0; d < together; ++d) {
          BlockSlopes* const rates = with_normals ? &slopes : nullptr;
          SetVelocities(block, velocity[d], values, rates);
          const auto moved = out.subspan((first + d) * per_direction, per_direction);
          Scatter(block, values, moved);
          if (!with_normals) continue;
          points::NormalVelocities(block.map, carried, slopes, block.count, values);
          Scatter(block, values, moved.subspan(points.size()));
        }
      });
    });
  }
  ForOutside(points, arena, [&](size_t place) {
    const size_t number = points.order()[place];
    for (size_t d = 0; d < directions; ++d) {
      out[d * per_direction + number] = {};
      if (with_normals) out[d * per_direction + points.size() + number] = {};
    }
  });
  return absl::OkStatus();
}

absl::Status ApplyJacobianTranspose(const SortedPoints& points,
                                    std::span<const Vec3d> control_points,
                                    std::span<const Vec3d> cotangents, PointNormals normals,
                                    CpuArena& arena, StopCheck stop, std::span<Vec3d> gradients) {
  const bool with_normals = normals == PointNormals::kWanted;
  const BoxMaps& boxes = points.boxes();
  const std::array<int, 3>& degree = boxes.structure().degree;
  const size_t per_direction = VectorsPerDirection(points, normals);
  const size_t directions = gradients.size() / control_points.size();
  const auto& runs = points.runs();
  // Directions share the normals of points. Without those, cotangents of several are only more memory to gather from at once.
  const size_t most = with_normals ? kDirectionsTogether : 1;
  std::ranges::fill(gradients, Vec3d());
  std::vector<BoxNumbers> sums(runs.size() * std::min(directions, most));
  for (size_t first = 0; first < directions; first += most) {
    LATTICED_RETURN_IF_ERROR(stop());
    const size_t together = std::min(most, directions - first);
    std::ranges::fill(sums, BoxNumbers());
    arena.ForEach(runs.size(), [&](size_t r) {
      const BoxPolynomial polynomial =
          with_normals ? boxes.PolynomialOf(runs[r].box, control_points) : BoxPolynomial();
      BlockVec forces;
      BlockSlopes slope_forces;
      BlockNormals carried;
      ForBlocks(points, runs[r], [&](const Block& block) {
        if (with_normals) SetNormals(block, polynomial, carried);
        for (size_t d = 0; d < together; ++d) {
          const auto of = cotangents.subspan((first + d) * per_direction, per_direction);
          BoxNumbers& sum = sums[r * together + d];
          if (with_normals) {
            Gather(block, of.subspan(points.size()), forces);
            points::NormalCotangents(block.map, carried, forces, block.count, slope_forces);
          }
          Gather(block, of, forces);
          if (points.has_weights()) {
            block.weights().WeighCotangents(forces, with_normals ? &slope_forces : nullptr);
          }
          points::SumBlock(degree, block.local, forces, block.count, sum);
          if (!with_normals) continue;
          points::SumSlopeBlock(degree, block.local, slope_forces, block.count, sum);
        }
      });
    });
    // In the order of runs, whichever thread has summed which.
    arena.ForEach(together, [&](size_t d) {
      const auto gradient =
          gradients.subspan((first + d) * control_points.size(), control_points.size());
      for (size_t r = 0; r < runs.size(); ++r) {
        boxes.AddGradient(runs[r].box, sums[r * together + d], gradient);
      }
    });
  }
  return absl::OkStatus();
}

}  // namespace latticed
