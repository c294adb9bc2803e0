// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes, requests for them, and points of their surface <-> engine types.
//
// Errors   kInvalidArgument with the path of the field
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_SCENE_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_SCENE_CONVERTERS_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/stop_check.h"
#include "latticed/v1/scene.pb.h"
#include "server/engine/exports/surface_export.h"
#include "server/engine/scene.h"
#include "server/stores/mesh_store.h"

namespace latticed {

// Converts what follows from the message alone: the id, labels, idle_ttl, count of lattices.
[[nodiscard]] absl::Status CheckCreateScene(const v1::CreateSceneRequest& request);
// Converts the rest: lattice, view and pipeline for this mesh. The fingerprint contains `owner`, so that
// nobody gets the scene of somebody else.
[[nodiscard]] absl::StatusOr<SceneConfig> SceneConfigFromProto(
    const v1::CreateSceneRequest& request, const StoredMesh& mesh, const std::string& owner,
    absl::Duration default_idle_ttl);

[[nodiscard]] v1::Scene ToProto(const Scene& scene);
// Without what changes with edits.
[[nodiscard]] v1::Scene ToProto(const SceneConfig& config);
[[nodiscard]] v1::LatticeState LatticeStateToProto(const SceneState& state, size_t place);

[[nodiscard]] absl::StatusOr<ExportSpec> ExportSpecFromProto(const v1::ExportRequest& request,
                                                             const WatchView& defaults);

// Evaluates the points of the request at the state, in double.
[[nodiscard]] absl::Status EvaluatePoints(const SceneState& state,
                                          const v1::EvaluatePointsRequest& request,
                                          v1::EvaluatePointsResponse* response);

// The first point of the surface at the state on the request's ray; its normal is unset where it is
// ill-conditioned. kNotFound NOTHING_HIT, and what `stop` says.
[[nodiscard]] absl::Status Pick(const SceneState& state, const v1::PickRequest& request,
                                StopCheck stop, v1::SurfacePoint* response);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_SCENE_CONVERTERS_H_
