// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Chunks that no edit has reached since a revision have the bytes and patterns of that revision in a view that is made
// anew, in every kind of view, after any edits.
#include "server/engine/render/chunk_revisions.h"

#include <memory>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/cpu/cpu_backend.h"
#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeeds = 16, kRevisions = 12;

struct Kind {
  const char* name;
  Encoding encoding;
  double tolerance;  // of the box's range
  int segments;
};
constexpr Kind kKindsOfViews[] = {{"uniform", Encoding::kQuantised, 0, 3},
                                  {"a tolerance", Encoding::kQuantised, 2e-3, 32},
                                  {"too many points for it", Encoding::kQuantised, 1e-5, 3},
                                  {"bounds", Encoding::kPatches, 0, 3}};

class ChunkRevisionsTest : public ::testing::Test {
 protected:
  struct Surface {
    std::vector<std::vector<uint8_t>> chunks;
    std::vector<std::vector<uint16_t>> patterns;
    double curvature_tolerance = 0;
    bool SameChunk(const Surface& other, size_t chunk) const {
      return chunks[chunk] == other.chunks[chunk] && patterns[chunk] == other.patterns[chunk];
    }
  };

  void Prepare(uint32_t seed) {
    RandomCase drawn = DrawCase(seed);
    structure_ = MakeStructure(drawn.mesh.ComputeBounds(), drawn.options);
    ASSERT_OK_AND_ASSIGN(
        plan_, MakePlan(std::make_shared<const PolygonMesh>(std::move(drawn.mesh)), structure_));
    ASSERT_OK_AND_ASSIGN(target_, backend_->Prepare(plan_, Pipeline::kFused));
    Bounds bounds = plan_->outside_bounds;
    for (const Vec3d& p : Jitter(structure_, 0.8, seed)) bounds.Extend(p);
    box_ = FitQuantisationBox(bounds, 1);
  }
  // What a new view of these control points has.
  Surface Evaluated(const std::vector<Vec3d>& points, const Kind& kind) {
    std::vector<uint32_t> all(plan_->chunk_count());
    std::iota(all.begin(), all.end(), 0u);
    Surface surface;
    auto view = target_->CreateView(SpecOf(kind));
    EXPECT_OK(view);
    EXPECT_OK((*view)->Evaluate(points, box_, all));
    const auto encoded = (*view)->Encode(all, kind.encoding);
    EXPECT_OK(encoded);
    for (const uint32_t chunk : all) {
      const auto bytes = (*encoded)[chunk].span();
      const auto patterns = (*view)->Patterns().OfChunk(chunk);
      surface.chunks.emplace_back(bytes.begin(), bytes.end());
      surface.patterns.emplace_back(patterns.begin(), patterns.end());
    }
    surface.curvature_tolerance = (*view)->curvature_tolerance();
    return surface;
  }
  ViewSpec SpecOf(const Kind& kind) const {
    return {.segments = kind.segments,
            .tolerance = kind.tolerance * box_.range,
            .format = FormatOf(kind.encoding),
            .position_bits = 16};
  }
  // Moves one or two points, some of them back to their places at rest.
  std::vector<uint32_t> Move(std::mt19937& random, std::vector<Vec3d>& points) const {
    std::uniform_real_distribution<double> noise(-0.05 * box_.range, 0.05 * box_.range);
    std::vector<uint32_t> moved;
    for (uint64_t count = 1 + random() % 2; count > 0; --count) {
      const auto index = static_cast<uint32_t>(random() % points.size());
      points[index] = random() % 4 == 0
                          ? plan_->identity_points[index]
                          : points[index] + Vec3d{noise(random), noise(random), noise(random)};
      moved.push_back(index);
    }
    return moved;
  }

  const std::unique_ptr<Backend> backend_ = MakeCpuBackend({.threads = 1});
  LatticeStructure structure_;
  std::shared_ptr<const DeformPlan> plan_;
  std::shared_ptr<DeformTarget> target_;
  QuantisationBox box_;
};

TEST_F(ChunkRevisionsTest, ChunksThatNoEditReachedAreTheSameBits) {
  for (const Kind& kind : kKindsOfViews) {
    size_t same = 0, doubled_otherwise = 0, changed_by_doubling = 0;
    for (uint32_t seed = 0; seed < kSeeds; ++seed) {
      SCOPED_TRACE(fmt::format("{}, seed {}", kind.name, seed));
      ASSERT_NO_FATAL_FAILURE(Prepare(seed));
      std::mt19937 random(seed);
      std::vector<Vec3d> points = Jitter(structure_, 0.1, seed);
      PointRevisions moved(points.size(), 0);
      std::vector<Surface> surfaces = {Evaluated(points, kind)};
      for (uint64_t now = 1; now < kRevisions; ++now) {
        moved.Move(Move(random, points), now);
        surfaces.push_back(Evaluated(points, kind));
        const auto revisions = ChunkRevisions(*plan_, moved, SpecOf(kind));
        for (uint64_t had = 0; had < now; ++had) {
          const bool comparable =
              surfaces[had].curvature_tolerance == surfaces[now].curvature_tolerance;
          doubled_otherwise += comparable ? 0 : 1;
          for (size_t chunk = 0; chunk < revisions.size(); ++chunk) {
            if (revisions[chunk] > had) continue;
            const bool is_same = surfaces[now].SameChunk(surfaces[had], chunk);
            if (comparable) {
              ASSERT_TRUE(is_same) << "chunk " << chunk << ", revisions " << had << ", " << now;
            }
            same += is_same ? 1 : 0;
            changed_by_doubling += is_same ? 0 : 1;
          }
        }
      }
    }
    EXPECT_GT(same, 0u) << kind.name;
    const bool doubles = kind.tolerance > 0 && kind.segments < 32;
    EXPECT_EQ(doubled_otherwise > 0, doubles) << kind.name;
    EXPECT_EQ(changed_by_doubling > 0, doubles) << kind.name;
  }
}

// Neither is a chunk counted that the edits of a live view would not mark. Every second plan has a turned lattice too.
TEST_F(ChunkRevisionsTest, OfPositionsAreThoseThatEditsMark) {
  for (uint32_t seed = 0; seed < 2 * kSeeds; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    ASSERT_NO_FATAL_FAILURE(Prepare(seed / 2));
    if (seed % 2 == 1) {
      const std::array turned{MakeStructure(plan_->mesh->ComputeBounds(),
                                            {.extra = {3, 2, 4}, .scale = 0.8, .turn = 0.6})};
      ASSERT_OK_AND_ASSIGN(plan_,
                           MakePlan(plan_->mesh, structure_, {}, NeverStop, nullptr, turned));
    }
    std::mt19937 random(seed);
    std::vector<Vec3d> points = plan_->identity_points;
    PointRevisions moved(points.size(), 5);
    std::vector<uint64_t> expected(plan_->chunk_count(), 5);
    for (uint64_t now = 6; now < 5 + kRevisions; ++now) {
      const std::vector<uint32_t> indices = Move(random, points);
      moved.Move(indices, now);
      for (const uint32_t chunk : DirtyByControlPoints(*plan_, indices).chunks) {
        expected[chunk] = now;
      }
      EXPECT_EQ(ChunkRevisions(*plan_, moved, SpecOf(kKindsOfViews[0])), expected);
    }
  }
}

}  // namespace
}  // namespace latticed::testing
