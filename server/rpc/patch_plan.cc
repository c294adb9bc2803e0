// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/patch_plan.h"

#include <memory>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/patches/patch_plan_writer.h"
#include "server/base/auth/tenant.h"
#include "server/engine/scene/topology_id.h"
#include "server/rpc/call.h"
#include "server/rpc/server_env.h"
#include "server/rpc/watch_request.h"
#include "server/stores/callers.h"
#include "server/stores/scene_registry.h"
#include "server/wire/converters.h"
#include "server/wire/view_converters.h"

namespace latticed {
namespace {

// In the topology_id of views whose patches have no common segments.
constexpr int kNoSegments = 0;

RestNormals RestNormalsOf(NormalMode mode) {
  switch (mode) {
    case NormalMode::kNone:
      return RestNormals::kNone;
    case NormalMode::kFacet:
      return RestNormals::kFacet;
    case NormalMode::kSmooth:
      return RestNormals::kSmooth;
  }
  return RestNormals::kNone;
}

v1::PatchPlanPart HeaderPart(const PatchPlanHeader& header, const std::string& topology_id,
                             NormalMode normals) {
  v1::PatchPlanPart part;
  v1::PatchPlanHeader& out = *part.mutable_header();
  out.set_topology_id(topology_id);
  out.set_normals(ToProto(normals));
  out.set_patch_count(header.patch_count);
  out.set_patches_outside(header.patches_outside);
  out.set_vertex_count(header.vertex_count);
  out.set_edge_count(header.edge_count);
  out.set_normal_count(header.normal_count);
  *out.mutable_origin() = ToProto(header.origin);
  if (header.patches_outside > 0) {
    *out.mutable_outside_lower() = ToProto(header.outside_lower);
    *out.mutable_outside_upper() = ToProto(header.outside_upper);
  }
  out.set_curvature_unit(header.curvature_unit);
  out.set_weighted(header.weighted);
  return part;
}

v1::PatchPlanPart RunPart(PatchRun run) {
  v1::PatchPlanPart part;
  v1::PatchRun& out = *part.mutable_run();
  out.set_first_patch(run.first_patch);
  out.set_patches(run.patches);
  out.set_new_vertices(run.new_vertices);
  out.set_new_normals(run.new_normals);
  out.set_data(std::move(run.data));
  return part;
}

v1::PatchPlanPart SeamsPart(const PatchSeams& seams) {
  v1::PatchPlanPart part;
  v1::PatchSeams& out = *part.mutable_seams();
  const auto add = [](const auto& from, auto* to) { to->Add(from.begin(), from.end()); };
  add(seams.ranges, out.mutable_ranges());
  add(seams.vertices, out.mutable_vertices());
  add(seams.vertex_seams, out.mutable_vertex_seams());
  add(seams.outside_places, out.mutable_outside_places());
  add(seams.edges, out.mutable_edges());
  add(seams.edge_seams, out.mutable_edge_seams());
  add(seams.identity_points, out.mutable_identity_points());
  return part;
}

struct OpenPlan {
  MemoryReservation room;
  PatchPlanWriter writer;
  std::string topology_id;
  NormalMode normals;
  bool has_begun = false;

  absl::StatusOr<std::optional<v1::PatchPlanPart>> Next() {
    if (!std::exchange(has_begun, true)) {
      return HeaderPart(writer.header(), topology_id, normals);
    }
    LATTICED_ASSIGN_OR_RETURN(auto run, writer.NextRun());
    if (run.has_value()) return RunPart(*std::move(run));
    const auto seams = writer.NextSeams();
    if (seams.has_value()) return SeamsPart(*seams);
    return std::nullopt;
  }
};

}  // namespace

absl::StatusOr<NextPart<v1::PatchPlanPart>> OpenPatchPlan(const CallContext& context,
                                                          const v1::GetPatchPlanRequest& request) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene,
                            FindScene(context.env, context.call, request.scene()));
  const SceneConfig& config = scene->config();
  const auto plan = scene->State()->plan;
  const std::string mesh = WeightedMeshId(IdOf(config.mesh_id), plan->mesh_weights);
  if (request.topology_id() != TopologyId(mesh, *plan, kNoSegments)) {
    return error::NotFound("topology", request.topology_id());
  }
  if (!plan->turned.empty()) return error::NotWithTurned("a plan of patches");
  LATTICED_ASSIGN_OR_RETURN(
      const NormalMode normals,
      NormalModeFromProto(request.normals(), config.default_view.key.spec.normals, "normals"));
  const RestNormals rest = RestNormalsOf(normals);
  LATTICED_ASSIGN_OR_RETURN(
      auto room,
      context.env.memory->Reserve("the patch plan", PatchPlanWriter::MostBytes(*plan, rest),
                                  context.call.account->memory));
  LATTICED_ASSIGN_OR_RETURN(auto writer, PatchPlanWriter::Create(plan, rest, [&] {
                              return CheckCancelled(context.call);
                            }));
  LATTICED_RETURN_IF_ERROR(room.Resize("the patch plan", writer.MemoryBytes()));
  const auto open = std::make_shared<OpenPlan>(
      OpenPlan{std::move(room), std::move(writer), request.topology_id(), normals});
  return [open] { return open->Next(); };
}

}  // namespace latticed
