// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The conformance suite compares every backend, by name, and every pipeline with the definition in
// double (tests/support/definition.h). The test bodies use core/backend.h only.
#ifndef LATTICED_TESTS_BACKEND_CONFORMANCE_H_
#define LATTICED_TESTS_BACKEND_CONFORMANCE_H_

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "core/backend.h"
#include "tests/support/backends.h"
#include "tests/support/definition.h"
#include "tests/support/pipeline_name.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {

// Numbers of segments. Up to 3, every backend evaluates point by point, whatever the degrees. From
// 7 on, every backend composes.
inline constexpr std::array kFewAndMany = {3, 7};

struct Subject {
  std::string backend;
  Pipeline pipeline;
};
inline void PrintTo(const Subject& subject, std::ostream* stream) {
  *stream << subject.backend << " " << PipelineName(subject.pipeline);
}
[[nodiscard]] std::vector<Subject> Subjects();
[[nodiscard]] std::string SubjectName(const ::testing::TestParamInfo<Subject>& info);

using Plan = std::shared_ptr<const DeformPlan>;
// Fails the test if the plan cannot be made.
[[nodiscard]] Plan MakeTestPlan(PolygonMesh mesh, const LatticeStructure& structure);
// Weights from 0 to 1. About a third are 0 and a third are 1, so that some patches rest and some follow.
[[nodiscard]] VertexWeights RandomWeights(const PolygonMesh& mesh, uint32_t seed);
[[nodiscard]] std::vector<uint32_t> AllChunks(const DeformPlan& plan);
// A box around everything that the control points can reach.
[[nodiscard]] QuantisationBox BoxFor(const DeformPlan& plan, std::span<const Vec3d> control_points);

// Null if there is no such backend here. The running test then fails if LATTICED_REQUIRE_BACKENDS
// names it, and is skipped otherwise.
[[nodiscard]] std::unique_ptr<Backend> BackendOrSkip(const std::string& name);
// Null, and the test fails, if the view cannot be made.
[[nodiscard]] std::unique_ptr<DeformView> MakeView(Backend& backend, Pipeline pipeline,
                                                   const Plan& plan, const ViewSpec& spec);
// By chunk, in wire layout.
[[nodiscard]] std::vector<std::vector<uint8_t>> ReadAll(const DeformPlan& plan, DeformView& view);
// Evaluates everything in a fresh view.
[[nodiscard]] std::vector<ViewPoint> EvaluateAll(Backend& backend, Pipeline pipeline,
                                                 const Plan& plan,
                                                 std::span<const Vec3d> control_points,
                                                 const ViewSpec& spec);
[[nodiscard]] std::vector<ViewPoint> Decode(const DeformPlan& plan, const ViewSpec& spec,
                                            const QuantisationBox& box,
                                            const std::vector<std::vector<uint8_t>>& chunks);
// Counts the points at vertices and edges where a patch's position differs from the first patch's.
[[nodiscard]] size_t CountCracks(const DeformPlan& plan, std::span<const Vec3d> control_points,
                                 int segments, std::span<const ViewPoint> points);

// The point at barycentrics `b` of the Bernstein form of degree n with these coefficients, x y z each.
[[nodiscard]] Vec3d PointOfNet(const double* net, int n, const std::array<double, 3>& b);

class BackendTest : public ::testing::TestWithParam<Subject> {
 protected:
  void SetUp() override;

  std::unique_ptr<DeformView> MakeView(const Plan& plan, const ViewSpec& spec) {
    return testing::MakeView(*backend_, GetParam().pipeline, plan, spec);
  }
  std::vector<ViewPoint> EvaluateAll(const Plan& plan, std::span<const Vec3d> control_points,
                                     const ViewSpec& spec) {
    return testing::EvaluateAll(*backend_, GetParam().pipeline, plan, control_points, spec);
  }
  // Compares positions and normals of every `stride`-th patch with the definition. Views of float32.
  void ExpectMatchesDefinition(const Plan& plan, std::span<const Vec3d> control_points,
                               const ViewSpec& spec, size_t stride = 1);

  std::unique_ptr<Backend> backend_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_BACKEND_CONFORMANCE_H_
