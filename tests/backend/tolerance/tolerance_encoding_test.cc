// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Draco streams of views with a tolerance: wherever a backend writes them, they are those of the host's writer for the same
// integers, they change with these alone, and a caller who has them gets nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/codec/draco_writer.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/holds_integers.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kEncodedSeed = 2022;

struct EncodedScene {
  std::string_view name;
  PolygonMesh mesh;
  LatticeOptions options;
};

std::vector<EncodedScene> EncodedScenes() {
  return {
      {"many boxes", TorusMesh(30, 20), {.degree = {1, 1, 1}, .extra = {6, 6, 6}}},
      {"partly outside", TorusMesh(9, 7), {.degree = {2, 1, 3}, .scale = 0.7}},
      {"unconnected, slivers",
       TriangleSoup(140, kEncodedSeed),
       {.degree = {1, 1, 2}, .extra = {4, 4, 4}}},
      {"cubic", TorusMesh(9, 7), {.degree = {3, 3, 3}, .extra = {1, 1, 1}}},
      {"one triangle", TriangleSoup(1, kEncodedSeed), {.degree = {1, 1, 1}, .scale = 2.0}},
  };
}

class ToleranceEncoding : public BackendTest {
 protected:
  // The control point that moves the most chunks, but less than half of them.
  static uint32_t PointOfSomeChunks(const Plan& plan) {
    uint32_t best = 0;
    size_t most = 0;
    for (uint32_t i = 0; i < plan->identity_points.size(); ++i) {
      const size_t reached = DirtyByControlPoints(*plan, {{i}}).chunks.size();
      if (reached > most && 2 * reached < plan->chunk_count()) best = i, most = reached;
    }
    return best;
  }

  // The integers of a chunk; `bytes` holds them.
  static QuantisedVertices IntegersOf(const DeformPlan& plan, DeformView& view, uint32_t chunk,
                                      std::vector<uint8_t>& bytes) {
    const ViewSpec& spec = view.spec();
    const size_t points = ChunkPoints(view, plan, chunk);
    bytes.resize(points * BytesPerPoint(spec));
    EXPECT_OK(view.Read(chunk, bytes));
    QuantisedVertices vertices =
        QuantisedVertices::FromBytes(bytes, points, spec.position_bits,
                                     spec.normals == NormalMode::kNone ? 0 : spec.normal_bits);
    vertices.is_sparse = true;
    return vertices;
  }

  // Compares a stream with that of the host's writer, and asks libdraco for the integers.
  static void ExpectTheHostsStream(const DeformPlan& plan, DeformView& view, double range,
                                   uint32_t chunk, std::span<const uint8_t> stream) {
    std::vector<uint8_t> bytes;
    const QuantisedVertices vertices = IntegersOf(plan, view, chunk, bytes);
    ASSERT_OK_AND_ASSIGN(const auto expected, EncodePoints(DracoWriter(), vertices, range));
    EXPECT_TRUE(std::ranges::equal(stream, expected))
        << "chunk " << chunk << " of " << vertices.point_count << " points: " << stream.size()
        << " bytes for " << expected.size();
    EXPECT_TRUE(HoldsIntegers(stream, vertices)) << "chunk " << chunk;
  }
};

