// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes with vertex weights for tests through the stub.
#ifndef LATTICED_TESTS_SERVER_SCENES_WEIGHTS_FIXTURE_H_
#define LATTICED_TESTS_SERVER_SCENES_WEIGHTS_FIXTURE_H_

#include <string>
#include <vector>

#include "tests/server/support/server_test.h"

namespace latticed::testing {

// kGridObj has 3 x 3 vertices on [0,2]^2: those at x = 0 rest, those at x = 2 follow.
inline const std::vector<float> kGridWeights = {0, 0.5f, 1, 0, 0.5f, 1, 0, 0.5f, 1};
inline std::string WeightBytes(const std::vector<float>& weights) {
  return {reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float)};
}

class WeightsFixture : public SceneFixture {
 protected:
  v1::CreateSceneRequest Weighted(const std::vector<float>& weights = kGridWeights) const {
    v1::CreateSceneRequest request = SceneRequest();
    request.mutable_weights()->set_values(WeightBytes(weights));
    return request;
  }
  // Lifts all control points by `z`.
  absl::Status Lift(double z) {
    v1::EditBatch lift = Move("ann", 1, 0, 0);
    auto* all = lift.mutable_edits(0)->mutable_move_control_points();
    all->clear_indices();
    for (uint32_t i = 0; i < 64; ++i) all->add_indices(i);
    all->mutable_offset()->set_z(z);
    return Apply(lift);
  }
  // Where the second face's triangle (1,0), (2,0), (2,1) has its point with these barycentrics.
  static v1::SurfacePoint PointAt(double a, double b, double c) {
    v1::SurfacePoint point;
    point.set_face(1);
    for (const uint32_t corner : {4u, 5u, 6u}) point.add_corners(corner);
    for (const double number : {a, b, c}) point.add_barycentrics(number);
    return point;
  }
  void ExpectRefusedForWeights(const absl::Status& status, const std::string& what,
                               const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    ExpectRefusal(status, {absl::StatusCode::kFailedPrecondition, "VERTEX_WEIGHTS", "", what}, file,
                  line);
  }
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SCENES_WEIGHTS_FIXTURE_H_
