// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/dirty_set.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/base/bounds.h"
#include "core/base/limits.h"

namespace latticed {
namespace {

constexpr auto kPatchesPerChunk = static_cast<uint32_t>(limits::kPatchesPerChunk);

// The boxes along an axis, or patches, first … last - 1.
struct Range {
  uint32_t first, last;
};

// Along an axis of a lattice, for each span and for the end: the number of boxes with a lower span.
std::vector<uint32_t> BoxesBelow(const LatticeStructure& s, size_t axis) {
  const std::vector<double>& knots = s.knots[axis];
  std::vector<uint32_t> below(static_cast<size_t>(s.size[axis]) + 1);
  for (auto span = static_cast<size_t>(s.degree[axis]); span + 1 < below.size(); ++span) {
    below[span + 1] = below[span] + (knots[span + 1] > knots[span] ? 1 : 0);
  }
  return below;
}

// The patches of the boxes. Boxes whose patches follow each other share a range.
std::vector<Range> PatchesOf(const DeformPlan& plan, const std::vector<bool>& boxes) {
  std::vector<Range> ranges;
  for (size_t box = 0; box < boxes.size(); ++box) {
    const Range own{plan.box_patches[box], plan.box_patches[box + 1]};
    if (!boxes[box] || own.first == own.last) continue;
    if (!ranges.empty() && ranges.back().last == own.first) {
      ranges.back().last = own.last;
    } else {
      ranges.push_back(own);
    }
  }
  return ranges;
}

// The patches outside the ranges, ascending, that have a vertex or edge which one of the boxes owns.
std::vector<uint32_t> BorrowersBeside(const DeformPlan& plan, const std::vector<bool>& boxes,
                                      std::span<const Range> ranges) {
  std::vector<uint32_t> patches;
  const bool covers_all =
      ranges.size() == 1 && ranges[0].last - ranges[0].first == plan.patches.size();
  if (covers_all) return patches;  // asked first, because all lists of borrowers are cold by now
  for (size_t box = 0; box < boxes.size(); ++box) {
    if (!boxes[box]) continue;
    const std::vector<uint32_t>& borrowers = plan.box_borrowers[box];
    auto at = borrowers.begin();
    for (const Range& range : ranges) {
      const auto first = std::lower_bound(at, borrowers.end(), range.first);
      patches.insert(patches.end(), at, first);
      at = std::lower_bound(first, borrowers.end(), range.last);
    }
    patches.insert(patches.end(), at, borrowers.end());
  }
  std::ranges::sort(patches);
  patches.erase(std::unique(patches.begin(), patches.end()), patches.end());
  return patches;
}

void AddChunk(uint32_t chunk, std::vector<uint32_t>& chunks) {
  if (chunks.empty() || chunks.back() != chunk) chunks.push_back(chunk);
}

std::vector<uint32_t> ChunksOf(std::span<const Range> ranges, std::span<const uint32_t> patches) {
  std::vector<uint32_t> of_ranges, of_patches, chunks;
  for (const Range& range : ranges) {
    for (uint32_t chunk = range.first / kPatchesPerChunk; chunk * kPatchesPerChunk < range.last;
         ++chunk) {
      AddChunk(chunk, of_ranges);
    }
  }
  for (const uint32_t patch : patches) AddChunk(patch / kPatchesPerChunk, of_patches);
  if (of_patches.empty()) return of_ranges;
  std::ranges::set_union(of_ranges, of_patches, std::back_inserter(chunks));
  return chunks;
}

// The moved control points of a turned lattice.
class MovedPoints {
 public:
  MovedPoints(const TurnedLattice& lattice, std::span<const uint32_t> indices)
      : lattice_(lattice), moved_(static_cast<size_t>(lattice.structure.control_point_count())) {
    for (const uint32_t index : indices) {
      if (index < lattice.first_point || index - lattice.first_point >= moved_.size()) continue;
      moved_[index - lattice.first_point] = true;
      Extend(static_cast<int>(index - lattice.first_point));
    }
  }

