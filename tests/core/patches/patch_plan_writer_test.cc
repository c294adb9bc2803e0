// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Written plans, read back, against the plans that they come from.
#include "core/patches/patch_plan_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numeric>
#include <random>
#include <set>

#include "core/codec/octahedral.h"
#include "core/patches/edge_order.h"
#include "core/patches/patch_plan_reader.h"
#include "tests/support/real_meshes.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

constexpr RestNormals kEveryKind[] = {RestNormals::kNone, RestNormals::kFacet,
                                      RestNormals::kSmooth};

std::shared_ptr<const DeformPlan> PlanOf(const PolygonMesh& mesh,
                                         const LatticeStructure& structure) {
  auto plan = MakePlan(std::make_shared<PolygonMesh>(mesh), structure);
  EXPECT_OK(plan.status());
  return *plan;
}

struct Written {
  PatchPlan plan;
  size_t bytes = 0;
};

Written WriteAndRead(std::shared_ptr<const DeformPlan> plan, RestNormals normals) {
  auto writer = PatchPlanWriter::Create(plan, normals);
  EXPECT_OK(writer.status());
  PatchPlanReader reader(writer->header());
  Written written;
  for (auto run = writer->NextRun(); run.value().has_value(); run = writer->NextRun()) {
    EXPECT_OK(reader.Add(**run));
    written.bytes += (*run)->data.size();
  }
  for (auto seams = writer->NextSeams(); seams.has_value(); seams = writer->NextSeams()) {
    EXPECT_OK(reader.Add(*seams));
  }
  auto read = reader.Finish();
  EXPECT_OK(read.status());
  written.plan = *std::move(read);
  return written;
}

// Each vertex within half a unit of where the plan has it, and exactly on the knots.
void ExpectPlaces(const DeformPlan& plan, const PatchPlan& read) {
  const KnotPlanes planes(plan.structure);
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    const Patch& patch = plan.patches[p];
    if (patch.box == plan.outside_box()) continue;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<size_t>(a);
      uint64_t sum = 0;
      for (const uint32_t v : read.patches[p].vertex) sum += read.places[v][axis];
      const uint32_t span = SpanOfPatch(sum);
      const KnotBox& box = plan.boxes[patch.box];
      for (size_t c = 0; c < 3; ++c) {
        const double parameter = plan.vertices[patch.vertex[c]].parameter[a];
        const uint32_t place = read.places[read.patches[p].vertex[c]][axis];
        if (planes.knot_span(a, span) != box.span[axis]) {
          // Rounded to the plane below, the patch is evaluated from there.
          EXPECT_EQ(place, kPlacesPerSpan * (span + 1)) << "patch " << p;
          EXPECT_LT(parameter - box.lower[a], (box.upper[a] - box.lower[a]) / kPlacesPerSpan);
          continue;
        }
        const double fraction = (parameter - box.lower[a]) / (box.upper[a] - box.lower[a]);
        const double local = double(place) - double(kPlacesPerSpan) * span;
        ASSERT_NEAR(local, fraction * kPlacesPerSpan, 0.5 + 1e-6) << "patch " << p << " axis " << a;
        if (parameter == box.lower[a] || parameter == box.upper[a]) {
          EXPECT_EQ(local, fraction * kPlacesPerSpan);
        }
      }
    }
  }
}

void ExpectSameTopology(const DeformPlan& plan, const PatchPlan& read) {
  ASSERT_EQ(read.patches.size(), plan.patches.size());
  std::vector<uint32_t> vertex_of(read.places.size(), kNoIndex);
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    EXPECT_EQ(read.patches[p].edge, plan.patches[p].edge);
    for (size_t c = 0; c < 3; ++c) {
      uint32_t& vertex = vertex_of[read.patches[p].vertex[c]];
      if (vertex == kNoIndex) vertex = plan.patches[p].vertex[c];
      ASSERT_EQ(vertex, plan.patches[p].vertex[c]) << "patch " << p;
    }
  }
  EXPECT_EQ(std::set<uint32_t>(vertex_of.begin(), vertex_of.end()).size(), vertex_of.size());
}

void ExpectNormals(const DeformPlan& plan, const PatchPlan& read) {
  const DirectFfd direct(plan, plan.identity_points);
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    for (size_t c = 0; c < 3 && read.header.normals != RestNormals::kNone; ++c) {
      const Vec3d rest = ToDouble(read.rest_normals[read.patches[p].normal[c]]);
      std::array<double, 3> corner{};
      corner[c] = 1;
      if (read.header.normals == RestNormals::kFacet) {
        EXPECT_LT(Norm(Cross(rest, direct.RestFacetNormal(p))), 6e-5);
        EXPECT_GT(Dot(rest, direct.RestFacetNormal(p)), 0);
      } else {
        EXPECT_LT(Norm(rest - direct.RestSmoothNormal(p, corner)), 0.87 / kRestNormalUnit + 1e-7);
      }
    }
  }
}

