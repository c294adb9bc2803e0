// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The conformance suite: every backend by name, every pipeline, against the definition in double
// (core/ffd/direct_ffd.h). The bodies know core/backend.h and nothing of what lies behind it.
//
// Tolerances, relative to D = max(diagonal of the deformed bounds, diagonal of the control points
// that influence the mesh):                                               DESIGN §2 "Precision"
//   position  kFusedPosition, kGemmPosition
//   normal    fused: kFusedNormal * kappa rad where kappa <= kMostKappa
//             GEMM:  the products' rounding carried to the cross product, GemmNormalBound()
#ifndef LATTICED_TESTS_BACKEND_CONFORMANCE_H_
#define LATTICED_TESTS_BACKEND_CONFORMANCE_H_

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "core/backend.h"
#include "core/ffd/direct_ffd.h"
#include "tests/support/backends.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {

inline constexpr double kFusedPosition = 3e-7;
inline constexpr double kGemmPosition = 1e-6;
inline constexpr double kFusedNormal = 2e-5;
inline constexpr double kMostKappa = 100;
inline constexpr double kUnitTolerance = 1e-6;

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

// The vertices of a view, decoded from wire layout, all chunks together.
struct Vertices {
  std::vector<Vec3d> positions;                     // relative to the local origin, kFloat32
  std::vector<Vec3d> normals;                       // as stored, kFloat32
  std::vector<std::array<uint32_t, 3>> integers;    // kQuantised
  std::vector<std::array<uint32_t, 2>> octahedral;  // kQuantised
};
[[nodiscard]] Vertices Decode(const DeformPlan& plan, const ViewSpec& spec,
                              const std::vector<std::vector<uint8_t>>& chunks);

class BackendTest : public ::testing::TestWithParam<Subject> {
 protected:
  void SetUp() override;

  std::unique_ptr<DeformView> MakeView(const Plan& plan, const ViewSpec& spec);
  static std::vector<std::vector<uint8_t>> ReadAll(const DeformPlan& plan, DeformView& view);
  // Evaluates everything in a fresh view.
  Vertices EvaluateAll(const Plan& plan, std::span<const Vec3d> control_points,
                       const ViewSpec& spec);
  // Positions and normals of every `stride`-th patch against the definition.
  void ExpectMatchesDefinition(const Plan& plan, std::span<const Vec3d> control_points,
                               const ViewSpec& spec, size_t stride = 1);

  std::unique_ptr<Backend> backend_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_BACKEND_CONFORMANCE_H_
