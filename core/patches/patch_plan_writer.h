// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes a plan as the parts of patches.proto, one at a time: the memory of a whole patch plan is never needed.
//
//   LATTICED_ASSIGN_OR_RETURN(auto writer, PatchPlanWriter::Create(plan, normals, stop));
//   Send(writer.header());
//   while (…) writer.NextRun() … writer.NextSeams() …
//
// Patches and edges keep the plan's numbers: the plan numbers its edges in the order of first use. Vertices and rest
// normals get theirs as runs are written.
//
// Memory   MostBytes until Create returns, then MemoryBytes, besides what is returned and the plan
// Errors   what `stop` returns; kResourceExhausted without memory for zlib
// Threads  one thread at a time
#ifndef LATTICED_CORE_PATCHES_PATCH_PLAN_WRITER_H_
#define LATTICED_CORE_PATCHES_PATCH_PLAN_WRITER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/bounds.h"
#include "core/base/stop_check.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/plan/adjacency_index.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/patches/patch_places.h"
#include "core/patches/patch_plan_parts.h"

namespace latticed {

class PatchPlanWriter {
 public:
  [[nodiscard]] static absl::StatusOr<PatchPlanWriter> Create(
      std::shared_ptr<const DeformPlan> plan, RestNormals normals, StopCheck stop = NeverStop);

  // The bytes that Create takes, and a writer afterwards: no more than these.
  [[nodiscard]] static uint64_t MostBytes(const DeformPlan& plan, RestNormals normals);
  [[nodiscard]] uint64_t MemoryBytes() const;

  const PatchPlanHeader& header() const { return header_; }
  // nullopt after the last patch.
  [[nodiscard]] absl::StatusOr<std::optional<PatchRun>> NextRun();
  // Call this after the last run. nullopt after the last seams; at once if there are none.
  [[nodiscard]] std::optional<PatchSeams> NextSeams();

 private:
  struct RestNormal {
    uint16_t number[3];  // NumbersPerRestNormal of them
    uint64_t Key() const {
      return number[0] | uint64_t{number[1]} << 16 | uint64_t{number[2]} << 32;
    }
  };
  struct RunArrays;

  PatchPlanWriter(std::shared_ptr<const DeformPlan> plan, RestNormals normals);
  absl::Status Count(StopCheck stop);
  // Forgets all rest normals, and makes room for this many.
  void ResetNormals(size_t count);
  // The number of a patch's rest normal at `corner`, and whether it is new.
  std::pair<uint32_t, bool> NumberNormal(size_t patch, size_t corner, RestNormal normal);
  RestNormal NormalAt(size_t patch, size_t corner) const;
  void AppendPatch(size_t patch, RunArrays* arrays);
  Places PlacesOfVertex(const PlanVertex& vertex) const;
  void FindSeamVertices();
  void AppendSeamRanges(PatchSeams* part);
  void AppendSeamVertices(PatchSeams* part);
  void AppendSeamEdges(PatchSeams* part);

  std::shared_ptr<const DeformPlan> plan_;
  RestNormals normals_;
  KnotPlanes planes_;
  Bounds outside_box_;
  DirectFfd at_rest_;
  PatchPlanHeader header_;

  size_t next_patch_ = 0;
  std::vector<uint32_t> vertex_numbers_;  // by vertex of the plan; kNoIndex before its first use
  uint32_t vertices_ = 0;
  AdjacencyIndex normal_numbers_;  // by vertex of the mesh or of the plan, and value
  uint32_t normals_so_far_ = 0;

  std::vector<std::pair<uint32_t, uint32_t>>
      seam_vertices_;  // number, vertex of the plan; ascending
  size_t next_seam_ = 0, next_seam_vertex_ = 0, next_seam_edge_ = 0;
  bool seams_done_ = false;
};

}  // namespace latticed

#endif  // LATTICED_CORE_PATCHES_PATCH_PLAN_WRITER_H_
