// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/points/points_at_head.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/rpc/server_env.h"
#include "server/rpc/watch_request.h"
#include "server/wire/time_converters.h"

namespace latticed {

absl::StatusOr<PointsAtHead> FindPoints(ServerEnv& env, const CallInfo& call,
                                        const std::string& scene, const std::string& point_set,
                                        uint64_t revision, bool with_normals,
                                        std::optional<uint32_t> lattice, std::string_view prefix) {
  PointsAtHead found;
  LATTICED_ASSIGN_OR_RETURN(found.scene, FindScene(env, call, scene));
  if (point_set.empty())
    return error::InvalidField(fmt::format("{}point_set", prefix), "is required");
  LATTICED_ASSIGN_OR_RETURN(const auto set, found.scene->point_sets().Find(point_set));
  found.scene->NoteUse();
  found.state = found.scene->State();
  if (revision != 0 && revision != found.state->revision) {
    return error::WithDetails(
        absl::AbortedError(fmt::format("{}revision: got {}, the scene is at {}", prefix, revision,
                                       found.state->revision)),
        {.reason = "REVISION_CHANGED",
         .metadata = {{"revision", fmt::to_string(found.state->revision)}}});
  }
  if (lattice.has_value()) {
    LATTICED_RETURN_IF_ERROR(
        CheckLattice(found.state->lattices, *lattice, fmt::format("{}lattice", prefix)));
    found.lattice_place = PlaceOf(found.state->lattices, *lattice);
  }
  LATTICED_ASSIGN_OR_RETURN(found.resident,
                            set->At(*found.state, found.scene->backend(), *env.point_arena));
  if (with_normals && !found.points().has_normals()) {
    return error::InvalidField(fmt::format("{}with_normals", prefix),
                               "the point set has no normals");
  }
  if (with_normals) found.normals = PointNormals::kWanted;
  return found;
}

v1::PointSet ToProto(const Scene& scene, const PointSet& set) {
  const auto resident = set.Newest();
  v1::PointSet out;
  out.set_id(set.id());
  out.set_scene(std::string(IdOf(scene.id())));
  out.set_points(resident->points().size());
  out.set_points_outside(resident->evaluator->points_outside());
  out.set_has_normals(resident->points().has_normals());
  out.set_bytes(resident->memory.bytes());
  SetTime(set.create_time(), *out.mutable_create_time());
  return out;
}

}  // namespace latticed
