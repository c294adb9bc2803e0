// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/point_columns.h"

#include <algorithm>
#include <vector>

#include "core/points/point_blocks.h"

namespace latticed {
namespace {

using points::Block;
using points::BlockSlopes;
using points::BlockVec;
using points::ForBlocks;

// Of derivatives by l, m, n. `identity`: what to take off the diagonal.
void AddSlopes(const Block& block, const BlockSlopes& slopes, double identity,
               std::span<Vec3d> columns) {
  const size_t size = block.points.size();
  for (size_t i = 0; i < block.count; ++i) {
    for (size_t a = 0; a < kColumns; ++a) {
      const int axis = static_cast<int>(a);
      Vec3d column;
      for (size_t l = 0; l < 3; ++l) {
        column += block.map.scale[l][axis] * points::At(slopes[l], i);
      }
      column[axis] -= identity;
      columns[a * size + block.number(i)] += column;
    }
  }
}

// The transposed: cotangents of the derivatives by l, m, n.
void GatherSlopes(const Block& block, std::span<const Vec3d> columns, BlockSlopes& slopes) {
  const size_t size = block.points.size();
  for (size_t l = 0; l < 3; ++l) {
    const Vec3d scale = block.map.scale[l];
    for (size_t i = 0; i < block.count; ++i) {
      const size_t number = block.number(i);
      points::Set(slopes[l], i,
                  scale.x * columns[number] + scale.y * columns[size + number] +
                      scale.z * columns[2 * size + number]);
    }
    for (size_t i = block.count; i < points::PaddedCount(block.count); ++i) {
      points::Set(slopes[l], i, {});
    }
  }
}

}  // namespace

void AddColumns(const SortedPoints& points, std::span<const Vec3d> control_points, CpuArena& arena,
                std::span<Vec3d> columns) {
  arena.ForEach(points.runs().size(), [&](size_t r) {
    const SortedPoints::Run& run = points.runs()[r];
    const BoxPolynomial polynomial = points.boxes().PolynomialOf(run.box, control_points);
    BlockVec values;
    BlockSlopes slopes;
    ForBlocks(points, run, [&](const Block& block) {
      points::SetValues(block, polynomial, values, &slopes);
      AddSlopes(block, slopes, 1, columns);
    });
  });
}

void AddColumnRates(const SortedPoints& points, std::span<const Vec3d> tangents, CpuArena& arena,
                    std::span<Vec3d> rates) {
  arena.ForEach(points.runs().size(), [&](size_t r) {
    const SortedPoints::Run& run = points.runs()[r];
    const BoxPolynomial velocity = points.boxes().VelocityOf(run.box, tangents);
    BlockVec values;
    BlockSlopes slopes;
    ForBlocks(points, run, [&](const Block& block) {
      points::SetVelocities(block, velocity, values, &slopes);
      AddSlopes(block, slopes, 0, rates);
    });
  });
}

void AddColumnGradients(const SortedPoints& points, std::span<const Vec3d> cotangents,
                        CpuArena& arena, std::span<Vec3d> gradients) {
  const BoxMaps& boxes = points.boxes();
  const std::array<int, 3>& degree = boxes.structure().degree;
  const auto& runs = points.runs();
  std::vector<BoxNumbers> sums(runs.size());
  arena.ForEach(runs.size(), [&](size_t r) {
    BlockVec forces;
    BlockSlopes slope_forces;
    ForBlocks(points, runs[r], [&](const Block& block) {
      GatherSlopes(block, cotangents, slope_forces);
      if (points.has_weights()) {  // a weight's gradient makes columns of what a point is moved
        for (auto& component : forces) component.fill(0);
        block.weights().WeighCotangents(forces, &slope_forces);
        points::SumBlock(degree, block.local, forces, block.count, sums[r]);
      }
      points::SumSlopeBlock(degree, block.local, slope_forces, block.count, sums[r]);
    });
  });
  for (size_t r = 0; r < runs.size(); ++r) boxes.AddGradient(runs[r].box, sums[r], gradients);
}

}  // namespace latticed