TEST_P(ToleranceEncoding, StreamsAreThoseOfTheHostsWriter) {
  size_t fewest = SIZE_MAX, most = 0;  // points of a chunk
  for (EncodedScene& one : EncodedScenes()) {
    const LatticeStructure structure = MakeStructure(one.mesh.ComputeBounds(), one.options);
    const Plan plan = MakeTestPlan(std::move(one.mesh), structure);
    const std::vector<Vec3d> points = Jitter(structure, 0.2, kEncodedSeed);
    const QuantisationBox box = BoxFor(*plan, points);
    for (const double share : {1.0, 1e-3, 2e-5}) {
      for (const auto& [position_bits, normal_bits] :
           {std::pair(12, 0), {12, 8}, {14, 8}, {16, 0}, {16, 10}}) {
        SCOPED_TRACE(fmt::format("{}, {} of the box, {} and {} bits, seed {}", one.name, share,
                                 position_bits, normal_bits, kEncodedSeed));
        ViewSpec spec{.segments = 32, .tolerance = share * box.range};
        spec.position_bits = position_bits;
        spec.normals = normal_bits == 0 ? NormalMode::kNone : NormalMode::kFacet;
        if (normal_bits > 0) spec.normal_bits = normal_bits;
        const auto view = MakeView(plan, spec);
        ASSERT_NE(view, nullptr);
        const auto all = AllChunks(*plan);
        ASSERT_OK(view->Evaluate(points, box, all));

        ASSERT_OK_AND_ASSIGN(const auto streams, view->Encode(all, Encoding::kDracoPoints));
        ASSERT_OK_AND_ASSIGN(const auto meshopt, view->Encode(all, Encoding::kMeshopt));

        for (const uint32_t chunk : all) {
          ExpectTheHostsStream(*plan, *view, box.range, chunk, streams[chunk].span());
          std::vector<uint8_t> bytes;
          EXPECT_TRUE(std::ranges::equal(meshopt[chunk].span(),
                                         EncodeMeshopt(IntegersOf(*plan, *view, chunk, bytes))));
          fewest = std::min(fewest, ChunkPoints(*view, *plan, chunk));
          most = std::max(most, ChunkPoints(*view, *plan, chunk));
        }
        if (HasFailure()) return;
      }
    }
  }
  EXPECT_LT(fewest, 10u);
  EXPECT_GT(most, 2000u);  // the device has another kernel for chunks of many points
}

// As a server does it: an edit's dirty chunks, and those that it changed besides, with the digests of what a watcher has.
TEST_P(ToleranceEncoding, StreamsAfterAnyEditsAreThoseOfTheHostsWriter) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  for (EncodedScene& one : EncodedScenes()) {
    const LatticeStructure structure = MakeStructure(one.mesh.ComputeBounds(), one.options);
    const Plan plan = MakeTestPlan(std::move(one.mesh), structure);
    const QuantisationBox box = BoxFor(*plan, Jitter(structure, 0.8, kEncodedSeed));
    const ViewSpec spec{.segments = 32, .tolerance = 1e-4 * box.range, .position_bits = 15};
    const auto view = MakeView(plan, spec);
    ASSERT_NE(view, nullptr);
    const auto all = AllChunks(*plan);
    std::vector<Vec3d> points = IdentityControlPoints(structure);
    ASSERT_OK(view->Evaluate(points, box, all));
    std::vector<VertexDigest> known(all.size());
    ASSERT_OK_AND_ASSIGN(auto streams, view->Encode(all, Encoding::kDracoPoints, known));
    std::mt19937 random(kEncodedSeed);
    for (int edit = 0; edit < 20; ++edit) {
      SCOPED_TRACE(fmt::format("{}: edit {}, seed {}", one.name, edit, kEncodedSeed));
      const auto index = static_cast<uint32_t>(random() % points.size());
      points[index] =
          plan->identity_points[index] + Vec3d{noise(random), noise(random), noise(random)};
      std::vector<uint32_t> chunks = DirtyByControlPoints(*plan, {{index}}).chunks;
      ASSERT_OK(view->Evaluate(points, box, chunks));
      chunks.insert(chunks.end(), view->also_changed().begin(), view->also_changed().end());
      std::ranges::sort(chunks);
      std::vector<VertexDigest> digests;
      for (const uint32_t chunk : chunks) digests.push_back(known[chunk]);

      ASSERT_OK_AND_ASSIGN(auto news, view->Encode(chunks, Encoding::kDracoPoints, digests));

      for (size_t i = 0; i < chunks.size(); ++i) {
        known[chunks[i]] = digests[i];
        if (news[i].data != nullptr) streams[chunks[i]] = std::move(news[i]);
      }
      for (const uint32_t chunk : all) {
        ExpectTheHostsStream(*plan, *view, box.range, chunk, streams[chunk].span());
      }
      if (HasFailure()) return;
    }
  }
}

