// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The contract of targets and views: formats, encodings, control nets, refusals and memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/codec/chunk_encoder.h"
#include "core/codec/draco_decode.h"
#include "core/codec/meshopt/meshopt_writer.h"
#include "core/ffd/box/bernstein.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"
#include "tests/support/encode_chunk.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kViewSeed = 66;

class View : public BackendTest {
 protected:
  void SetUp() override {
    BackendTest::SetUp();
    PolygonMesh mesh = TorusMesh(8, 6);
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.scale = 0.9});
    plan_ = MakeTestPlan(std::move(mesh), structure);
    ASSERT_NE(plan_, nullptr);
    points_ = Jitter(structure, 0.05, kViewSeed);
    box_ = BoxFor(*plan_, points_);
  }

  std::unique_ptr<DeformView> Evaluated(const ViewSpec& spec) {
    auto view = MakeView(plan_, spec);
    if (view != nullptr) {
      EXPECT_OK(view->Evaluate(points_, box_, AllChunks(*plan_)));
    }
    return view;
  }

  Plan plan_;
  std::vector<Vec3d> points_;
  QuantisationBox box_;
};

TEST_P(View, IntegersAreTheFloatsRounded) {
  for (const int segments : kFewAndMany) {
    const auto exact =
        EvaluateAll(plan_, points_, {.segments = segments, .format = VertexFormat::kFloat32});
    for (const auto& [position_bits, normal_bits] : {std::pair{8, 6}, {11, 8}, {12, 9}, {16, 12}}) {
      SCOPED_TRACE(fmt::format("{} segments, {} bits", segments, position_bits));
      const ViewSpec spec{
          .segments = segments, .position_bits = position_bits, .normal_bits = normal_bits};

      const auto got = EvaluateAll(plan_, points_, spec);

      ASSERT_EQ(got.size(), exact.size());
      // Half a step, plus the error of float32 before rounding.
      const double tolerance = 0.5 * box_.step(position_bits) + 1e-6 * box_.range;
      for (size_t i = 0; i < got.size(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_NEAR(got[i].position[axis], exact[i].position[axis], tolerance);
        }
        ASSERT_LE(Norm(got[i].normal - exact[i].normal), RoundingOf(spec, box_).normal);
      }
    }
  }
}

TEST_P(View, RawAndQuantisedBytesAreWhatReadGives) {
  for (VertexFormat format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
    const auto view = Evaluated({.segments = 3, .format = format});
    ASSERT_NE(view, nullptr);
    const auto expected = ReadAll(*plan_, *view);
    const std::vector<uint32_t> chunks{static_cast<uint32_t>(plan_->chunk_count()) - 1, 0};

    ASSERT_OK_AND_ASSIGN(const auto got, view->Encode(chunks, format == VertexFormat::kFloat32
                                                                  ? Encoding::kRaw
                                                                  : Encoding::kQuantised));
    ASSERT_EQ(got.size(), 2u);
    for (size_t i = 0; i < 2; ++i) {
      const auto bytes = got[i].span();
      EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), expected[chunks[i]].begin(),
                             expected[chunks[i]].end()));
    }
  }
}

TEST_P(View, LeavesOutWhatTheCallerHasAndNothingElse) {
  for (const Encoding encoding :
       {Encoding::kQuantised, Encoding::kDracoPoints, Encoding::kDracoMesh, Encoding::kMeshopt}) {
    const auto view = Evaluated({.segments = 3});
    ASSERT_NE(view, nullptr);
    const auto all = AllChunks(*plan_);
    std::vector<VertexDigest> digests(all.size());
    ASSERT_OK_AND_ASSIGN(const auto old, view->Encode(all, encoding, digests));
    ASSERT_OK_AND_ASSIGN(const auto again, view->Encode(all, encoding, digests));
    for (const SharedBytes& bytes : again) EXPECT_EQ(bytes.data, nullptr);
    std::vector<Vec3d> moved = points_;
    moved[moved.size() / 2].z += 0.01;
    ASSERT_OK(view->Evaluate(moved, box_, all));
    ASSERT_OK_AND_ASSIGN(const auto expected, view->Encode(all, encoding));

    ASSERT_OK_AND_ASSIGN(const auto news, view->Encode(all, encoding, digests));
    size_t left_out = 0;
    for (size_t c = 0; c < all.size(); ++c) {
      const bool same = news[c].data == nullptr;
      left_out += same ? 1 : 0;
      const auto bytes = same ? old[c].span() : news[c].span();
      EXPECT_TRUE(std::ranges::equal(bytes, expected[c].span())) << "chunk " << c;
    }
    EXPECT_LT(left_out, all.size());
  }
}

