// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/summed_points.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/direct_ffd.h"
#include "core/points/normal_kernel.h"
#include "core/points/point_blocks.h"
#include "core/points/point_columns.h"

namespace latticed {
namespace {

using points::Block;
using points::BlockNormals;
using points::BlockSlopes;
using points::BlockVec;

constexpr size_t kSummedGrain = 16'384;  // points of one part of a loop that adds
constexpr size_t kNormalGrain = 16;      // blocks of points

// Directions that are evaluated together: the normals of each take more memory.
size_t Together(size_t directions, PointNormals normals) {
  return std::min(directions, normals == PointNormals::kWanted ? size_t{1} : kDirectionsTogether);
}

// Calls body(place) for the points in the frame.
template <class Body>
void ForInside(const SortedPoints& points, CpuArena& arena, const Body& body) {
  arena.ForEach(points.inside(), body, kSummedGrain);
}

void GatherColumns(const Block& block, std::span<const Vec3d> columns, BlockSlopes& out) {
  const size_t size = block.points.size();
  for (size_t a = 0; a < kColumns; ++a) points::Gather(block, columns.subspan(a * size), out[a]);
}

// Calls body(block, normals) for all points, with the normals that the columns carry.
template <class Body>
void ForNormals(const SortedPoints& points, std::span<const Vec3d> columns, CpuArena& arena,
                const Body& body) {
  const size_t blocks = (points.size() + points::kBlockPoints - 1) / points::kBlockPoints;
  arena.ForRanges(blocks, kNormalGrain, [&](size_t begin, size_t end) {
    Block block{.points = points, .map = kWorldMap};
    BlockSlopes slopes;
    BlockNormals normals;
    for (size_t b = begin; b < end; ++b) {
      block.first = b * points::kBlockPoints;
      block.count = std::min(points::kBlockPoints, points.size() - block.first);
      GatherColumns(block, columns, slopes);
      points::MakeNormals(kWorldMap, slopes, block.normals(), block.count, normals);
      body(block, normals);
    }
  });
}

// The cotangents of the columns, for those of the normals.
void SetColumnCotangents(const SortedPoints& points, std::span<const Vec3d> columns,
                         std::span<const Vec3d> cotangents, CpuArena& arena, std::span<Vec3d> out) {
  ForNormals(points, columns, arena, [&](const Block& block, const BlockNormals& normals) {
    BlockVec forces;
    BlockSlopes slopes;
    points::Gather(block, cotangents, forces);
    points::NormalCotangents(kWorldMap, normals, forces, block.count, slopes);
    for (size_t a = 0; a < kColumns; ++a) {
      points::Scatter(block, slopes[a], out.subspan(a * points.size()));
    }
  });
}

}  // namespace

SummedPoints::SummedPoints(std::vector<std::shared_ptr<PointEvaluator>> lattices, CpuArena* arena)
    : arena_(arena) {
  for (auto& evaluator : lattices) {
    const LatticeStructure& structure = evaluator->points().boxes().structure();
    const auto count = static_cast<size_t>(structure.control_point_count());
    parts_.push_back({std::move(evaluator), control_points_, count});
    control_points_ += count;
  }
  std::vector<FrameMap> maps;
  for (const Part& part : parts_) maps.emplace_back(part.points().boxes().structure());
  const size_t inside = points().inside();
  std::atomic<size_t> outside = 0;
  arena_->ForRanges(points().size() - inside, kSummedGrain, [&](size_t begin, size_t end) {
    size_t count = 0;
    for (size_t i = begin; i < end; ++i) {
      bool reached = false;
      for (size_t g = 1; g < parts_.size() && !reached; ++g) {
        reached = FindVolumePlace(parts_[g].points().boxes().structure(), maps[g],
                                  points().WorldAt(inside + i))
                      .has_value();
      }
      if (!reached) ++count;
    }
    outside += count;
  });
  points_outside_ = outside;
}

std::vector<Vec3d> SummedPoints::Columns(std::span<const Vec3d> control_points) const {
  const size_t size = points().size();
  std::vector<Vec3d> columns(kColumns * size);
  for (size_t a = 0; a < kColumns; ++a) {
    std::ranges::fill(std::span(columns).subspan(a * size, size), kWorldMap.scale[a]);
  }
  for (const Part& part : parts_) {
    AddColumns(part.points(), part.Own(control_points), *arena_, columns);
  }
  return columns;
}

absl::Status SummedPoints::Deform(std::span<const Vec3d> control_points, PointNormals normals,
                                  StopCheck stop, std::span<Vec3d> out) {
  const size_t size = points().size();
  const std::span<Vec3d> positions = out.first(size);
  LATTICED_RETURN_IF_ERROR(parts_[0].evaluator->Deform(parts_[0].Own(control_points),
                                                       PointNormals::kNone, stop, positions));
  {
    std::vector<Vec3d> deformed(size);
    for (const Part& part : std::span(parts_).subspan(1)) {
      LATTICED_RETURN_IF_ERROR(
          part.evaluator->Deform(part.Own(control_points), PointNormals::kNone, stop, deformed));
      ForInside(part.points(), *arena_, [&](size_t place) {
        const size_t number = part.points().order()[place];
        positions[number] += deformed[number] - part.points().WorldAt(place);
      });
    }
  }
  if (normals == PointNormals::kNone) return absl::OkStatus();
  const std::vector<Vec3d> columns = Columns(control_points);
  ForNormals(points(), columns, *arena_, [&](const Block& block, const BlockNormals& carried) {
    points::Scatter(block, carried.value, out.subspan(size));
  });
  return absl::OkStatus();
}

absl::Status SummedPoints::AddVelocities(const Part& part, std::span<const Vec3d> control_points,
                                         std::span<const Vec3d> own_tangents, StopCheck stop,
                                         std::span<Vec3d> velocities,
                                         std::span<Vec3d> rates) const {
  std::vector<Vec3d> own(velocities.size());
  LATTICED_RETURN_IF_ERROR(part.evaluator->ApplyJacobian(part.Own(control_points), own_tangents,
                                                         PointNormals::kNone, stop, own));
  const size_t size = points().size();
  ForInside(part.points(), *arena_, [&](size_t place) {
    for (size_t i = part.points().order()[place]; i < own.size(); i += size)
      velocities[i] += own[i];
  });
  if (!rates.empty()) AddColumnRates(part.points(), own_tangents, *arena_, rates);
  return absl::OkStatus();
}

absl::Status SummedPoints::ApplyJacobian(std::span<const Vec3d> control_points,
                                         std::span<const Vec3d> tangents, PointNormals normals,
                                         StopCheck stop, std::span<Vec3d> out) {
  const bool with_normals = normals == PointNormals::kWanted;
  const size_t size = points().size(), per_direction = VectorsPerDirection(points(), normals);
  const size_t directions = tangents.size() / control_points_;
  std::vector<Vec3d> columns;
  if (with_normals) columns = Columns(control_points);
  std::vector<Vec3d> rates(columns.size());
  for (size_t first = 0, together = 0; first < directions; first += together) {
    LATTICED_RETURN_IF_ERROR(stop());
    together = Together(directions - first, normals);
    const std::span<Vec3d> velocities = out.subspan(first * per_direction, together * size);
    std::ranges::fill(velocities, Vec3d());
    std::ranges::fill(rates, Vec3d());
    for (const Part& part : parts_) {
      std::vector<Vec3d> own;
      for (size_t d = first; d < first + together; ++d) {
        const auto one = part.Own(tangents.subspan(d * control_points_, control_points_));
        own.insert(own.end(), one.begin(), one.end());
      }
      // Most calls move the control points of one lattice.
      if (std::ranges::all_of(own, [](Vec3d v) { return v == Vec3d(); })) continue;
      LATTICED_RETURN_IF_ERROR(AddVelocities(part, control_points, own, stop, velocities, rates));
    }
    if (!with_normals) continue;
    const auto moved = out.subspan(first * per_direction + size, size);
    ForNormals(points(), columns, *arena_, [&](const Block& block, const BlockNormals& carried) {
      BlockSlopes slopes;
      BlockVec values;
      GatherColumns(block, rates, slopes);
      points::NormalVelocities(kWorldMap, carried, slopes, block.count, values);
      points::Scatter(block, values, moved);
    });
  }
  return absl::OkStatus();
}

absl::Status SummedPoints::ApplyJacobianTranspose(std::span<const Vec3d> control_points,
                                                  std::span<const Vec3d> cotangents,
                                                  PointNormals normals, StopCheck stop,
                                                  std::span<Vec3d> gradients) {
  const bool with_normals = normals == PointNormals::kWanted;
  const size_t size = points().size(), per_direction = VectorsPerDirection(points(), normals);
  const size_t directions = gradients.size() / control_points_;
  std::vector<Vec3d> columns;
  if (with_normals) columns = Columns(control_points);
  std::vector<Vec3d> of_columns(columns.size());
  for (size_t first = 0, together = 0; first < directions; first += together) {
    together = Together(directions - first, normals);
    const auto forces = cotangents.subspan(first * per_direction, together * size);
    if (with_normals) {
      LATTICED_RETURN_IF_ERROR(stop());
      SetColumnCotangents(points(), columns, cotangents.subspan(first * per_direction + size, size),
                          *arena_, of_columns);
    }
    for (const Part& part : parts_) {
      std::vector<Vec3d> own(together * part.count);
      LATTICED_RETURN_IF_ERROR(part.evaluator->ApplyJacobianTranspose(
          part.Own(control_points), forces, PointNormals::kNone, stop, own));
      if (with_normals) AddColumnGradients(part.points(), of_columns, *arena_, own);
      for (size_t d = 0; d < together; ++d) {
        std::ranges::copy(std::span(own).subspan(d * part.count, part.count),
                          gradients.subspan((first + d) * control_points_ + part.first).begin());
      }
    }
  }
  return absl::OkStatus();
}

size_t SummedPoints::MostControlPoints() const {
  size_t most = 0;
  for (const Part& part : parts_) most = std::max(most, part.count);
  return most;
}

uint64_t SummedPoints::ForwardBytes(size_t directions, PointNormals normals) const {
  const size_t size = points().size(), together = Together(directions, normals);
  const size_t columns = normals == PointNormals::kWanted ? 2 * kColumns * size : 0;
  return (together * (size + MostControlPoints()) + columns) * sizeof(Vec3d);
}

uint64_t SummedPoints::TransposeBytes(size_t directions, PointNormals normals) const {
  const size_t size = points().size(), together = Together(directions, normals);
  uint64_t sums = 0;
  for (const Part& part : parts_) {
    sums = std::max(sums, part.evaluator->TransposeBytes(together, PointNormals::kNone));
    if (normals == PointNormals::kWanted) sums = std::max(sums, SumBytes(part.points(), 1));
  }
  const size_t columns = normals == PointNormals::kWanted ? 2 * kColumns * size : 0;
  return sums + (together * MostControlPoints() + columns) * sizeof(Vec3d);
}

uint64_t SummedPoints::device_bytes() const {
  uint64_t bytes = 0;
  for (const Part& part : parts_) bytes += part.evaluator->device_bytes();
  return bytes;
}

}  // namespace latticed
