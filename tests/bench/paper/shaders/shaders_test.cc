// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the tessellation shaders with the definition, on any OpenGL; CI has Mesa's software
// renderer. Without OpenGL the tests skip, or fail if LATTICED_REQUIRE_OPENGL is set.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "tests/bench/exact_mesh.h"
#include "tests/bench/paper/bezier_net/bezier_nets_on_host.h"
#include "tests/bench/paper/shaders/drawing/vertex_drawing.h"
#include "tests/bench/paper/shaders/gl_context.h"
#include "tests/bench/paper/shaders/measure_shaders.h"
#include "tests/bench/paper/shaders/shader_tessellator.h"
#include "tests/bench/paper/shaders/shader_verify.h"
#include "tests/bench/scenario.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::bench {
namespace {

// These are 27,391 tessellated points at level 10. Past 65,535 points in one draw, Mesa 22.3's
// software renderer repeats the points of the first patches.
constexpr size_t kPatches = 301;

class ShadersTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto context = GlContext::Create(ShaderDevice::kAny);
    if (!context.ok() && std::getenv("LATTICED_REQUIRE_OPENGL") != nullptr) {
      FAIL() << "LATTICED_REQUIRE_OPENGL is set: " << context.status();
    }
    if (!context.ok()) GTEST_SKIP() << context.status().message();
    context_ = *std::move(context);
  }

  void Prepare(const std::array<int, 3>& degree) {
    ASSERT_OK_AND_ASSIGN(plan_, MakeExactPlan(kPatches, degree));
    points_ = testing::Jitter(plan_->structure, 0.02, 20140604);
    nets_ = BezierNetsOnHost(*plan_, points_);
  }

  std::unique_ptr<ShaderTessellator> Make(const ShaderTessellator::Spec& spec) {
    auto made = ShaderTessellator::Create(spec, nets_);
    EXPECT_OK(made);
    return made.ok() ? *std::move(made) : nullptr;
  }

  // Compares all vertices with the definition.
  ComparatorPrecision Check(ShaderTessellator& tessellator) {
    const auto vertices = tessellator.Capture(0, kPatches);
    EXPECT_OK(vertices);
    if (!vertices.ok()) return {};
    const auto precision = CompareShaders(*plan_, points_, 0, kPatches, *vertices);
    EXPECT_OK(precision);
    if (!precision.ok()) return {};
    EXPECT_OK(precision->Check(kShaderNormalError));
    return *precision;
  }

  std::unique_ptr<GlContext> context_;
  std::shared_ptr<const DeformPlan> plan_;
  std::vector<Vec3d> points_;
  std::vector<NetPoint> nets_;
};

TEST_F(ShadersTest, VerticesMatchTheDefinition) {
  ASSERT_NO_FATAL_FAILURE(Prepare({2, 2, 2}));
  for (const NetSource source : {NetSource::kVertices, NetSource::kBuffer}) {
    const auto tessellator = Make({.degree = 6, .level = 10, .source = source});
    ASSERT_NE(tessellator, nullptr);

    const ComparatorPrecision precision = Check(*tessellator);

    // OpenGL 4.5, §11.2.2.1: rings of 30, 24, 18, 12 and 6 points and one in the middle.
    EXPECT_EQ(tessellator->triangles_per_patch(), 150u);
    EXPECT_EQ(precision.distinct_points, 91u);
    EXPECT_GT(precision.normal, 0);
  }
}

TEST_F(ShadersTest, BatchesThatFitASmallBufferAreAllPatches) {
  ASSERT_NO_FATAL_FAILURE(Prepare({2, 2, 2}));
  const auto tessellator = Make({.degree = 6, .level = 4, .capture_bytes = 64 << 10});
  ASSERT_NE(tessellator, nullptr);

  // Level 4: 3 (2 * 4 - 2) triangles in the outer ring, 6 around the middle. Each takes 72 bytes.
  EXPECT_EQ(tessellator->triangles_per_patch(), 24u);
  EXPECT_EQ(tessellator->batch_patches(), 37u);
  EXPECT_EQ(Check(*tessellator).distinct_points, 19u);
}

TEST_F(ShadersTest, NetsTooLargeForAPatchOfVerticesComeFromABuffer) {
  ASSERT_NO_FATAL_FAILURE(Prepare({3, 3, 3}));

  const auto refused =
      ShaderTessellator::Create({.degree = 9, .source = NetSource::kVertices}, nets_);
  const auto tessellator = Make({.degree = 9, .level = 3});

  EXPECT_THAT(refused, testing::StatusIs(absl::StatusCode::kInvalidArgument));
  ASSERT_NE(tessellator, nullptr);
  Check(*tessellator);
}