TEST_P(ToleranceEncoding, LeavesOutWhatTheCallerHasAndNothingElse) {
  PolygonMesh mesh = TorusMesh(30, 20);
  const LatticeStructure structure =
      MakeStructure(mesh.ComputeBounds(), {.degree = {1, 1, 1}, .extra = {6, 6, 6}});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  std::vector<Vec3d> points = Jitter(structure, 0.2, kEncodedSeed);
  const QuantisationBox box = BoxFor(*plan, Jitter(structure, 0.8, kEncodedSeed));
  const ViewSpec spec{.segments = 32, .tolerance = 1e-4 * box.range, .position_bits = 14};
  const auto view = MakeView(plan, spec);
  ASSERT_NE(view, nullptr);
  const auto all = AllChunks(*plan);
  ASSERT_OK(view->Evaluate(points, box, all));
  for (const Encoding encoding :
       {Encoding::kQuantised, Encoding::kDracoPoints, Encoding::kDracoMesh, Encoding::kMeshopt}) {
    std::vector<VertexDigest> digests(all.size());
    ASSERT_OK(view->Evaluate(points, box, all));
    ASSERT_OK_AND_ASSIGN(const auto old, view->Encode(all, encoding, digests));
    for (const SharedBytes& bytes : old) EXPECT_NE(bytes.data, nullptr);

    // All chunks are dirty, and nothing has changed.
    ASSERT_OK(view->Evaluate(points, box, all));
    ASSERT_OK_AND_ASSIGN(const auto again, view->Encode(all, encoding, digests));
    for (const SharedBytes& bytes : again) EXPECT_EQ(bytes.data, nullptr);

    std::vector<Vec3d> moved = points;
    moved[PointOfSomeChunks(plan)].z += 0.05;
    ASSERT_OK(view->Evaluate(moved, box, all));
    ASSERT_OK_AND_ASSIGN(const auto expected, view->Encode(all, encoding));
    ASSERT_OK_AND_ASSIGN(const auto news, view->Encode(all, encoding, digests));
    size_t left_out = 0;
    for (size_t c = 0; c < all.size(); ++c) {
      const bool same = news[c].data == nullptr;
      left_out += same ? 1 : 0;
      EXPECT_TRUE(std::ranges::equal(same ? old[c].span() : news[c].span(), expected[c].span()))
          << "chunk " << c;
    }
    EXPECT_GT(left_out, 0u);
    EXPECT_LT(left_out, all.size());
  }
}

TEST_P(ToleranceEncoding, NoChunksHaveNoStreams) {
  PolygonMesh mesh = TorusMesh(9, 7);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  const QuantisationBox box = BoxFor(*plan, plan->identity_points);
  const auto view = MakeView(plan, {.tolerance = 1e-3 * box.range});
  ASSERT_NE(view, nullptr);
  EXPECT_THAT(view->Encode({}, Encoding::kDracoPoints),
              StatusIs(absl::StatusCode::kFailedPrecondition));
  ASSERT_OK(view->Evaluate(plan->identity_points, box, AllChunks(*plan)));
  ASSERT_OK_AND_ASSIGN(const auto streams, view->Encode({}, Encoding::kDracoPoints));
  EXPECT_TRUE(streams.empty());
}

INSTANTIATE_TEST_SUITE_P(Backends, ToleranceEncoding,
                         ::testing::Values(Subject{"cpu", Pipeline::kFused},
                                           Subject{"cpu", Pipeline::kGemm},
                                           Subject{"cuda", Pipeline::kFused},
                                           Subject{"cuda", Pipeline::kGemm}),
                         SubjectName);

}  // namespace
}  // namespace latticed::testing