TEST_P(View, MeshoptStreamsAreTheHostsOfTheIntegers) {
  for (const auto& [normals, normal_bits] :
       {std::pair(NormalMode::kNone, 8), {NormalMode::kFacet, 8}, {NormalMode::kSmooth, 10}}) {
    for (const int segments : {1, 4, 10}) {
      ViewSpec spec{.segments = segments, .normals = normals, .position_bits = 14};
      spec.normal_bits = normal_bits;
      const auto view = Evaluated(spec);
      ASSERT_NE(view, nullptr);
      const auto chunks = ReadAll(*plan_, *view);
      ASSERT_OK_AND_ASSIGN(const auto streams, view->Encode(AllChunks(*plan_), Encoding::kMeshopt));
      for (size_t c = 0; c < chunks.size(); ++c) {
        const auto vertices = QuantisedVertices::FromBytes(
            chunks[c], ChunkPoints(*plan_, c, segments), spec.position_bits,
            normals == NormalMode::kNone ? 0 : normal_bits);
        EXPECT_TRUE(std::ranges::equal(streams[c].span(), EncodeMeshopt(vertices)))
            << "chunk " << c << ", " << segments << " segments";
      }
    }
  }
}

TEST_P(View, DracoStreamsHoldTheIntegers) {
  for (NormalMode normals : {NormalMode::kNone, NormalMode::kFacet}) {
    const ViewSpec spec{.segments = 4, .normals = normals, .position_bits = 14};
    const auto view = Evaluated(spec);
    ASSERT_NE(view, nullptr);
    const auto chunks = ReadAll(*plan_, *view);
    for (Encoding encoding : {Encoding::kDracoPoints, Encoding::kDracoMesh}) {
      ASSERT_OK_AND_ASSIGN(const auto streams, view->Encode(AllChunks(*plan_), encoding));
      for (size_t c = 0; c < chunks.size(); ++c) {
        ASSERT_OK_AND_ASSIGN(const auto got, DecodeDracoChunkIntegers(streams[c].span()));
        const size_t points = ChunkPoints(*plan_, c, spec.segments);
        ASSERT_EQ(got.positions.size(), 3 * points);
        EXPECT_EQ(got.normals.size(), normals == NormalMode::kNone ? 0 : 2 * points);
        for (size_t i = 0; i < points; ++i) {
          for (size_t axis = 0; axis < 3; ++axis) {
            const size_t at = 2 * (axis * points + i);
            ASSERT_EQ(got.positions[3 * i + axis],
                      static_cast<uint32_t>(chunks[c][at] | chunks[c][at + 1] << 8));
          }
        }
      }
    }
  }
}

TEST_P(View, ControlNetsSpanTheDeformedPatches) {
  ASSERT_OK_AND_ASSIGN(auto target, backend_->Prepare(plan_, GetParam().pipeline));
  const int n = plan_->structure.patch_degree();
  const auto m = static_cast<size_t>(BernsteinCount(n));
  const DirectFfd direct(*plan_, points_);
  const size_t all = plan_->patches.size();
  for (const auto& [first, last] :
       {std::pair<size_t, size_t>{0, all}, {7, 9}, {all / 4, all - 3}, {all, all}}) {
    ASSERT_OK_AND_ASSIGN(const auto nets, target->ControlNets(points_, first, last));
    ASSERT_EQ(nets.size(), (last - first) * m * 3);
    for (size_t p = first; p < last; ++p) {
      for (const auto& b : {std::array{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.2, 0.3, 0.5}}) {
        const Vec3d sum = PointOfNet(nets.data() + (p - first) * 3 * m, n, b);
        ASSERT_LE(Norm(sum - direct.EvaluatePosition(p, b).position), 1e-12) << "patch " << p;
      }
    }
  }
}

