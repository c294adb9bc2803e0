// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The points of a new set, from what its client sent: PointSetHeader and raw data (points.proto).
//
// Errors   kInvalidArgument with the path of the field, or the number of the point
// Threads  pure functions
#ifndef LATTICED_SERVER_RPC_POINTS_POINT_SOURCE_H_
#define LATTICED_SERVER_RPC_POINTS_POINT_SOURCE_H_

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/vec.h"
#include "core/points/sorted_points.h"
#include "latticed/v1/points.pb.h"
#include "server/engine/scene.h"

namespace latticed {

// Numbers of a client as vectors, in place.
static_assert(sizeof(Vec3d) == 3 * sizeof(double));
[[nodiscard]] inline std::span<Vec3d> AsVectors(std::vector<double>& numbers) {
  return {reinterpret_cast<Vec3d*>(numbers.data()), numbers.size() / 3};
}

// NOT_FINITE with the place of the first one that is not finite.
[[nodiscard]] absl::Status CheckFinite(std::span<const Vec3d> vectors, std::string_view field);

// What a header announces.
struct AnnouncedPoints {
  uint64_t points = 0;
  bool with_normals = false;
  bool with_weights = false;
  uint64_t data_bytes = 0;  // to come; 0 for a view

  // What the server makes of the data: RestNumbers.
  uint64_t MadeBytes() const {
    return points *
           (sizeof(Vec3d) * (with_normals ? 2 : 1) + (with_weights ? sizeof(PointWeight) : 0));
  }
};
[[nodiscard]] absl::StatusOr<AnnouncedPoints> Announced(const v1::PointSetHeader& header,
                                                        const Scene& scene,
                                                        const SceneState& state);

struct RestNumbers {
  std::vector<double> vectors;       // positions, then unit normals if there are any
  std::vector<PointWeight> weights;  // empty, or one per point
};
// Those announced. `data` has the bytes announced.
[[nodiscard]] absl::StatusOr<RestNumbers> RestPoints(const v1::PointSetHeader& header,
                                                     const Scene& scene, const SceneState& state,
                                                     std::vector<double> data);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_POINTS_POINT_SOURCE_H_