void ExpectSeams(const DeformPlan& plan, const PatchPlan& read) {
  ASSERT_EQ(read.seam_ranges.size(), plan.seams.size());
  if (plan.seams.empty()) return;
  for (size_t s = 0; s < plan.seams.size(); ++s) {
    for (size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(read.seam_ranges[s][2 * a], uint32_t(plan.seams[s].first[a]));
      EXPECT_EQ(read.seam_ranges[s][2 * a + 1], uint32_t(plan.seams[s].last[a]));
    }
  }
  const Vec3d lower = read.header.outside_lower, extent = read.header.outside_upper - lower;
  for (size_t p = 0; p < plan.patches.size(); ++p) {
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(read.edge_seams[read.patches[p].edge[c]], plan.edges[plan.patches[p].edge[c]].seam);
      const PlanVertex& vertex = plan.vertices[plan.patches[p].vertex[c]];
      const uint32_t number = read.patches[p].vertex[c];
      ASSERT_EQ(read.vertex_seams[number], vertex.seam);
      const bool outside = plan.patches[p].box == plan.outside_box();
      if (vertex.seam == kNoIndex && !outside) continue;
      const Places& places =
          vertex.seam != kNoIndex ? read.outside_places[number] : read.places[number];
      for (int a = 0; a < 3; ++a) {
        const double world = lower[a] + extent[a] * places[size_t(a)] / kPlacesPerSpan;
        EXPECT_NEAR(world, vertex.world[a], 0.501 * extent[a] / kPlacesPerSpan);
      }
    }
  }
  EXPECT_EQ(read.identity_points, plan.identity_points);
}

TEST(PatchPlanWriter, ReadsBackRandomPlans) {
  size_t outside = 0, seams = 0;
  for (uint32_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const testing::RandomCase random = testing::DrawCase(seed);
    const auto plan =
        PlanOf(random.mesh, testing::MakeStructure(random.mesh.ComputeBounds(), random.options));
    const PatchPlan read = WriteAndRead(plan, kEveryKind[seed % 3]).plan;
    ExpectSameTopology(*plan, read);
    ExpectPlaces(*plan, read);
    ExpectNormals(*plan, read);
    ExpectSeams(*plan, read);
    outside += plan->outside_patches;
    seams += plan->seams.size();
  }
  EXPECT_GT(outside, 1000u);
  EXPECT_GT(seams, 100u);
}

// The outside box has a width where the outside pieces have none.
// By vertex of the plan: of each patch's corners. A gradient is that of the source triangle, not of the patch's rounded places.
TEST(PatchPlanWriter, ReadsBackWeights) {
  constexpr uint32_t kSeed = 5;
  const PolygonMesh mesh = testing::TorusMesh(12, 7);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> weight(0, 1);
  auto weights = std::make_shared<std::vector<float>>(mesh.positions.size());
  for (float& w : *weights) w = weight(random);
  const LatticeStructure structure = testing::MakeStructure(mesh.ComputeBounds(), {.scale = 0.8});
  const auto plan =
      MakePlan(std::make_shared<PolygonMesh>(mesh), structure, {}, NeverStop, weights);
  ASSERT_OK(plan);
  ASSERT_GT((*plan)->outside_patches, 0u);
  for (const RestNormals normals : kEveryKind) {
    const PatchPlan read = WriteAndRead(*plan, normals).plan;
    ASSERT_TRUE(read.header.weighted);
    ASSERT_EQ(read.weights.size(), read.places.size());
    ASSERT_EQ(read.slopes.size(), normals == RestNormals::kNone ? 0 : read.patches.size());
    for (size_t p = 0; p < read.patches.size(); ++p) {
      const auto corners = (*plan)->CornerWeights(p);
      for (size_t c = 0; c < 3; ++c) {
        const double told = read.weights[read.patches[p].vertex[c]] / kWeightUnit;
        ASSERT_NEAR(told, corners[c], 0.5 / kWeightUnit + 1e-12) << "patch " << p;
      }
      if (read.slopes.empty()) continue;
      ASSERT_EQ(read.slopes[p], ToFloat((*plan)->PatchWeightGradient(p))) << "patch " << p;
    }
  }
  const PatchPlan unweighted = WriteAndRead(PlanOf(mesh, structure), RestNormals::kFacet).plan;
  EXPECT_FALSE(unweighted.header.weighted);
  EXPECT_TRUE(unweighted.weights.empty() && unweighted.slopes.empty());
}

