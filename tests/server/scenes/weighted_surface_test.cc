// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What follows the weighted surface, through the stub: views with a tolerance, measures, a kept volume, folds.
#include <cmath>
#include <cstring>

#include "tests/server/scenes/weights_fixture.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

class WeightedSurfaceTest : public WeightsFixture {};

TEST_F(WeightedSurfaceTest, ViewsWithAToleranceAreWithinIt) {
  v1::CreateSceneRequest request = Weighted();
  request.mutable_default_view()->set_tolerance(0.01);
  ASSERT_OK(Create(request));
  const auto update_of = [&](EventLog& log) {
    auto update = For<v1::GetUpdateRequest>();
    update.mutable_view()->set_segments(32);
    update.mutable_view()->set_tolerance(1e-3);
    update.mutable_view()->set_encoding(v1::ENCODING_RAW);
    update.mutable_view()->set_normals(v1::NORMAL_MODE_NONE);
    return Update(update, log);
  };
  const auto points = [](const EventLog& log) {
    size_t bytes = 0;
    for (const auto& [chunk, data] : log.chunks) bytes += data.size();
    return bytes / (3 * sizeof(float));
  };
  EventLog lifted, bent;
  ASSERT_OK(Lift(3));
  ASSERT_OK(update_of(lifted));
  v1::EditBatch batch = Move("ann", 2, 21, 0.7);
  ASSERT_OK(Apply(batch));
  ASSERT_OK(update_of(bent));

  EXPECT_LE(lifted.ends.back().certified_error(), 1e-3);
  EXPECT_LE(bent.ends.back().certified_error(), 1e-3);
  // w and the lift are linear: the corners of patches suffice.
  EXPECT_EQ(points(lifted), 3 * Get().patches());
  EXPECT_GT(points(bent), 3 * Get().patches());
}

TEST_F(WeightedSurfaceTest, ControlNetsHaveOneDegreeMore) {
  ASSERT_OK(Create(Weighted()));
  ASSERT_OK(Lift(3));
  auto request = For<v1::ExportRequest>();
  request.set_format(v1::EXPORT_FORMAT_CONTROL_NETS);
  const auto bytes = Export(request);
  ASSERT_OK(bytes);
  uint32_t header[4];
  ASSERT_GE(bytes->size(), 32u);
  std::memcpy(header, bytes->data() + 8, sizeof(header));
  const v1::LatticeAxes degree = Lattice().lattice().degree();
  const auto n = static_cast<uint32_t>(degree.u() + degree.v() + degree.w() + 1);
  const uint32_t m = (n + 1) * (n + 2) / 2;
  EXPECT_EQ(header[1], n);
  EXPECT_EQ(header[2], m);
  ASSERT_EQ(bytes->size(), 32 + Get().patches() * m * sizeof(Vec3d));
  for (size_t at = 32; at < bytes->size(); at += sizeof(Vec3d)) {
    Vec3d p;
    std::memcpy(&p, bytes->data() + at, sizeof(p));
    ASSERT_NEAR(p.z, 1.5 * p.x, 1e-11);
  }
}

// A unit cube whose bottom rests and whose top follows.
class WeightedCubeTest : public WeightsFixture {
 protected:
  void SetUp() override {
    WeightsFixture::SetUp();
    mesh_ = Upload(CubeObj());
    ASSERT_OK(Create(Weighted({0, 0, 0, 0, 1, 1, 1, 1})));
  }
  v1::MeasureSceneResponse Measured() {
    auto request = For<v1::MeasureSceneRequest>();
    for (const auto measure :
         {v1::MEASURE_VOLUME, v1::MEASURE_AREA, v1::MEASURE_CENTROID, v1::MEASURE_BOUNDS}) {
      request.add_measures(measure);
    }
    request.set_with_gradient(true);
    v1::MeasureSceneResponse response;
    EXPECT_OK(Call(&Scenes::MeasureScene, request, &response));
    return response;
  }
  // The derivative when all control points move along z.
  static double SumOfZ(const google::protobuf::RepeatedField<double>& gradient) {
    double sum = 0;
    for (int i = 2; i < gradient.size(); i += 3) sum += gradient[i];
    return sum;
  }
};