TEST_P(View, ControlNetsOfWeightedPatchesHaveOneDegreeMore) {
  std::vector<float> weights;
  for (size_t v = 0; v < plan_->mesh->positions.size(); ++v) {
    weights.push_back(static_cast<float>(v % 5) / 4);
  }
  ASSERT_OK_AND_ASSIGN(const Plan plan,
                       MakePlan(plan_->mesh, plan_->structure, {}, NeverStop,
                                std::make_shared<const std::vector<float>>(std::move(weights))));
  ASSERT_OK_AND_ASSIGN(auto target, backend_->Prepare(plan, GetParam().pipeline));
  const int n = plan->structure.patch_degree() + 1;
  const auto m = static_cast<size_t>(BernsteinCount(n));
  const DirectFfd direct(*plan, points_);
  const size_t all = plan->patches.size();
  for (const auto& [first, last] : {std::pair<size_t, size_t>{0, all}, {all / 4, all - 3}}) {
    ASSERT_OK_AND_ASSIGN(const auto nets, target->ControlNets(points_, first, last));
    ASSERT_EQ(nets.size(), (last - first) * m * 3);
    for (size_t p = first; p < last; ++p) {
      for (const auto& b : {std::array{0.0, 1.0, 0.0}, {0.2, 0.3, 0.5}, {0.6, 0.1, 0.3}}) {
        const Vec3d sum = PointOfNet(nets.data() + (p - first) * 3 * m, n, b);
        ASSERT_LE(Norm(sum - direct.EvaluatePosition(p, b).position), 1e-12) << "patch " << p;
      }
    }
  }
}

// The bytes depend on the chunk alone.
TEST_P(View, StreamsAreOurWritersOfTheIntegers) {
  // More chunks than a device leaves to the host's threads.
  PolygonMesh mesh = TorusMesh(60, 40);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  const Plan plan = MakeTestPlan(std::move(mesh), structure);
  const auto points = Jitter(structure, 0.2, kViewSeed);
  const QuantisationBox box = BoxFor(*plan, points);
  for (const ViewSpec& spec :
       {ViewSpec{.segments = 10}, ViewSpec{.segments = 3, .position_bits = 14, .normal_bits = 10},
        ViewSpec{.segments = 1, .normals = NormalMode::kNone, .position_bits = 16}}) {
    const auto view = MakeView(plan, spec);
    ASSERT_NE(view, nullptr);
    ASSERT_OK(view->Evaluate(points, box, AllChunks(*plan)));
    const auto integers = ReadAll(*plan, *view);
    const std::vector<uint32_t> some{0, 3, static_cast<uint32_t>(plan->chunk_count()) - 1};
    for (const auto& chunks : {AllChunks(*plan), some}) {
      ASSERT_OK_AND_ASSIGN(const auto streams, view->Encode(chunks, Encoding::kDracoPoints));
      ASSERT_OK_AND_ASSIGN(const auto meshopt, view->Encode(chunks, Encoding::kMeshopt));
      for (size_t i = 0; i < chunks.size(); ++i) {
        const auto vertices = QuantisedVertices::FromBytes(
            integers[chunks[i]], ChunkPoints(*plan, chunks[i], spec.segments), spec.position_bits,
            spec.normals == NormalMode::kNone ? 0 : spec.normal_bits);
        ASSERT_OK_AND_ASSIGN(
            const auto expected,
            testing::EncodePoints(*MakeChunkEncoder("latticed"), vertices, box.range));
        ASSERT_TRUE(std::ranges::equal(streams[i].span(), expected))
            << "chunk " << chunks[i] << ", " << spec.segments << " segments";
        ASSERT_TRUE(std::ranges::equal(meshopt[i].span(), EncodeMeshopt(vertices)))
            << "chunk " << chunks[i] << ", " << spec.segments << " segments";
      }
    }
  }
}

TEST_P(View, ThreadsDoNotChangeABit) {
  const ViewSpec spec{.segments = 4, .format = VertexFormat::kFloat32};
  const auto expected = ReadAll(*plan_, *Evaluated(spec));
  for (int threads : {1, 3}) {
    ASSERT_OK_AND_ASSIGN(backend_, MakeBackendByName(GetParam().backend, threads));
    EXPECT_TRUE(ReadAll(*plan_, *Evaluated(spec)) == expected) << threads << " threads";
  }
}

