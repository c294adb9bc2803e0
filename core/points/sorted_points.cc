// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/points/sorted_points.h"

#include <algorithm>

#include "core/ffd/direct_ffd.h"

namespace latticed {
namespace {

constexpr size_t kSortedGrain = 16'384;  // points of one part of a loop: about a millisecond

}  // namespace

SortedPoints::SortedPoints(const LatticeStructure& structure, std::span<const Vec3d> points,
                           std::span<const Vec3d> normals, CpuArena& arena,
                           std::span<const PointWeight> weights)
    : boxes_(structure), order_(points.size()) {
  const size_t outside = boxes_.count();
  std::vector<uint32_t> box_of(points.size());
  const FrameMap map(structure);
  arena.ForEach(
      points.size(),
      [&](size_t i) {
        const auto place = FindVolumePlace(structure, map, points[i]);
        box_of[i] = static_cast<uint32_t>(place.has_value() ? boxes_.BoxOf(place->span) : outside);
      },
      kSortedGrain);

  std::vector<size_t> first_of_box(outside + 2);
  for (const uint32_t box : box_of) ++first_of_box[box + 1];
  for (size_t box = 0; box <= outside; ++box) first_of_box[box + 1] += first_of_box[box];
  inside_ = first_of_box[outside];
  MakeRuns(first_of_box);
  for (size_t i = 0; i < points.size(); ++i) {
    order_[first_of_box[box_of[i]]++] = static_cast<uint32_t>(i);
  }

  for (auto& axis : world_) axis.resize(points.size());
  if (!normals.empty()) {
    for (auto& axis : normal_) axis.resize(points.size());
  }
  weight_.resize(weights.size());
  arena.ForEach(
      points.size(),
      [&](size_t place) {
        const size_t i = order_[place];
        if (!weights.empty()) weight_[place] = weights[i];
        const Vec3d normal = normals.empty() ? Vec3d() : normals[i];
        for (size_t a = 0; a < 3; ++a) {
          world_[a][place] = points[i][static_cast<int>(a)];
          if (!normals.empty()) normal_[a][place] = normal[static_cast<int>(a)];
        }
      },
      kSortedGrain);
}

void SortedPoints::MakeRuns(std::span<const size_t> first_of_box) {
  for (size_t box = 0; box < boxes_.count(); ++box) {
    for (size_t first = first_of_box[box]; first < first_of_box[box + 1]; first += kRunPoints) {
      const size_t count = std::min(kRunPoints, first_of_box[box + 1] - first);
      runs_.push_back({first, static_cast<uint32_t>(count), static_cast<uint32_t>(box)});
    }
  }
}

SortedPoints SortedPoints::Resorted(const LatticeStructure& structure, CpuArena& arena,
                                    bool with_normals) const {
  std::vector<Vec3d> points(size()), normals(with_normals && has_normals() ? size() : 0);
  std::vector<PointWeight> weights(weight_.size());
  arena.ForEach(
      size(),
      [&](size_t place) {
        points[order_[place]] = WorldAt(place);
        if (!normals.empty()) normals[order_[place]] = NormalAt(place);
        if (!weights.empty()) weights[order_[place]] = weight_[place];
      },
      kSortedGrain);
  return SortedPoints(structure, points, normals, arena, weights);
}

uint64_t SortedPoints::BytesFor(uint64_t points, bool with_normals, bool with_weights) {
  return points * (sizeof(uint32_t) + sizeof(Vec3d) * (with_normals ? 2 : 1) +
                   (with_weights ? sizeof(PointWeight) : 0));
}

uint64_t SortedPoints::MemoryBytes() const {
  return BytesFor(size(), has_normals(), has_weights()) + runs_.capacity() * sizeof(Run);
}

}  // namespace latticed