TEST_F(WeightedCubeTest, MeasuresTheWeightedSurface) {
  ASSERT_OK(Lift(1));

  const v1::MeasureSceneResponse got = Measured();

  EXPECT_NEAR(got.volume(), 2, 1e-12);
  EXPECT_NEAR(got.area(), 10, 1e-5);
  EXPECT_LE(got.area_error(), 1e-6 * got.area());
  EXPECT_NEAR(got.centroid().x(), 0.5, 1e-12);
  EXPECT_NEAR(got.centroid().z(), 1, 1e-12);
  EXPECT_NEAR(got.least().z(), 0, 1e-9);
  EXPECT_NEAR(got.greatest().z(), 2, 1e-8);
  EXPECT_NEAR(SumOfZ(got.volume_gradient()), 1, 1e-12);
  EXPECT_NEAR(SumOfZ(got.area_gradient()), 4, 1e-5);
  ASSERT_EQ(got.centroid_gradient_size(), 9 * 64);
  double rise = 0;  // three derivatives for each coordinate; z by z is the last
  for (int i = 8; i < got.centroid_gradient_size(); i += 9) rise += got.centroid_gradient(i);
  EXPECT_NEAR(rise, 0.5, 1e-12);
}

TEST_F(WeightedCubeTest, TheCentroidMakesNoMoments) {
  ASSERT_OK(Lift(1));
  auto request = For<v1::MeasureSceneRequest>();
  request.add_measures(v1::MEASURE_CENTROID);
  v1::MeasureSceneResponse response;
  ASSERT_OK(Call(&Scenes::MeasureScene, request, &response));
  EXPECT_NEAR(response.centroid().z(), 1, 1e-12);
  EXPECT_FALSE(response.has_volume());
  EXPECT_EQ(Get().bytes().count("moments"), 0u);

  request.add_measures(v1::MEASURE_VOLUME);
  ASSERT_OK(Call(&Scenes::MeasureScene, request, &response));
  EXPECT_NEAR(response.volume(), 2, 1e-12);
  EXPECT_EQ(Get().bytes().count("moments"), 0u);

  request.clear_measures();
  request.add_measures(v1::MEASURE_VOLUME);
  ASSERT_OK(Call(&Scenes::MeasureScene, request, &response));
  EXPECT_NEAR(response.volume(), 2, 1e-12);
  EXPECT_GT(Get().bytes().at("moments"), 0u);
}

TEST_F(WeightedCubeTest, KeepsAVolume) {
  v1::EditBatch batch = Move("ann", 1, 42, 0.5);
  batch.mutable_keep_volume();
  ASSERT_OK(Apply(batch));
  EXPECT_NEAR(Measured().volume(), 1, 1e-12);
  EXPECT_GT(std::abs(Measured().centroid().x() - 0.5), 1e-4);
}

TEST_F(WeightedSurfaceTest, AnOpenWeightedSurfaceHasNoVolume) {
  ASSERT_OK(Create(Weighted()));
  auto request = For<v1::MeasureSceneRequest>();
  request.add_measures(v1::MEASURE_VOLUME);
  ExpectRefused(Call(&Scenes::MeasureScene, request), Code::kFailedPrecondition, "OPEN_SURFACE");
  v1::EditBatch batch = Move("ann", 1, 21, 0.1);
  batch.mutable_keep_volume();
  ExpectRefused(Apply(batch), Code::kFailedPrecondition, "OPEN_SURFACE");
  EXPECT_EQ(Get().revision(), 0u);
}

// w rises by 1/2 for each unit of x, so a shift by d along x has the determinant 1 + d / 2.
TEST_F(WeightedSurfaceTest, FoldsOfTheSurfaceAreReportedWatchedAndRefused) {
  v1::CreateSceneRequest request = Weighted();
  request.set_fold_watch(true);
  ASSERT_OK(Create(request));
  const auto shift = [&](uint64_t sequence, double x) {
    v1::EditBatch batch = Move("ann", sequence, 0, 0);
    auto* all = batch.mutable_edits(0)->mutable_move_control_points();
    all->clear_indices();
    for (uint32_t i = 0; i < 64; ++i) all->add_indices(i);
    all->mutable_offset()->set_x(x);
    return batch;
  };
  v1::EditResult result;
  ASSERT_OK(Apply(shift(1, -1.9), &result));
  EXPECT_TRUE(result.folds().certified());

  v1::EditBatch refused = shift(2, -0.2);
  refused.set_refuse_folds(true);
  ExpectRefused(Apply(refused), Code::kFailedPrecondition, "FOLD");
  EXPECT_EQ(Get().revision(), 1u);
  ASSERT_OK(Apply(shift(3, -0.2), &result));
  EXPECT_FALSE(result.folds().certified());

  v1::FoldReport report;
  ASSERT_OK(Call(&Scenes::CertifyFolds, For<v1::CertifyFoldsRequest>(), &report));
  EXPECT_FALSE(report.certified());
  ASSERT_GT(report.folded(), 0u);
  EXPECT_NEAR(report.places(0).determinant(), 1 - 2.1 / 2, 1e-9);
}

}  // namespace
}  // namespace latticed::testing
