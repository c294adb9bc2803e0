// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads the parts of a patch plan. Parts come from a network: nothing in them is believed before it is checked. Memory
// grows with the runs that have come, by at most some MB each, and not with the numbers of a header.
//
//   PatchPlanReader reader(header);
//   reader.Add(run); …  reader.Add(seams); …
//   auto plan = reader.Finish();
//
// Errors   kInvalidArgument naming the field, e.g. "run.data"
// Threads  one thread at a time
#ifndef LATTICED_CORE_PATCHES_PATCH_PLAN_READER_H_
#define LATTICED_CORE_PATCHES_PATCH_PLAN_READER_H_

#include <cstdint>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/ffd/plan/adjacency_index.h"
#include "core/patches/patch_plan.h"

namespace latticed {

class PatchPlanReader {
 public:
  explicit PatchPlanReader(const PatchPlanHeader& header);

  [[nodiscard]] absl::Status Add(const PatchRun& run);
  [[nodiscard]] absl::Status Add(const PatchSeams& seams);
  // Leaves the reader empty.
  [[nodiscard]] absl::StatusOr<PatchPlan> Finish();

 private:
  absl::Status CheckHeader() const;
  absl::Status CheckRun(const PatchRun& run) const;
  void ReadPlaces(std::string_view bytes, uint32_t count);
  void ReadRestNormals(std::string_view bytes, uint32_t count);
  // Of the new vertices, and of the patches.
  absl::Status ReadWeights(std::string_view bytes, uint32_t vertices, uint32_t patches);
  absl::Status ReadCorners(std::string_view bytes, uint32_t patches, uint32_t new_vertices);
  absl::Status ReadNormals(std::string_view bytes, uint32_t patches, uint32_t new_normals);
  void NumberEdges(size_t first_patch);
  absl::Status CheckSeams() const;
  void MoveSeams();
  absl::Status CheckOutside() const;

  PatchPlan plan_;
  AdjacencyIndex edge_numbers_;
  uint32_t edges_ = 0;
  PatchSeams seams_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_PATCHES_PATCH_PLAN_READER_H_
