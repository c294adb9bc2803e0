// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes of one polygon with as many corners as a face may have.
#include <cmath>
#include <numbers>

#include "absl/time/clock.h"
#include "core/base/limits.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr int kCorners = limits::kMaxFaceCorners / 3 * 3;

// One face, whose corner i is at this radius.
template <typename Radius>
std::string PolygonObj(int corners, const Radius& radius) {
  std::string obj, face = "f";
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    obj += fmt::format("v {} {} 0\n", radius(i) * std::cos(angle), radius(i) * std::sin(angle));
    face += fmt::format(" {}", i + 1);
  }
  return obj + face + "\n";
}

class ManyCornersTest : public SceneFixture {
 protected:
  // Every third corner is at the centre: ear clipping cannot tell them apart by their place.
  void UploadFlower(int corners) {
    mesh_ = Upload(PolygonObj(corners, [](int i) { return i % 3 == 0 ? 0.0 : 1.0; }));
  }
};

TEST_F(ManyCornersTest, AStarIsCreated) {
  mesh_ = Upload(PolygonObj(kCorners, [](int i) { return i % 2 == 0 ? 1.0 : 0.01; }));

  v1::Scene scene;
  ASSERT_OK(Create(SceneRequest(), &scene));

  EXPECT_GE(scene.patches(), kCorners - 2u);
}

TEST_F(ManyCornersTest, OneThatTakesTooLongIsRefusedByItsFaceAndCorners) {
  constexpr int kFewer = 30'000;  // which takes less time
  UploadFlower(kFewer);

  ExpectRefusal(Create(SceneRequest()),
                {Code::kInvalidArgument, "INVALID_FIELD", "mesh",
                 fmt::format("face 0 has {} corners, and it takes too long", kFewer)});

  EXPECT_EQ(SceneCount(), 0);
  EXPECT_OK(DeleteMesh(mesh_)) << "no scene holds it";
}

TEST_F(ManyCornersTest, ADeadlineEndsTheTriangulation) {
  constexpr absl::Duration kMost = absl::Milliseconds(700);
  absl::Duration least = absl::InfiniteDuration();
  for (int attempt = 0; attempt < 3 && least >= kMost; ++attempt) {  // the machine may stall in one
    UploadFlower(kCorners);
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(200));
    v1::Scene scene;
    ASSERT_EQ(scenes_->CreateScene(&context, SceneRequest(), &scene).error_code(),
              grpc::StatusCode::DEADLINE_EXCEEDED);

    const absl::Time ended = absl::Now();
    ASSERT_OK(DeleteMeshOnceUnused());
    least = std::min(least, absl::Now() - ended);
  }
  EXPECT_LT(least, kMost) << "to the end it takes some seconds";
}

}  // namespace
}  // namespace latticed::testing
