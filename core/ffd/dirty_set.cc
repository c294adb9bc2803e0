// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/dirty_set.h"

#include <algorithm>
#include <utility>

#include "core/base/limits.h"

namespace latticed {
namespace {

constexpr auto kPatchesPerChunk = static_cast<uint32_t>(limits::kPatchesPerChunk);

}  // namespace

DirtySet::DirtySet(std::shared_ptr<const DeformPlan> plan)
    : plan_(std::move(plan)),
      chunk_dirty_(plan_->chunk_count()),
      box_dirty_(plan_->boxes.size()),
      patch_dirty_(plan_->patches.size()) {
  const LatticeStructure& s = plan_->structure;
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::vector<double>& knots = s.knots[axis];
    std::vector<uint32_t>& below = boxes_below_[axis];
    below.assign(static_cast<size_t>(s.size[axis]) + 1, 0);
    for (auto span = static_cast<size_t>(s.degree[axis]); span + 1 < below.size(); ++span) {
      below[span + 1] = below[span] + (knots[span + 1] > knots[span] ? 1 : 0);
    }
  }
}

void DirtySet::MarkControlPoints(std::span<const uint32_t> indices) {
  const std::array<int, 3>& size = plan_->structure.size;
  const uint32_t row = boxes_below_[0].back(), layer = row * boxes_below_[1].back();
  for (size_t begin = 0, end = 0; begin < indices.size(); begin = end) {
    const int first = static_cast<int>(indices[begin]), line = first / size[0];
    // Takes neighbours along u together; an edit of all points then takes one step per row.
    int last = first;
    for (end = begin + 1; end < indices.size(); ++end, ++last) {
      if (static_cast<int>(indices[end]) != last + 1 || (last + 1) / size[0] != line) break;
    }
    const Range u{BoxesOf(0, first % size[0]).first, BoxesOf(0, last % size[0]).last},
        v = BoxesOf(1, line % size[1]), w = BoxesOf(2, line / size[1]);
    for (uint32_t k = w.first; k < w.last; ++k) {
      for (uint32_t j = v.first; j < v.last; ++j) {
        for (uint32_t i = u.first; i < u.last; ++i) {
          const uint32_t box = i + row * j + layer * k;
          if (box_dirty_[box] == 0) MarkBox(box);
        }
      }
    }
  }
}

DirtySet::Range DirtySet::BoxesOf(size_t axis, int index) const {
  const int degree = plan_->structure.degree[axis], last = plan_->structure.size[axis] - 1;
  const auto below = [&](int span) { return boxes_below_[axis][static_cast<size_t>(span)]; };
  return {below(index), below(std::min(index + degree, last) + 1)};
}

void DirtySet::MarkBox(uint32_t box) {
  box_dirty_[box] = 1;
  ++box_count_;
  MarkOwnPatches(plan_->box_patches[box], plan_->box_patches[box + 1]);
  for (const uint32_t patch : plan_->box_borrowers[box]) {
    if (patch_dirty_[patch] != 0) continue;
    patch_dirty_[patch] = 1;
    ++patch_count_;
    MarkChunk(patch / kPatchesPerChunk);
  }
}

void DirtySet::MarkOwnPatches(uint32_t first, uint32_t last) {
  if (first == last) return;
  const std::span patches = std::span(patch_dirty_).subspan(first, last - first);
  patch_count_ += static_cast<uint64_t>(std::ranges::count(patches, 0));
  std::ranges::fill(patches, uint8_t{1});
  for (uint32_t chunk = first / kPatchesPerChunk; chunk * kPatchesPerChunk < last; ++chunk) {
    MarkChunk(chunk);
  }
}

void DirtySet::MarkChunk(uint32_t chunk) {
  if (chunk_dirty_[chunk]) return;
  chunk_dirty_[chunk] = true;
  ++chunk_count_;
}

void DirtySet::MarkAll() {
  for (uint32_t b = 0; b < plan_->boxes.size(); ++b) {
    if (box_dirty_[b] == 0) MarkBox(b);
  }
}

void DirtySet::Clear() { *this = DirtySet(plan_); }

std::vector<uint32_t> DirtySet::Chunks() const {
  std::vector<uint32_t> chunks;
  chunks.reserve(chunk_count_);
  for (size_t c = 0; c < chunk_dirty_.size(); ++c) {
    if (chunk_dirty_[c]) chunks.push_back(static_cast<uint32_t>(c));
  }
  return chunks;
}

}  // namespace latticed
