// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// MeasureScene through the stub.
#include <cmath>
#include <initializer_list>
#include <string>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

// The unit cube as six quads.
constexpr char kCubeObj[] =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

class MeasureSceneTest : public SceneFixture {
 protected:
  void SetUp() override {
    SceneFixture::SetUp();
    open_ = mesh_;
    mesh_ = Upload(kCubeObj);
    ASSERT_OK(Create(SceneRequest()));
  }
  static v1::MeasureSceneRequest Request(std::initializer_list<v1::Measure> measures) {
    auto request = For<v1::MeasureSceneRequest>();
    for (const v1::Measure measure : measures) request.add_measures(measure);
    return request;
  }
  absl::Status Measure(const v1::MeasureSceneRequest& request,
                       v1::MeasureSceneResponse* response = nullptr) {
    return Call(&Scenes::MeasureScene, request, response);
  }

  std::string open_;
};

TEST_F(MeasureSceneTest, MeasuresTheDeformedSurface) {
  v1::EditBatch stretch = Move("ann", 1, 0, 0);
  auto& transform = *stretch.mutable_edits(0)->mutable_transform_control_points();
  for (uint32_t i = 0; i < 64; ++i) transform.add_indices(i);
  for (const double m : {2., 0., 0., 0., 0., 3., 0., 0., 0., 0., 1., 0., 5., 6., 7., 1.}) {
    transform.add_matrix(m);
  }
  ASSERT_OK(Apply(stretch));
  v1::MeasureSceneResponse got;

  ASSERT_OK(Measure(Request({v1::MEASURE_VOLUME, v1::MEASURE_AREA, v1::MEASURE_CENTROID,
                             v1::MEASURE_BOUNDS, v1::MEASURE_VOLUME}),
                    &got));

  EXPECT_EQ(got.revision(), 1u);
  EXPECT_EQ(got.structure_id(), 1u);
  EXPECT_NEAR(got.volume(), 6, 1e-12);
  EXPECT_NEAR(got.area(), 2 * (6 + 2 + 3), 1e-11);
  EXPECT_LE(got.area_error(), 1e-6 * got.area());
  EXPECT_NEAR(got.centroid().x(), 6, 1e-12);
  EXPECT_NEAR(got.centroid().y(), 7.5, 1e-12);
  EXPECT_NEAR(got.centroid().z(), 7.5, 1e-12);
  EXPECT_NEAR(got.least().y(), 6, 1e-9);
  EXPECT_NEAR(got.greatest().y(), 9, 1e-9);
  EXPECT_EQ(got.volume_gradient_size() + got.area_gradient_size() + got.centroid_gradient_size(),
            0);
  EXPECT_GT(Get().bytes().at("moments"), 0u);
}

TEST_F(MeasureSceneTest, SendsOnlyWhatWasAskedFor) {
  v1::MeasureSceneResponse got;
  ASSERT_OK(Measure(Request({v1::MEASURE_BOUNDS}), &got));
  EXPECT_FALSE(got.has_volume() || got.has_area() || got.has_centroid());
  EXPECT_TRUE(got.has_least() && got.has_greatest());
  EXPECT_EQ(Get().bytes().count("moments"), 0u);
}

TEST_F(MeasureSceneTest, GradientsPredictAMove) {
  auto request = Request({v1::MEASURE_VOLUME, v1::MEASURE_AREA, v1::MEASURE_CENTROID});
  request.set_with_gradient(true);
  request.set_area_tolerance(1e-10);
  v1::MeasureSceneResponse before, after;
  ASSERT_OK(Measure(request, &before));
  ASSERT_EQ(before.volume_gradient_size(), 3 * 64);
  ASSERT_EQ(before.area_gradient_size(), 3 * 64);
  ASSERT_EQ(before.centroid_gradient_size(), 9 * 64);
  constexpr int kPoint = 21;
  constexpr double kMove = 1e-5;
  ASSERT_OK(Apply(Move("ann", 1, kPoint, kMove)));

  ASSERT_OK(Measure(request, &after));

  EXPECT_NEAR((after.volume() - before.volume()) / kMove, before.volume_gradient(3 * kPoint), 1e-4);
  EXPECT_NEAR((after.area() - before.area()) / kMove, before.area_gradient(3 * kPoint), 1e-3);
  EXPECT_NEAR((after.centroid().x() - before.centroid().x()) / kMove,
              before.centroid_gradient(9 * kPoint), 1e-4);
  EXPECT_GT(std::abs(before.volume_gradient(3 * kPoint)), 1e-3);
}

