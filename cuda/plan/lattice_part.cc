// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/plan/lattice_part.h"

#include <algorithm>
#include <utility>

#include "core/base/limits.h"

namespace latticed {
namespace {

static_assert(limits::kMaxControlPoints / LatticePart::kPagePoints <= 1 << 16,
              "pages have 16 bits");

size_t PageCount(const LatticeStructure& structure) {
  const auto points = static_cast<size_t>(structure.control_point_count());
  return (points + LatticePart::kPagePoints - 1) / LatticePart::kPagePoints;
}

}  // namespace

LatticePart::LatticePart(std::shared_ptr<const DeformPlan> plan,
                         std::shared_ptr<const ChunkNeeds> chunk_needs)
    : plan_(std::move(plan)),
      chunk_needs_(std::move(chunk_needs)),
      has_box_(plan_->boxes.size()),
      has_page_(PageCount(plan_->structure)),
      has_seam_(plan_->seams.size()) {
  // Room for the largest selection, so that making a list allocates nothing.
  boxes_.reserve(MostBoxes(*plan_));
  pages_.reserve(has_page_.size());
  seams_.reserve(has_seam_.size());
}

size_t LatticePart::MostBoxes(const DeformPlan& plan) {
  return std::min(plan.boxes.size(), kMostPages * kPagePoints + 1);
}

bool LatticePart::Select(std::span<const uint32_t> chunks) {
  Clear();
  AddBox(plan_->outside_box());  // it has no control points
  for (const uint32_t chunk : chunks) {
    for (const uint32_t box : chunk_needs_->Boxes(chunk)) {
      if (has_box_[box] != 0) continue;
      AddPagesOf(plan_->boxes[box]);
      if (pages_.size() > kMostPages) {
        Clear();
        return false;
      }
      AddBox(box);
    }
    for (const uint32_t seam : chunk_needs_->Seams(chunk)) AddSeam(seam);
  }
  return true;
}

void LatticePart::Clear() {
  for (const uint32_t box : boxes_) has_box_[box] = 0;
  for (const uint16_t page : pages_) has_page_[page] = 0;
  for (const uint32_t seam : seams_) has_seam_[seam] = 0;
  boxes_.clear();
  pages_.clear();
  seams_.clear();
}

void LatticePart::AddBox(uint32_t box) {
  has_box_[box] = 1;
  boxes_.push_back(box);
}

void LatticePart::AddSeam(uint32_t seam) {
  if (has_seam_[seam] != 0) return;
  has_seam_[seam] = 1;
  seams_.push_back(seam);
}

void LatticePart::AddPagesOf(const KnotBox& box) {
  const LatticeStructure& s = plan_->structure;
  const std::array<int, 3>& last = box.span;
  for (int k = last[2] - s.degree[2]; k <= last[2]; ++k) {
    for (int j = last[1] - s.degree[1]; j <= last[1]; ++j) {
      const auto end = static_cast<size_t>(s.Index(last[0], j, k));
      const size_t begin = end - static_cast<size_t>(s.degree[0]);
      for (size_t page = begin / kPagePoints; page <= end / kPagePoints; ++page) {
        if (has_page_[page] != 0) continue;
        has_page_[page] = 1;
        pages_.push_back(static_cast<uint16_t>(page));
      }
    }
  }
}

}  // namespace latticed