TEST_P(View, RefusesSpecsOutOfLimits) {
  ASSERT_OK_AND_ASSIGN(auto target, backend_->Prepare(plan_, GetParam().pipeline));
  for (const ViewSpec& spec :
       {ViewSpec{.segments = 0}, ViewSpec{.segments = 33}, ViewSpec{.position_bits = 7},
        ViewSpec{.position_bits = 17}, ViewSpec{.normal_bits = 5}, ViewSpec{.normal_bits = 13}}) {
    EXPECT_THAT(target->CreateView(spec), StatusIs(absl::StatusCode::kInvalidArgument));
  }
}

TEST_P(View, RefusesToReadOrEncodeBeforeItIsEvaluated) {
  const auto view = MakeView(plan_, {.segments = 2});
  std::vector<uint8_t> bytes(ChunkPoints(*plan_, 0, 2) * BytesPerPoint(view->spec()));
  const std::vector<uint32_t> chunks{0};

  EXPECT_THAT(view->Read(0, bytes), StatusIs(absl::StatusCode::kFailedPrecondition));
  EXPECT_THAT(view->Encode(chunks, Encoding::kQuantised),
              StatusIs(absl::StatusCode::kFailedPrecondition));
}

TEST_P(View, RefusesWhatDoesNotFitThePlan) {
  const auto view = Evaluated({.segments = 2});
  const auto beyond = static_cast<uint32_t>(plan_->chunk_count());
  const std::vector<uint32_t> one{0}, wrong{beyond}, twice{0, 0}, falling{1, 0};
  std::vector<uint8_t> bytes(3);
  QuantisationBox other = box_;
  other.range *= 2;
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

  EXPECT_THAT(view->Read(beyond, bytes), StatusIs(kInvalid));
  EXPECT_THAT(view->Read(0, bytes), StatusIs(kInvalid));
  EXPECT_THAT(view->Encode(wrong, Encoding::kQuantised), StatusIs(kInvalid));
  EXPECT_THAT(view->Encode(one, Encoding::kRaw), StatusIs(kInvalid));
  EXPECT_THAT(view->Evaluate(points_, box_, wrong), StatusIs(kInvalid));
  EXPECT_THAT(view->Evaluate(points_, box_, twice), StatusIs(kInvalid));
  EXPECT_THAT(view->Evaluate(points_, box_, falling), StatusIs(kInvalid));
  EXPECT_THAT(view->Evaluate(points_, other, one), StatusIs(kInvalid));
  EXPECT_THAT(view->Evaluate(std::span(points_).first(3), box_, one), StatusIs(kInvalid));
  EXPECT_OK(view->Evaluate(points_, box_, one));

  ASSERT_OK_AND_ASSIGN(auto target, backend_->Prepare(plan_, GetParam().pipeline));
  EXPECT_THAT(target->ControlNets(points_, 0, plan_->patches.size() + 1), StatusIs(kInvalid));
  EXPECT_THAT(target->ControlNets(std::span(points_).first(3), 0, 1), StatusIs(kInvalid));
}

TEST_P(View, FirstEvaluationNeedsAllChunks) {
  const auto view = MakeView(plan_, {.segments = 2});
  const std::vector<uint32_t> one{0};

  EXPECT_THAT(view->Evaluate(points_, box_, one), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_P(View, ReportsItsVertexMemory) {
  const ViewSpec spec{.segments = 10};
  const auto view = Evaluated(spec);
  ASSERT_OK_AND_ASSIGN(auto target, backend_->Prepare(plan_, GetParam().pipeline));

  const MemoryUse use = view->memory();

  const bool on_device = target->Traits(spec).on_device;
  const char* const purpose = on_device ? "device_vertices" : "vertices";
  ASSERT_TRUE(use.contains(purpose));
  EXPECT_GE(use.at(purpose), plan_->patches.size() * 66 * BytesPerPoint(spec));
  EXPECT_EQ(DeviceBytes(use) > 0, on_device);
  EXPECT_EQ(target->memory().contains("device_plan"), on_device);
  EXPECT_GE(target->memory().at("plan"), plan_->patches.size() * sizeof(Patch));
}

INSTANTIATE_TEST_SUITE_P(Backends, View, ::testing::ValuesIn(Subjects()), SubjectName);

}  // namespace
}  // namespace latticed::testing
