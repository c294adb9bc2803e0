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
      box_dirty_(plan_->boxes.size()),
      chunk_dirty_(plan_->chunk_count()),
      patch_dirty_(plan_->patches.size()) {}

void DirtySet::MarkControlPoints(std::span<const uint32_t> indices) {
  const LatticeStructure& s = plan_->structure;
  std::vector<bool> moved(static_cast<size_t>(s.control_point_count()));
  for (const uint32_t index : indices) moved[index] = true;
  for (uint32_t b = 0; b < plan_->outside_box(); ++b) {
    if (box_dirty_[b]) continue;
    const std::array<int, 3>& span = plan_->boxes[b].span;
    bool touched = false;
    for (int k = span[2] - s.degree[2]; k <= span[2] && !touched; ++k) {
      for (int j = span[1] - s.degree[1]; j <= span[1] && !touched; ++j) {
        for (int i = span[0] - s.degree[0]; i <= span[0] && !touched; ++i) {
          touched = moved[static_cast<size_t>(s.Index(i, j, k))];
        }
      }
    }
    if (touched) MarkBox(b);
  }
}

void DirtySet::MarkBox(uint32_t box) {
  box_dirty_[box] = true;
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
    if (!box_dirty_[b]) MarkBox(b);
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
