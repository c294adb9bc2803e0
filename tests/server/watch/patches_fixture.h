// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views of patches and their plans, as a client of the stub reads them.
#ifndef LATTICED_TESTS_SERVER_WATCH_PATCHES_FIXTURE_H_
#define LATTICED_TESTS_SERVER_WATCH_PATCHES_FIXTURE_H_

#include <set>
#include <string>
#include <vector>

#include "core/base/limits.h"
#include "core/patches/patch_plan_reader.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {

class PatchesTest : public SceneStreamTest {
 protected:
  static constexpr uint32_t kControlPoints = 125;

  v1::WatchRequest WatchPatches() const {
    v1::WatchRequest watch = Watch();
    watch.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
    return watch;
  }
  static v1::GetUpdateRequest PatchesUpdate() {
    auto request = For<v1::GetUpdateRequest>();
    request.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
    return request;
  }
  absl::Status GetPlanParts(const std::string& topology_id, v1::NormalMode normals,
                            std::vector<v1::PatchPlanPart>* parts) {
    auto request = For<v1::GetPatchPlanRequest>();
    request.set_topology_id(topology_id);
    request.set_normals(normals);
    return ReadAll(&Scenes::GetPatchPlan, request, parts);
  }
  // Decoded by core/patches/patch_plan_reader.h, which checks it.
  static absl::StatusOr<PatchPlan> Decode(const std::vector<v1::PatchPlanPart>& parts) {
    const v1::PatchPlanHeader& from = parts.at(0).header();
    PatchPlanHeader header{.patch_count = from.patch_count(),
                           .patches_outside = from.patches_outside(),
                           .vertex_count = from.vertex_count(),
                           .edge_count = from.edge_count(),
                           .normal_count = from.normal_count(),
                           .curvature_unit = from.curvature_unit()};
    header.normals = from.normals() == v1::NORMAL_MODE_NONE    ? RestNormals::kNone
                     : from.normals() == v1::NORMAL_MODE_FACET ? RestNormals::kFacet
                                                               : RestNormals::kSmooth;
    PatchPlanReader reader(header);
    for (size_t i = 1; i < parts.size(); ++i) {
      LATTICED_RETURN_IF_ERROR(parts[i].has_run() ? Add(parts[i].run(), reader)
                                                  : Add(parts[i].seams(), reader));
    }
    return reader.Finish();
  }
  PatchPlan Plan(const EventLog& log) {
    std::vector<v1::PatchPlanPart> parts;
    EXPECT_OK(GetPlanParts(log.topologies.back().topology_id(), v1::NORMAL_MODE_NONE, &parts));
    auto plan = Decode(parts);
    EXPECT_OK(plan.status());
    return *std::move(plan);
  }
  // The chunks that use an edge first whose bounds differ.
  static std::set<size_t> ChunksThatDiffer(const std::vector<uint8_t>& a,
                                           const std::vector<uint8_t>& b, const PatchPlan& plan) {
    std::set<size_t> chunks;
    uint32_t used = 0;
    for (size_t p = 0; p < plan.patches.size(); ++p) {
      for (const uint32_t edge : plan.patches[p].edge) {
        if (edge < used) continue;
        used = edge + 1;
        if (a.at(edge) != b.at(edge)) chunks.insert(p / limits::kPatchesPerChunk);
      }
    }
    EXPECT_EQ(a.size(), used);
    return chunks;
  }
  // The watcher has what a new one gets.
  void ExpectSameAsNew(const EventLog& log) {
    EventLog now;
    ASSERT_OK(Update(PatchesUpdate(), now));
    EXPECT_TRUE(log.bounds == now.bounds);
  }

 private:
  static absl::Status Add(const v1::PatchRun& run, PatchPlanReader& reader) {
    return reader.Add(PatchRun{.first_patch = run.first_patch(),
                               .patches = run.patches(),
                               .new_vertices = run.new_vertices(),
                               .new_normals = run.new_normals(),
                               .data = run.data()});
  }
  static absl::Status Add(const v1::PatchSeams& seams, PatchPlanReader& reader) {
    PatchSeams part;
    part.ranges.assign(seams.ranges().begin(), seams.ranges().end());
    part.vertices.assign(seams.vertices().begin(), seams.vertices().end());
    part.vertex_seams.assign(seams.vertex_seams().begin(), seams.vertex_seams().end());
    part.outside_places.assign(seams.outside_places().begin(), seams.outside_places().end());
    part.edges.assign(seams.edges().begin(), seams.edges().end());
    part.edge_seams.assign(seams.edge_seams().begin(), seams.edge_seams().end());
    part.identity_points.assign(seams.identity_points().begin(), seams.identity_points().end());
    return reader.Add(part);
  }
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_WATCH_PATCHES_FIXTURE_H_