TEST_F(ShadersTest, PicturesShowTheSurfaceAndTimesAreTimes) {
  ASSERT_NO_FATAL_FAILURE(Prepare({2, 2, 2}));
  const auto tessellator = Make({.degree = 6, .level = 10});
  ASSERT_NE(tessellator, nullptr);

  ASSERT_OK_AND_ASSIGN(const auto pixels, tessellator->Draw(2));
  const auto captured = tessellator->TimeCaptured(1), drawn = tessellator->TimeDrawn(2, 1);

  EXPECT_GT(std::count_if(pixels.begin(), pixels.end(), [](uint8_t v) { return v != 0; }), 100);
  ASSERT_OK(captured);
  ASSERT_OK(drawn);
  EXPECT_GT(captured->median, 0);
  EXPECT_GT(drawn->median, 0);
}

TEST_F(ShadersTest, MeasuringVerifiesAndTimesBothSources) {
  ASSERT_NO_FATAL_FAILURE(Prepare({2, 2, 2}));
  const Scenario scenario = MakeScenario("small", plan_);

  ASSERT_OK_AND_ASSIGN(
      const auto times,
      MeasureShaders(scenario, BezierNetsOnHost(*plan_, scenario.control_points[0]),
                     ShaderDevice::kAny, 1));
  const auto wrong = MeasureShaders(scenario, nets_, ShaderDevice::kAny, 1);

  EXPECT_EQ(times.triangles, 150u);
  EXPECT_EQ(times.distinct_points, 91u);
  EXPECT_GT(times.vertices.captured.median, 0);
  EXPECT_GT(times.buffer.drawn.median, 0);
  EXPECT_LE(times.captured(), times.vertices.captured.median);
  // These nets are of other control points.
  EXPECT_THAT(wrong, testing::StatusIs(absl::StatusCode::kInternal));
}

ViewSpec DrawnSpec() { return {.segments = 10, .format = VertexFormat::kFloat32}; }

TEST_F(ShadersTest, VerticesOfAViewShowTheSamePictureAsTheShaders) {
  ASSERT_NO_FATAL_FAILURE(Prepare({2, 2, 2}));
  Scenario scenario = MakeScenario("small", plan_);
  scenario.control_points[0] = points_;
  const auto view = MakeView(scenario, Pipeline::kFused, DrawnSpec(), 1);
  std::vector<float> vertices(scenario.points(10) * VertexDrawing::kFloatsPerVertex);
  auto* to = reinterpret_cast<uint8_t*>(vertices.data());
  for (const uint32_t chunk : scenario.all_chunks) {
    const auto bytes = ReadChunk(scenario, *view, chunk);
    to = std::copy(bytes.begin(), bytes.end(), to);
  }
  const auto tessellator = Make({.degree = 6, .level = 10});
  ASSERT_NE(tessellator, nullptr);
  ASSERT_OK_AND_ASSIGN(const auto drawing, VertexDrawing::Create(vertices, 10));

  ASSERT_OK_AND_ASSIGN(const auto pixels, drawing->Draw(2));
  ASSERT_OK_AND_ASSIGN(const auto expected, tessellator->Draw(2));

  EXPECT_EQ(drawing->CountTriangles(), kPatches * 100);
  // Alpha is 1 where a triangle was drawn. The patterns differ, so a few pixels at rims may.
  size_t drawn = 0, different = 0;
  for (size_t i = 3; i < pixels.size(); i += 4) {
    if (expected[i] != 0) ++drawn;
    if ((pixels[i] != 0) != (expected[i] != 0)) ++different;
  }
  EXPECT_GT(drawn, 1'000u);
  EXPECT_LT(different, drawn / 50);
}

TEST_F(ShadersTest, DrawingIsTimedForFloatsWithNormalsOnly) {
  ASSERT_NO_FATAL_FAILURE(Prepare({2, 2, 2}));
  const Scenario scenario = MakeScenario("small", plan_);
  const auto view = MakeView(scenario, Pipeline::kFused, DrawnSpec(), 1);
  ViewSpec spec = DrawnSpec();
  spec.normals = NormalMode::kNone;
  const auto bare = MakeView(scenario, Pipeline::kFused, spec, 1);

  ASSERT_OK_AND_ASSIGN(const auto times, MeasureDrawing(scenario, *view, ShaderDevice::kAny, 1));
  const auto refused = MeasureDrawing(scenario, *bare, ShaderDevice::kAny, 1);

  EXPECT_EQ(times.triangles, kPatches * 100);
  EXPECT_GT(times.times.median, 0);
  EXPECT_THAT(refused, testing::StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_F(ShadersTest, ASoftwareRendererIsNoGpu) {
  const auto gpu = GlContext::Create(ShaderDevice::kCuda);

  if (gpu.ok()) {
    EXPECT_NE((*gpu)->description().find("NVIDIA"), std::string::npos) << (*gpu)->description();
  } else {
    EXPECT_THAT(gpu, testing::StatusIs(absl::StatusCode::kUnavailable));
  }
}

}  // namespace
}  // namespace latticed::bench
