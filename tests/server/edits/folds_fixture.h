// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server on a folder, with a scene that watches folds.
#ifndef LATTICED_TESTS_SERVER_EDITS_FOLDS_FIXTURE_H_
#define LATTICED_TESTS_SERVER_EDITS_FOLDS_FIXTURE_H_

#include <array>
#include <string>

#include "core/base/vec.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {

// The default lattice around kGridObj has 4^3 control points and 2^3 knot boxes. The grid lies in the knot plane between
// the layers of boxes, so in the four lower ones. The point 21 is an inner one. A move of 2 along x folds nothing; one of
// 6 does, in two of the boxes at least.
inline constexpr uint32_t kFoldPoint = 21, kOtherPoint = 26;
inline constexpr double kSafe = 0.3, kFolding = 6;

class FoldsTest : public SceneFixture {
 protected:
  void SetUp() override {
    Restart();
    ASSERT_OK(Create(WatchedRequest()));
  }
  void Restart() {
    server_.reset();
    Options options;
    options.data_dir = folder_.Path("data");
    SceneFixture::StartServer(options);
  }
  v1::CreateSceneRequest WatchedRequest(const std::string& id = kScene) const {
    v1::CreateSceneRequest request = SceneRequest(id);
    request.set_fold_watch(true);
    return request;
  }
  v1::FoldReport Certify(v1::FoldScope scope = v1::FOLD_SCOPE_SURFACE,
                         const std::string& scene = kScene) {
    auto request = For<v1::CertifyFoldsRequest>(scene);
    request.set_scope(scope);
    v1::FoldReport report;
    EXPECT_OK(Call(&Scenes::CertifyFolds, request, &report));
    return report;
  }
  v1::EditBatch Push(uint32_t point, double x, bool refuse = true,
                     const std::string& editor = "ann") {
    v1::EditBatch batch = Move(editor, ++sequence_, point, x);
    batch.set_structure_id(Lattice().structure_id());
    batch.set_refuse_folds(refuse);
    return batch;
  }
  // Applies it, and checks that the report in the answer is that of CertifyFolds.
  v1::EditResult Applied(const v1::EditBatch& batch) {
    v1::EditResult result;
    EXPECT_OK(Apply(batch, &result));
    EXPECT_EQ(result.folds().SerializeAsString(), Certify().SerializeAsString());
    return result;
  }
  v1::EditBatch InGesture(v1::EditBatch batch, v1::GesturePhase phase) {
    batch.set_gesture_id("drag");
    batch.set_gesture_phase(phase);
    return batch;
  }
  v1::EditBatch Alone(bool refuse = true) {
    v1::EditBatch batch = Push(0, 0, refuse);
    batch.clear_edits();
    return batch;
  }
  void ExpectNewFold(const v1::EditBatch& batch) {
    const std::string before = Lattice().SerializeAsString();
    ExpectRefused(Apply(batch), absl::StatusCode::kFailedPrecondition, "FOLD");
    EXPECT_EQ(Lattice().SerializeAsString(), before);
  }
  double DeterminantAt(const v1::Vec3& point) {
    auto request = For<v1::EvaluatePointsRequest>();
    for (const double x : {point.x(), point.y(), point.z()}) {
      request.mutable_world_points()->add_positions(x);
    }
    v1::EvaluatePointsResponse response;
    EXPECT_OK(Call(&Scenes::EvaluatePoints, request, &response));
    if (response.jacobians_size() != 9) return 0;
    std::array<Vec3d, 3> j;
    for (int i = 0; i < 9; ++i) j[static_cast<size_t>(i / 3)][i % 3] = response.jacobians(i);
    return Dot(j[0], Cross(j[1], j[2]));
  }

  TemporaryFolder folder_;
  uint64_t sequence_ = 0;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_EDITS_FOLDS_FIXTURE_H_