TEST_F(MeasureSceneTest, RefusesBadRequests) {
  ExpectRefused(Measure(Request({})), Code::kInvalidArgument, "INVALID_FIELD", "measures");
  ExpectRefused(Measure(Request({v1::MEASURE_UNSPECIFIED})), Code::kInvalidArgument,
                "INVALID_FIELD", "measures[0]");
  ExpectRefused(Measure(Request({v1::MEASURE_AREA, static_cast<v1::Measure>(99)})),
                Code::kInvalidArgument, "UNSUPPORTED", "measures[1]");
  for (const double tolerance : {0., 1e-13, 0.2, -1.}) {
    auto request = Request({v1::MEASURE_AREA});
    request.set_area_tolerance(tolerance);
    ExpectRefused(Measure(request), Code::kInvalidArgument, "OUT_OF_RANGE", "area_tolerance");
  }
  auto unknown = Request({v1::MEASURE_AREA});
  unknown.set_scene("nowhere");
  ExpectRefused(Measure(unknown), Code::kNotFound, "NOT_FOUND");
}

TEST_F(MeasureSceneTest, AnOpenSurfaceHasAnAreaAndNoVolume) {
  ASSERT_OK(DeleteScene());
  mesh_ = open_;
  ASSERT_OK(Create(SceneRequest()));
  for (const auto measure : {v1::MEASURE_VOLUME, v1::MEASURE_CENTROID}) {
    const auto status = Measure(Request({measure}));
    ExpectRefused(status, Code::kFailedPrecondition, "OPEN_SURFACE");
    EXPECT_GT(std::stoi(error::DetailsOf(status).metadata.at("border_edges")), 0);
    EXPECT_EQ(error::DetailsOf(status).metadata.at("torn_edges"), "0");
  }
  v1::MeasureSceneResponse got;
  ASSERT_OK(Measure(Request({v1::MEASURE_AREA, v1::MEASURE_BOUNDS}), &got));
  EXPECT_GT(got.area(), 0);
}

TEST_F(MeasureSceneTest, ATornSurfaceHasNoVolume) {
  ASSERT_OK(DeleteScene());
  auto request = SceneRequest();  // the lattice around one half of the cube
  auto& lattice = *request.add_lattices()->mutable_lattice();
  SetFrame(*lattice.mutable_frame(), {-0.1, -0.1, -0.1}, {0.6, 1.2, 1.2});
  ASSERT_OK(Create(request));
  v1::MeasureSceneResponse got;
  ASSERT_OK(Measure(Request({v1::MEASURE_VOLUME}), &got));
  EXPECT_NEAR(got.volume(), 1, 1e-12);
  constexpr uint32_t kOnTheFace = 23;  // i = 3 of 4
  ASSERT_OK(Apply(Move("ann", 1, kOnTheFace, 0.1)));

  const auto status = Measure(Request({v1::MEASURE_VOLUME}));

  ExpectRefused(status, Code::kFailedPrecondition, "OPEN_SURFACE");
  EXPECT_GT(std::stoi(error::DetailsOf(status).metadata.at("torn_edges")), 0);
  EXPECT_EQ(error::DetailsOf(status).metadata.at("border_edges"), "0");
}

TEST_F(MeasureSceneTest, ACollapsedSurfaceHasNoCentroid) {
  v1::EditBatch collapse = Move("ann", 1, 0, 0);
  auto& all = *collapse.mutable_edits(0)->mutable_replace_control_points();
  for (int i = 0; i < 3 * 64; ++i) all.add_control_points(1);
  ASSERT_OK(Apply(collapse));
  v1::MeasureSceneResponse got;
  ASSERT_OK(Measure(Request({v1::MEASURE_VOLUME, v1::MEASURE_AREA}), &got));
  EXPECT_EQ(got.volume(), 0);
  ExpectRefused(Measure(Request({v1::MEASURE_CENTROID})), Code::kFailedPrecondition, "NO_VOLUME");
}

}  // namespace
}  // namespace latticed::testing
