// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A point set at its scene's newest revision, as requests name it.
//
// Errors   those of FindScene; kNotFound for the set; kAborted, reason REVISION_CHANGED; kInvalidArgument for normals
//          of a set that has none; kResourceExhausted where there is no memory to sort it again
// Threads  safe
#ifndef LATTICED_SERVER_RPC_POINTS_POINTS_AT_HEAD_H_
#define LATTICED_SERVER_RPC_POINTS_POINTS_AT_HEAD_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/points/point_derivatives.h"
#include "latticed/v1/points.pb.h"
#include "server/engine/scene.h"

namespace latticed {

struct CallInfo;
struct ServerEnv;

struct PointsAtHead {
  std::shared_ptr<Scene> scene;
  std::shared_ptr<const SceneState> state;
  std::shared_ptr<const PointSet::Resident> resident;
  PointNormals normals = PointNormals::kNone;
  // By whose control points clients give tangents and get derivatives.
  size_t lattice_place = 0;

  const SortedPoints& points() const { return resident->points(); }
  // Runs `call`, which returns the status of a call of the evaluator.
  template <class Call>
  [[nodiscard]] absl::Status Evaluate(const Call& call) const {
    return scene->backend().Run([&]() -> absl::Status { return call(*resident->evaluator); });
  }
  // Of the plan.
  const std::vector<Vec3d>& control_points() const { return *state->control_points; }
  const SceneLattice& lattice() const { return state->lattices[lattice_place]; }
  size_t lattice_points() const { return lattice().points->size(); }
  // Bytes of an answer, or of cotangents, for one direction.
  uint64_t BytesPerDirection() const {
    return VectorsPerDirection(points(), normals) * sizeof(Vec3d);
  }
};

// `lattice`: the number that the request names; unset for one that names none. `prefix` is what comes before the names of
// fields: "" or "header.".
[[nodiscard]] absl::StatusOr<PointsAtHead> FindPoints(
    ServerEnv& env, const CallInfo& call, const std::string& scene, const std::string& point_set,
    uint64_t revision, bool with_normals, std::optional<uint32_t> lattice, std::string_view prefix);
// Of a request, or of the header of one.
template <class Request>
[[nodiscard]] absl::StatusOr<PointsAtHead> FindPoints(ServerEnv& env, const CallInfo& call,
                                                      const Request& request,
                                                      std::string_view prefix = "") {
  std::optional<uint32_t> lattice;
  if constexpr (requires { request.lattice(); }) lattice = request.lattice();
  return FindPoints(env, call, request.scene(), request.point_set(), request.revision(),
                    request.with_normals(), lattice, prefix);
}

[[nodiscard]] v1::PointSet ToProto(const Scene& scene, const PointSet& set);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_POINTS_POINTS_AT_HEAD_H_
