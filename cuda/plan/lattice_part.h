// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The part of a large lattice that some chunks need: their knot boxes, the pages of control points of these
// boxes, and the seams that the chunks are on. An evaluation of few chunks copies this part to the device
// and computes the polynomials of these boxes. It relies on nothing that earlier evaluations copied: those
// may have failed, been left out or named other chunks.
//
//   control points   | 0 … 31 | 32 … 63 | …      page by page
//
// A lattice of 32 x 32 x 32 control points takes the host 37 us to stage and an H200 35 us to copy. The part
// for the median control point takes 3 us, with the search, and 6 us. For lattices of up to 4,096 control
// points it would save nothing: they are copied in 2 us, all multiprocessors together compute their boxes
// in one round, and reading a list of boxes takes a microsecond.
//
// Threads  one at a time
#ifndef LATTICED_CUDA_PLAN_LATTICE_PART_H_
#define LATTICED_CUDA_PLAN_LATTICE_PART_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/ffd/plan/deform_plan.h"
#include "cuda/plan/chunk_needs.h"

namespace latticed {

class LatticePart {
 public:
  static constexpr size_t kPagePoints = 32;
  // With more there is little to gain.
  static constexpr size_t kMostPages = 256;
  static constexpr int kLargeLattice = 4'096;  // control points
  static bool IsWorthwhile(const LatticeStructure& structure) {
    return structure.control_point_count() > kLargeLattice;
  }

  // `chunk_needs` are those of the plan.
  LatticePart(std::shared_ptr<const DeformPlan> plan,
              std::shared_ptr<const ChunkNeeds> chunk_needs);

  // Selects the part of these chunks. Returns false, and selects nothing, where it has too many
  // pages.
  [[nodiscard]] bool Select(std::span<const uint32_t> chunks);

  // Each once, with the outside box.
  std::span<const uint32_t> boxes() const { return boxes_; }
  std::span<const uint16_t> pages() const { return pages_; }
  std::span<const uint32_t> seams() const { return seams_; }
  // The most boxes of any selection: a page holds the first control points of at most kPagePoints
  // boxes.
  static size_t MostBoxes(const DeformPlan& plan);

 private:
  void Clear();
  void AddBox(uint32_t box);
  void AddPagesOf(const KnotBox& box);
  void AddSeam(uint32_t seam);

  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<const ChunkNeeds> chunk_needs_;
  std::vector<uint8_t> has_box_, has_page_, has_seam_;
  std::vector<uint32_t> boxes_, seams_;
  std::vector<uint16_t> pages_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_LATTICE_PART_H_
