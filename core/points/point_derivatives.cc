// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/point_derivatives.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/status_macros.h"
#include "core/points/point_kernel.h"
#include "core/points/point_normal.h"

namespace latticed {
namespace {

using points::BlockSlopes;
using points::BlockVec;
using points::kBlockPoints;

constexpr size_t kOutsideGrain = 16'384;  // points of one part of a loop that copies

// Up to kBlockPoints points of one run.
struct Block {
  const SortedPoints& points;
  const LocalMap& map;
  size_t first = 0;
  size_t count = 0;
  BlockVec local;

  size_t number(size_t i) const { return points.order()[first + i]; }
};

// Calls body(block) for the blocks of a run, in order.
template <class Body>
void ForBlocks(const SortedPoints& points, const SortedPoints::Run& run, const Body& body) {
  const LocalMap map = points.boxes().MapOf(run.box);
  Block block{.points = points, .map = map};
  for (size_t done = 0; done < run.count; done += kBlockPoints) {
    block.first = run.first + done;
    block.count = std::min<size_t>(kBlockPoints, run.count - done);
    points::MapBlock(map,
                     {points.world(0) + block.first, points.world(1) + block.first,
                      points.world(2) + block.first},
                     block.count, block.local);
    body(block);
  }
}

Vec3d At(const BlockVec& block, size_t i) { return {block[0][i], block[1][i], block[2][i]}; }

void Set(BlockVec& block, size_t i, Vec3d v) {
  for (size_t c = 0; c < 3; ++c) block[c][i] = v[static_cast<int>(c)];
}

// d/d(x, y, z) from d/d(l, m, n), at one point of a block.
std::array<Vec3d, 3> ToWorldColumns(const LocalMap& map, const BlockSlopes& slopes, size_t i) {
  std::array<Vec3d, 3> columns;
  for (int c = 0; c < 3; ++c) {
    auto& column = columns[static_cast<size_t>(c)];
    for (size_t a = 0; a < 3; ++a) column += map.scale[a][c] * At(slopes[a], i);
  }
  return columns;
}

// The transpose of ToWorldColumns: cotangents of d/d(l, m, n).
void SetFromWorldColumns(const LocalMap& map, const std::array<Vec3d, 3>& columns, size_t i,
                         BlockSlopes& slopes) {
  for (size_t a = 0; a < 3; ++a) {
    Set(slopes[a], i,
        map.scale[a].x * columns[0] + map.scale[a].y * columns[1] + map.scale[a].z * columns[2]);
  }
}

// The normals of a block, which its directions share.
std::vector<PointNormal> NormalsOf(const Block& block, const BoxPolynomial& polynomial) {
  BlockVec values;
  BlockSlopes slopes;
  points::EvaluateBlock(block.points.boxes().structure().degree, polynomial, block.local,
                        block.count, values, &slopes);
  std::vector<PointNormal> normals;
  normals.reserve(block.count);
  for (size_t i = 0; i < block.count; ++i) {
    normals.emplace_back(ToWorldColumns(block.map, slopes, i),
                         block.points.NormalAt(block.first + i));
  }
  return normals;
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
  const std::array<int, 3>& degree = boxes.structure().degree;
  arena.ForEach(points.runs().size(), [&](size_t r) {
    const SortedPoints::Run& run = points.runs()[r];
    const BoxPolynomial polynomial = boxes.PolynomialOf(run.box, control_points);
    BlockVec values;
    BlockSlopes slopes;
    ForBlocks(points, run, [&](const Block& block) {
      points::EvaluateBlock(degree, polynomial, block.local, block.count, values,
                            with_normals ? &slopes : nullptr);
      for (size_t i = 0; i < block.count; ++i) out[block.number(i)] = At(values, i);
      for (size_t i = 0; with_normals && i < block.count; ++i) {
        out[points.size() + block.number(i)] =
            PointNormal(ToWorldColumns(block.map, slopes, i), points.NormalAt(block.first + i))
                .value();
      }
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
  const std::array<int, 3>& degree = boxes.structure().degree;
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
      ForBlocks(points, run, [&](const Block& block) {
        const auto carried =
            with_normals ? NormalsOf(block, polynomial) : std::vector<PointNormal>();
        for (size_t d = 0; d < together; ++d) {
          points::EvaluateBlock(degree, velocity[d], block.local, block.count, values,
                                with_normals ? &slopes : nullptr);
          const auto moved = out.subspan((first + d) * per_direction, per_direction);
          for (size_t i = 0; i < block.count; ++i) moved[block.number(i)] = At(values, i);
          for (size_t i = 0; i < carried.size(); ++i) {
            moved[points.size() + block.number(i)] =
                carried[i].Velocity(ToWorldColumns(block.map, slopes, i));
          }
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
  std::ranges::fill(gradients, Vec3d());
  std::vector<BoxNumbers> sums(runs.size() * std::min(directions, kDirectionsTogether));
  for (size_t first = 0; first < directions; first += kDirectionsTogether) {
    LATTICED_RETURN_IF_ERROR(stop());
    const size_t together = std::min(kDirectionsTogether, directions - first);
    std::ranges::fill(sums, BoxNumbers());
    arena.ForEach(runs.size(), [&](size_t r) {
      const BoxPolynomial polynomial =
          with_normals ? boxes.PolynomialOf(runs[r].box, control_points) : BoxPolynomial();
      BlockVec forces;
      BlockSlopes slope_forces;
      ForBlocks(points, runs[r], [&](const Block& block) {
        const auto carried =
            with_normals ? NormalsOf(block, polynomial) : std::vector<PointNormal>();
        const size_t padded = points::PaddedCount(block.count);
        for (size_t d = 0; d < together; ++d) {
          const auto of = cotangents.subspan((first + d) * per_direction, per_direction);
          BoxNumbers& sum = sums[r * together + d];
          for (size_t i = 0; i < block.count; ++i) Set(forces, i, of[block.number(i)]);
          for (size_t i = block.count; i < padded; ++i) Set(forces, i, {});
          points::SumBlock(degree, block.local, forces, block.count, sum);
          if (!with_normals) continue;
          for (size_t i = 0; i < padded; ++i) {
            const auto columns = i < block.count
                                     ? carried[i].Cotangent(of[points.size() + block.number(i)])
                                     : std::array<Vec3d, 3>();
            SetFromWorldColumns(block.map, columns, i, slope_forces);
          }
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