TEST(PatchPlanWriter, WidensFlatOutsideBoxes) {
  const PolygonMesh mesh = testing::FlatGrid(4, 0.25);
  const auto plan = PlanOf(
      mesh, testing::MakeStructure(mesh.ComputeBounds(), {.scale = 0.5, .shift = {0.5, 0, 0}}));
  ASSERT_GT(plan->outside_patches, 0u);

  const PatchPlan read = WriteAndRead(plan, RestNormals::kFacet).plan;

  EXPECT_EQ(read.header.outside_upper.z, 1.25);
  ExpectSeams(*plan, read);
}

TEST(PatchPlanWriter, RunsDoNotMixInsideAndOutside) {
  const PolygonMesh mesh = testing::TorusMesh(80, 60);
  const auto plan = PlanOf(mesh, testing::MakeStructure(mesh.ComputeBounds(), {.scale = 0.7}));
  auto writer = PatchPlanWriter::Create(plan, RestNormals::kNone);
  const uint64_t inside = plan->patches.size() - plan->outside_patches;
  ASSERT_GT(inside, 4096u);

  std::vector<uint64_t> ends;
  for (auto run = writer->NextRun(); run.value().has_value(); run = writer->NextRun()) {
    EXPECT_LE((*run)->patches, 4096u);
    ends.push_back((*run)->first_patch + (*run)->patches);
  }

  EXPECT_EQ(std::count(ends.begin(), ends.end(), inside), 1);
  EXPECT_EQ(ends.back(), plan->patches.size());
}

// Walls across the squares of a lattice's face: each square that a wall crosses has seams of its own.
PolygonMesh Walls(int count) {
  PolygonMesh mesh;
  for (int i = 0; i < count; ++i) {
    const double x = (i + 0.5) / count;
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const double y : {0.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) mesh.positions.push_back({x, y, z});
    }
    for (const uint32_t v : {0u, 1u, 3u, 2u}) mesh.corner_vertices.push_back(first + v);
    mesh.face_offsets.push_back(static_cast<uint32_t>(mesh.corner_vertices.size()));
  }
  return mesh;
}

TEST(PatchPlanWriter, ManySeamsAreSeveralMessages) {
  const PolygonMesh mesh = Walls(100);
  Bounds upper;
  upper.Extend(Vec3d{0, 0, 0});
  upper.Extend(Vec3d{1, 1, 1});
  const auto lattice = FitLattice(upper, {101, 101, 2}, {1, 1, 1}, 0);
  const auto plan = PlanOf(mesh, lattice->structure);
  ASSERT_GT(plan->seams.size(), 16'384u);
  auto writer = PatchPlanWriter::Create(plan, RestNormals::kNone);
  while (writer->NextRun().value().has_value()) continue;

  std::vector<size_t> ranges;
  for (auto seams = writer->NextSeams(); seams.has_value(); seams = writer->NextSeams()) {
    ranges.push_back(seams->ranges.size() / 6);
    EXPECT_LE(seams->vertices.size(), 16'384u);
    EXPECT_LE(seams->edges.size(), 16'384u);
  }

  EXPECT_EQ(ranges[0], 16'384u);
  EXPECT_EQ(std::accumulate(ranges.begin(), ranges.end(), size_t{0}), plan->seams.size());
  ExpectSeams(*plan, WriteAndRead(plan, RestNormals::kNone).plan);
}

TEST(PatchPlanWriter, StopsWhenToldTo) {
  const PolygonMesh mesh = testing::TorusMesh(80, 60);
  const auto plan = PlanOf(mesh, testing::MakeStructure(mesh.ComputeBounds(), {}));

  const auto stop = [] { return absl::CancelledError("gone"); };

  EXPECT_THAT(PatchPlanWriter::Create(plan, RestNormals::kFacet, stop).status(),
              testing::StatusIs(absl::StatusCode::kCancelled));
}

// What issue and proto promise.
TEST(PatchPlanWriter, RealMeshesTakeAtMostTwelveBytesAPatch) {
  constexpr double kMostBytes = 12;
  const std::vector<testing::RealMesh> meshes = testing::RealMeshes();
  if (meshes.empty()) GTEST_SKIP() << "no meshes in $LATTICED_SHARED/models";
  for (const testing::RealMesh& real : meshes) {
    for (const int size : {4, 8}) {
      const auto lattice =
          FitLattice(real.mesh.ComputeBounds(), {size, size, size}, {2, 2, 2}, 0.05);
      const auto plan = PlanOf(real.mesh, lattice->structure);
      for (const RestNormals normals : kEveryKind) {
        const Written written = WriteAndRead(plan, normals);
        const double bytes = double(written.bytes) / double(plan->patches.size());
        EXPECT_LE(bytes, kMostBytes) << real.name << " " << size;
        std::cout << real.name << " " << size << "^3, " << plan->patches.size() << " patches, "
                  << RestNormalsPerPatch(normals) << " normals a patch: " << bytes
                  << " bytes a patch\n";
      }
    }
  }
}

}  // namespace
}  // namespace latticed
