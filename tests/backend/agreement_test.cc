// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Every pipeline of every backend agrees with every pipeline of the CPU, point by point, within the
// sum of their tolerances: the CPU's with each other where there is no other backend.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/codec/octahedral.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/backend/definition.h"
#include "tests/support/pipeline_name.h"
#include "tests/support/real_meshes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeed = 20140311;
constexpr double kNoise = 0.08;  // of the frame
constexpr std::array kPipelines{Pipeline::kFused, Pipeline::kGemm, Pipeline::kGemm12,
                                Pipeline::kControlNet};

// How far a normal is from the middle of its cell at most, as in view_test.cc.
double CellRadius(int bits) { return 2 * std::sqrt(6.0) / OctahedralMax(bits); }

Vec3d NormalOf(const std::array<uint32_t, 2>& octahedral, int bits) {
  const auto [s, t] = octahedral;
  return ToDouble(DequantiseNormal({static_cast<int32_t>(s), static_cast<int32_t>(t)}, bits));
}

// A view by one pipeline of a backend.
struct Evaluated {
  std::string backend;
  Pipeline pipeline;
  Vertices vertices;
};

// Of two at a point: world units and rad.
struct Distance {
  double position, normal;
};

Distance BetweenFloats(const Vertices& a, const Vertices& b, size_t at) {
  return {Norm(a.positions[at] - b.positions[at]), Angle(a.normals[at], b.normals[at])};
}

// Less what rounding to integers may add: a step an axis, of which the farthest counts, and two
// cells' radii.
Distance BetweenIntegers(const Vertices& a, const Vertices& b, size_t at, double step, int bits) {
  double steps = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    steps =
        std::max(steps, std::abs(static_cast<double>(a.integers[at][axis]) - b.integers[at][axis]));
  }
  const double chord = Norm(NormalOf(a.octahedral[at], bits) - NormalOf(b.octahedral[at], bits));
  return {(steps - 1) * step, chord - 2 * CellRadius(bits)};
}

class Agreement : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    cpu_ = BackendOrSkip("cpu");
    if (cpu_ != nullptr) backend_ = BackendOrSkip(GetParam());
  }

  void Check(PolygonMesh mesh, const LatticeOptions& options, size_t stride = 1) {
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), options);
    plan_ = MakeTestPlan(std::move(mesh), structure);
    ASSERT_NE(plan_, nullptr);
    points_ = Jitter(structure, kNoise, kSeed);
    for (const int segments : kFewAndMany) {
      for (const NormalMode normals : {NormalMode::kFacet, NormalMode::kSmooth}) {
        SCOPED_TRACE(fmt::format("degree {}, {} segments, normals {}, seed {}",
                                 fmt::join(options.degree, " "), segments,
                                 static_cast<int>(normals), kSeed));
        CompareFormats({.segments = segments, .normals = normals}, stride);
        if (HasFatalFailure()) return;
      }
    }
  }

 private:
  void CompareFormats(const ViewSpec& usual, size_t stride) {
    const Definition definition(*plan_, points_, usual.segments, usual.normals, stride);
    ViewSpec floats = usual, finest = usual;
    floats.format = VertexFormat::kFloat32;
    finest.position_bits = 16, finest.normal_bits = 12;
    for (const ViewSpec& spec : {floats, usual, finest}) {
      SCOPED_TRACE(
          fmt::format("{} bits", spec.format == VertexFormat::kFloat32 ? 32 : spec.position_bits));
      Compare(definition, spec);
      if (HasFatalFailure()) return;
    }
  }

  std::vector<Evaluated> EvaluateBy(Backend& backend, const ViewSpec& spec) {
    std::vector<Evaluated> all;
    for (const Pipeline pipeline : kPipelines) {
      all.push_back({std::string(backend.name()), pipeline,
                     EvaluateAll(backend, pipeline, plan_, points_, spec)});
    }
    return all;
  }

  void Compare(const Definition& definition, const ViewSpec& spec) {
    const auto theirs = EvaluateBy(*backend_, spec), ours = EvaluateBy(*cpu_, spec);
    const double step = BoxFor(*plan_, points_).step(spec.position_bits);
    const size_t q = definition.points_per_patch(), points = plan_->patches.size() * q;
    for (const auto* all : {&theirs, &ours}) {
      for (const Evaluated& e : *all) {
        ASSERT_EQ(e.vertices.positions.size() + e.vertices.integers.size(), points);
      }
    }
    for (size_t at = 0; at < points; ++at) {
      const size_t patch = at / q;
      if (patch % definition.stride() != 0) continue;
      const auto tolerance = [&](Pipeline pipeline) -> Distance {
        return {PositionTolerance(pipeline) * definition.scale(),
                definition.NormalTolerance(pipeline, patch, at % q)};
      };
      const Distance fused = tolerance(Pipeline::kFused), gemm = tolerance(Pipeline::kGemm);
      for (const Evaluated& a : theirs) {
        for (const Evaluated& b : ours) {
          const Distance& of_a = a.pipeline == Pipeline::kFused ? fused : gemm;
          const Distance& of_b = b.pipeline == Pipeline::kFused ? fused : gemm;
          const Distance apart =
              spec.format == VertexFormat::kFloat32
                  ? BetweenFloats(a.vertices, b.vertices, at)
                  : BetweenIntegers(a.vertices, b.vertices, at, step, spec.normal_bits);
          ASSERT_LE(apart.position, of_a.position + of_b.position) << Name(a, b, patch, at % q);
          ASSERT_LE(apart.normal, of_a.normal + of_b.normal) << Name(a, b, patch, at % q);
        }
      }
    }
  }

  static std::string Name(const Evaluated& a, const Evaluated& b, size_t patch, size_t point) {
    return fmt::format("{} {} and {} {}, patch {}, point {}", a.backend, PipelineName(a.pipeline),
                       b.backend, PipelineName(b.pipeline), patch, point);
  }

  std::unique_ptr<Backend> cpu_, backend_;
  Plan plan_;
  std::vector<Vec3d> points_;
};

TEST_P(Agreement, SmallScenesAgreeWithTheCpu) {
  Check(TorusMesh(9, 6), {.degree = {2, 2, 2}});
  Check(TorusMesh(9, 6), {.degree = {3, 3, 3}});
  Check(TorusMesh(9, 6), {.degree = {1, 2, 3}, .scale = 0.8});
}

TEST_P(Agreement, ARealMeshAgreesWithTheCpu) {
  std::vector<RealMesh> meshes = RealMeshes();
  if (meshes.empty()) GTEST_SKIP() << "no meshes in $LATTICED_SHARED/models";
  const auto least = std::ranges::min_element(
      meshes, {}, [](const RealMesh& m) { return m.mesh.positions.size(); });
  SCOPED_TRACE(least->name);
  Check(std::move(least->mesh), {.extra = {3, 3, 3}}, 29);
}

INSTANTIATE_TEST_SUITE_P(Backends, Agreement, ::testing::ValuesIn(KnownBackends()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
