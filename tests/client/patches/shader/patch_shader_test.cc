// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer's shader on any OpenGL without a window; CI has Mesa's software renderer. Points that patches share have the
// same bits there too, and errors are those that patches.proto allows. Without OpenGL the tests skip, or fail if
// LATTICED_REQUIRE_OPENGL is set.
#include "tests/client/patches/shader/patch_shader.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <memory>

#include "core/base/read_file.h"
#include "tests/bench/paper/shaders/gl_context.h"
#include "tests/client/patches/shared_bits.h"
#include "tests/client/patches/surface_error.h"
#include "tests/support/real_meshes.h"

namespace latticed::testing {
namespace {

class PatchShaderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto context = bench::GlContext::Create(bench::ShaderDevice::kAny);
    if (!context.ok() && std::getenv("LATTICED_REQUIRE_OPENGL") != nullptr) {
      FAIL() << "LATTICED_REQUIRE_OPENGL is set: " << context.status();
    }
    if (!context.ok()) GTEST_SKIP() << context.status().message();
    context_ = *std::move(context);
    const auto text = ReadFile(LATTICED_PATCH_SHADER);
    ASSERT_OK(text);
    text_ = *text;
  }

  SharedCount Check(const PatchScene& scene, double tolerance) {
    const client::PatchSurface expected = EvaluateScene(scene, tolerance);
    const auto surface = EvaluateByShader(scene, text_, expected);
    EXPECT_OK(surface.status());
    if (!surface.ok()) return {};
    const Worst worst = Compare(scene, *surface);
    EXPECT_LE(worst.position, 1);
    EXPECT_LE(worst.normal, kNormalTolerance);
    const SharedCount shared = SharedPointsCheck(scene, *surface).Count();
    EXPECT_EQ(shared.different, 0u) << "of " << shared.points;
    return shared;
  }

  std::unique_ptr<bench::GlContext> context_;
  std::string text_;
};

TEST_F(PatchShaderTest, MatchesTheDefinitionOnRandomScenes) {
  SharedCount all;
  for (uint32_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    PatchScene scene =
        DrawPatchScene(seed, 0.4, seed % 2 == 0 ? RestNormals::kFacet : RestNormals::kSmooth);
    for (size_t i = 0; i < scene.control_points.size(); ++i) {  // some seams stay attached
      if (seed % 3 == 1 && i % 8 != 0) scene.control_points[i] = scene.plan->identity_points[i];
    }
    const SharedCount here = Check(scene, kSceneTolerance * scene.size());
    all.points += here.points;
    all.across_boxes += here.across_boxes;
    all.across_seams += here.across_seams;
  }
  EXPECT_GT(all.across_boxes, 1'000u);
  EXPECT_GT(all.across_seams, 100u);
}

TEST_F(PatchShaderTest, WorksOnRealMeshes) {
  const std::vector<RealMesh> meshes = RealMeshes();
  if (meshes.empty()) GTEST_SKIP() << "no meshes in $LATTICED_SHARED/models";
  for (const RealMesh& real : meshes) {
    if (real.name != "fandisk" && real.name != "spot") continue;  // software renderers are slow
    SCOPED_TRACE(real.name);
    const auto lattice = FitLattice(real.mesh.ComputeBounds(), {6, 6, 6}, {2, 2, 2}, 0.05);
    const PatchScene scene = MakePatchScene(
        real.mesh, lattice->structure, Jitter(lattice->structure, 0.1, 1), RestNormals::kFacet);
    const SharedCount shared = Check(scene, 1e-4 * scene.size());
    std::cout << context_->description() << ", " << real.name << ": " << shared.points
              << " shared points, " << shared.across_boxes << " across boxes\n";
  }
}

}  // namespace
}  // namespace latticed::testing
