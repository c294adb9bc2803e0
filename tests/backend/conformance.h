// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The conformance suite: every backend by name, every pipeline, against the definition in double
// (tests/support/definition.h). The bodies know core/backend.h and nothing of what lies behind it.
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

// Segments: 3 are the most that every backend evaluates point by point, whatever the degrees; 7 are the
// fewest that each composes.
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
// Fails the test where the plan cannot be made.
[[nodiscard]] Plan MakeTestPlan(PolygonMesh mesh, const LatticeStructure& structure);
[[nodiscard]] std::vector<uint32_t> AllChunks(const DeformPlan& plan);
// A box around everything that the control points can reach.
[[nodiscard]] QuantisationBox BoxFor(const DeformPlan& plan, std::span<const Vec3d> control_points);

// Null where it is not here: then the running test has failed where LATTICED_REQUIRE_BACKENDS names
// it, else is skipped.
[[nodiscard]] std::unique_ptr<Backend> BackendOrSkip(const std::string& name);
// Null, and fails the test, where it cannot be made.
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
// How often patches that meet at a vertex or an edge have different positions there.
[[nodiscard]] size_t CountCracks(const DeformPlan& plan, std::span<const Vec3d> control_points,
                                 int segments, std::span<const ViewPoint> points);

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
  // Positions and normals of every `stride`-th patch against the definition.
  void ExpectMatchesDefinition(const Plan& plan, std::span<const Vec3d> control_points,
                               const ViewSpec& spec, size_t stride = 1);

  std::unique_ptr<Backend> backend_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_BACKEND_CONFORMANCE_H_