  // Whether the support of one of them has a vertex.
  bool Reach(size_t vertex) const {
    if (reach_.empty()) return false;
    const Vec3d p = lattice_.parameters[vertex];  // most vertices are beyond all of them
    if (p.x < reach_.min.x || p.x > reach_.max.x || p.y < reach_.min.y || p.y > reach_.max.y ||
        p.z < reach_.min.z || p.z > reach_.max.z) {
      return false;
    }
    const std::optional<PointRange> range = lattice_.Reaching(vertex);
    if (!range.has_value()) return false;
    for (int k = range->first[2]; k <= range->last[2]; ++k) {
      for (int j = range->first[1]; j <= range->last[1]; ++j) {
        for (int i = range->first[0]; i <= range->last[0]; ++i) {
          if (moved_[static_cast<size_t>(lattice_.structure.Index(i, j, k))]) return true;
        }
      }
    }
    return false;
  }

 private:
  void Extend(int index) {
    const LatticeStructure& s = lattice_.structure;
    const std::array<int, 3> at{index % s.size[0], index / s.size[0] % s.size[1],
                                index / s.size[0] / s.size[1]};
    Vec3d first, last;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<size_t>(axis);
      first[axis] = s.knots[a][static_cast<size_t>(at[a])];
      last[axis] = s.knots[a][static_cast<size_t>(at[a] + s.degree[a] + 1)];
    }
    reach_.Extend(first);
    reach_.Extend(last);
  }

