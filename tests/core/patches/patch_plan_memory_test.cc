// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A writer of plans takes no more memory than it says. This program counts allocations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/patches/patch_plan_writer.h"
#include "fmt/format.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

constexpr size_t kRunBytes = size_t{2} << 20;  // more than the arrays of a run take

// Triangles that share no vertex.
PolygonMesh Soup(const PolygonMesh& of) {
  PolygonMesh soup = of;
  soup.positions.clear();
  soup.normals.clear();
  soup.corner_normals.clear();
  for (const uint32_t v : of.corner_vertices) soup.positions.push_back(of.positions[v]);
  for (size_t c = 0; c < soup.corner_vertices.size(); ++c) {
    soup.corner_vertices[c] = static_cast<uint32_t>(c);
  }
  return soup;
}

// A cone of thin triangles that begin at its apex, each with another normal.
PolygonMesh Cone(uint32_t triangles) {
  PolygonMesh mesh;
  mesh.positions.push_back({0, 0, 1});
  for (uint32_t i = 0; i < triangles; ++i) {
    const double angle = 6.283185307179586 * i / triangles;
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 0});
    for (const uint32_t v : {0u, 1 + i, 1 + (i + 1) % triangles}) mesh.corner_vertices.push_back(v);
    mesh.face_offsets.push_back(static_cast<uint32_t>(mesh.corner_vertices.size()));
  }
  return mesh;
}

void ExpectBounded(const std::string& name, const PolygonMesh& mesh, double shift,
                   const VertexWeights& weights = nullptr) {
  const auto plan = MakePlan(std::make_shared<PolygonMesh>(mesh),
                             testing::MakeStructure(mesh.ComputeBounds(), {.shift = {shift, 0, 0}}),
                             {}, NeverStop, weights)
                        .value();
  for (const RestNormals normals :
       {RestNormals::kNone, RestNormals::kFacet, RestNormals::kSmooth}) {
    const uint64_t asked = PatchPlanWriter::MostBytes(*plan, normals);
    const size_t before = allocated_bytes;
    const testing::PeakMemory creation;
    auto writer = PatchPlanWriter::Create(plan, normals);
    ASSERT_OK(writer.status());
    const size_t creation_peak = creation.peak(), held = allocated_bytes - before;
    const testing::PeakMemory writing;
    size_t largest = 0;
    for (auto run = writer->NextRun(); run.value().has_value(); run = writer->NextRun()) {
      largest = std::max(largest, (*run)->data.capacity());
    }
    while (writer->NextSeams().has_value()) continue;
    const size_t writing_peak = held + writing.peak();
    fmt::print("{:>6}, {} normals a patch: {:>8} bytes of {:>8}, then {:>8} of {:>8}\n", name,
               RestNormalsPerPatch(normals), creation_peak, asked, writing_peak,
               writer->MemoryBytes());

    EXPECT_LE(creation_peak, asked) << name;
    EXPECT_LE(writing_peak, writer->MemoryBytes() + largest) << name;
    EXPECT_LE(writer->MemoryBytes(), asked) << name;
    EXPECT_LE(asked, 2 * creation_peak + kRunBytes) << name;
    EXPECT_LE(writer->MemoryBytes(), 2 * writing_peak + kRunBytes) << name;
  }
}

TEST(PatchPlanMemory, IsWhatTheWriterSays) {
  const PolygonMesh torus = testing::TorusMesh(160, 120);
  ExpectBounded("torus", torus, 0.3);
  ExpectBounded("soup", Soup(torus), 0);
  const PolygonMesh soup = Soup(torus);
  auto weights = std::make_shared<std::vector<float>>(soup.positions.size());
  for (size_t i = 0; i < weights->size(); ++i) (*weights)[i] = static_cast<float>(i % 11) / 10;
  ExpectBounded("weighted soup", soup, 0, weights);
  ExpectBounded("cone", Cone(30'000), 0);
}

}  // namespace
}  // namespace latticed