  const TurnedLattice& lattice_;
  std::vector<bool> moved_;
  Bounds reach_;  // of all supports, in parameters
};

// By patch: whether a control point of a turned lattice makes it dirty. Empty if none is of a turned lattice.
std::vector<bool> ReachedByTurned(const DeformPlan& plan, std::span<const uint32_t> indices) {
  const auto own = static_cast<uint32_t>(plan.structure.control_point_count());
  std::vector<bool> reached;
  if (std::ranges::none_of(indices, [own](uint32_t i) { return i >= own; })) return reached;
  std::vector<bool> vertices(plan.vertices.size());
  for (const TurnedLattice& lattice : plan.turned) {
    const MovedPoints moved(lattice, indices);
    for (size_t v = 0; v < vertices.size(); ++v) {
      if (moved.Reach(v)) vertices[v] = true;
    }
  }
  reached.resize(plan.patches.size());
  for (size_t p = 0; p < reached.size(); ++p) {
    reached[p] =
        std::ranges::any_of(plan.patches[p].vertex, [&](uint32_t v) { return vertices[v]; });
  }
  return reached;
}

// Those of the plan's own lattice.
std::vector<uint32_t> OwnOf(const DeformPlan& plan, std::span<const uint32_t> indices) {
  const auto own = static_cast<uint32_t>(plan.structure.control_point_count());
  std::vector<uint32_t> result;
  std::ranges::copy_if(indices, std::back_inserter(result), [own](uint32_t i) { return i < own; });
  return result;
}

std::vector<bool> BoxesOfOwn(const DeformPlan& plan, std::span<const uint32_t> indices) {
  const LatticeStructure& s = plan.structure;
  const std::array below{BoxesBelow(s, 0), BoxesBelow(s, 1), BoxesBelow(s, 2)};
  // By control points with this index along the axis.
  const auto boxes_of = [&](size_t axis, int index) {
    const int last = std::min(index + s.degree[axis], s.size[axis] - 1);
    return Range{below[axis][static_cast<size_t>(index)],
                 below[axis][static_cast<size_t>(last) + 1]};
  };
  std::vector<bool> boxes(plan.boxes.size());
  const uint32_t row = below[0].back(), layer = row * below[1].back();
  for (size_t begin = 0, end = 0; begin < indices.size(); begin = end) {
    const int first = static_cast<int>(indices[begin]), line = first / s.size[0];
    // Takes points of a row together whose boxes lie side by side; an edit of all points, or of every second one, then takes
    // one step per row.
    int last = first;
    for (end = begin + 1; end < indices.size(); ++end) {
      const int next = static_cast<int>(indices[end]);
      if (next < last || next > last + s.degree[0] + 1 || next / s.size[0] != line) break;
      last = next;
    }
    const Range u{boxes_of(0, first % s.size[0]).first, boxes_of(0, last % s.size[0]).last},
        v = boxes_of(1, line % s.size[1]), w = boxes_of(2, line / s.size[1]);
    for (uint32_t k = w.first; k < w.last; ++k) {
      for (uint32_t j = v.first; j < v.last; ++j) {
        const auto at = boxes.begin() + (layer * k + row * j);
        std::fill(at + u.first, at + u.last, true);
      }
    }
  }
  return boxes;
}

DirtySet DirtyByOwn(const DeformPlan& plan, std::span<const uint32_t> indices) {
  const std::vector<bool> boxes = BoxesOfOwn(plan, indices);
  const std::vector<Range> ranges = PatchesOf(plan, boxes);
  const std::vector<uint32_t> borrowers = BorrowersBeside(plan, boxes, ranges);
  DirtySet dirty{.chunks = ChunksOf(ranges, borrowers),
                 .boxes = static_cast<uint64_t>(std::ranges::count(boxes, true)),
                 .patches = borrowers.size()};
  for (const Range& range : ranges) dirty.patches += range.last - range.first;
  return dirty;
}

// The same with turned lattices, patch by patch.
DirtySet DirtyWithTurned(const DeformPlan& plan, std::span<const uint32_t> indices) {
  std::vector<bool> patches = ReachedByTurned(plan, indices);
  if (patches.empty()) return DirtyByOwn(plan, OwnOf(plan, indices));
  std::vector<bool> boxes = BoxesOfOwn(plan, OwnOf(plan, indices));
  for (uint32_t box = 0; box < boxes.size(); ++box) {
    if (!boxes[box]) continue;
    for (uint32_t p = plan.box_patches[box]; p < plan.box_patches[box + 1]; ++p) patches[p] = true;
    for (const uint32_t p : plan.box_borrowers[box]) patches[p] = true;
  }
  DirtySet dirty;
  for (uint32_t p = 0; p < patches.size(); ++p) {
    if (!patches[p]) continue;
    AddChunk(p / kPatchesPerChunk, dirty.chunks);
    boxes[plan.patches[p].box] = true;
    ++dirty.patches;
  }
  dirty.boxes = static_cast<uint64_t>(std::ranges::count(boxes, true));
  return dirty;
}

}  // namespace

std::vector<bool> InfluencedBoxes(const DeformPlan& plan, std::span<const uint32_t> indices) {
  if (plan.turned.empty()) return BoxesOfOwn(plan, indices);
  std::vector<bool> boxes = BoxesOfOwn(plan, OwnOf(plan, indices));
  const std::vector<bool> reached = ReachedByTurned(plan, indices);
  for (size_t p = 0; p < reached.size(); ++p) {
    if (reached[p]) boxes[plan.patches[p].box] = true;
  }
  return boxes;
}

DirtySet DirtyByControlPoints(const DeformPlan& plan, std::span<const uint32_t> indices) {
  if (!plan.turned.empty()) return DirtyWithTurned(plan, indices);
  return DirtyByOwn(plan, indices);
}

DirtySet AllDirty(const DeformPlan& plan) {
  DirtySet dirty{.chunks = std::vector<uint32_t>(plan.chunk_count()),
                 .boxes = plan.boxes.size(),
                 .patches = plan.patches.size()};
  std::iota(dirty.chunks.begin(), dirty.chunks.end(), 0u);
  return dirty;
}

}  // namespace latticed
