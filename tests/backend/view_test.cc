// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The contract of targets and views: formats, encodings, control nets, refusals, memory.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/codec/draco_decode.h"
#include "core/codec/octahedral.h"
#include "core/ffd/bernstein.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeed = 66;

class View : public BackendTest {
 protected:
  void SetUp() override {
    BackendTest::SetUp();
    PolygonMesh mesh = TorusMesh(8, 6);
    const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.scale = 0.9});
    plan_ = MakeTestPlan(std::move(mesh), structure);
    ASSERT_NE(plan_, nullptr);
    points_ = Jitter(structure, 0.05, kSeed);
    box_ = BoxFor(*plan_, points_);
  }

  std::unique_ptr<DeformView> Evaluated(const ViewSpec& spec) {
    auto view = MakeView(plan_, spec);
    if (view != nullptr) {
      EXPECT_OK(view->Evaluate(points_, box_, AllChunks(*plan_)));
    }
    return view;
  }

  void ExpectRounded(const Vertices& got, const Vertices& exact, int bits) const {
    ASSERT_EQ(got.integers.size(), exact.positions.size());
    const double step = box_.step(bits);
    // Half a step, and what float32 may lose before it.
    const double tolerance = 0.5 * step + 1e-6 * box_.range;
    for (size_t i = 0; i < got.integers.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        const double position =
            box_.origin[axis] + step * got.integers[i][static_cast<size_t>(axis)];
        ASSERT_NEAR(position, exact.positions[i][axis] + plan_->local_origin[axis], tolerance);
      }
    }
  }

  static void ExpectWithinCells(const Vertices& got, const Vertices& exact, int bits) {
    ASSERT_EQ(got.octahedral.size(), exact.normals.size());
    // Half a cell's diagonal, stretched by at most sqrt(3) from the octahedron to the sphere; cells
    // on the rim name a direction twice.
    const double tolerance = 2.0 * std::sqrt(6.0) / OctahedralMax(bits);
    for (size_t i = 0; i < got.octahedral.size(); ++i) {
      const auto [s, t] = got.octahedral[i];
      ASSERT_LE(s, static_cast<uint32_t>(OctahedralMax(bits)));
      const Vec3d n =
          ToDouble(DequantiseNormal({static_cast<int32_t>(s), static_cast<int32_t>(t)}, bits));
      ASSERT_LE(Norm(n - exact.normals[i]), tolerance) << "point " << i;
    }
  }

  Plan plan_;
  std::vector<Vec3d> points_;
  QuantisationBox box_;
};

TEST_P(View, IntegersAreTheFloatsRounded) {
  for (const int segments : kFewAndMany) {
    const Vertices exact =
        EvaluateAll(plan_, points_, {.segments = segments, .format = VertexFormat::kFloat32});
    for (const int bits : {8, 11, 12, 16}) {
      SCOPED_TRACE(fmt::format("{} segments, {} bits", segments, bits));

      const Vertices got =
          EvaluateAll(plan_, points_, {.segments = segments, .position_bits = bits});

      ExpectRounded(got, exact, bits);
    }
  }
}

TEST_P(View, OctahedralNormalsAreWithinTheirCell) {
  for (const int segments : kFewAndMany) {
    const Vertices exact =
        EvaluateAll(plan_, points_, {.segments = segments, .format = VertexFormat::kFloat32});
    for (const int bits : {6, 8, 9, 12}) {
      SCOPED_TRACE(fmt::format("{} segments, {} bits", segments, bits));

      const Vertices got = EvaluateAll(plan_, points_, {.segments = segments, .normal_bits = bits});

      ExpectWithinCells(got, exact, bits);
    }
  }
}

TEST_P(View, RawAndQuantisedBytesAreWhatReadGives) {
  for (VertexFormat format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
    const auto view = Evaluated({.segments = 3, .format = format});
    ASSERT_NE(view, nullptr);
    const auto expected = ReadAll(*plan_, *view);
    const std::vector<uint32_t> chunks{static_cast<uint32_t>(plan_->chunk_count()) - 1, 0};

    const auto got = view->Encode(
        chunks, format == VertexFormat::kFloat32 ? Encoding::kRaw : Encoding::kQuantised);

    ASSERT_OK(got);
    ASSERT_EQ(got->size(), 2u);
    for (size_t i = 0; i < 2; ++i) {
      const auto bytes = (*got)[i].span();
      EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), expected[chunks[i]].begin(),
                             expected[chunks[i]].end()));
    }
  }
}

TEST_P(View, LeavesOutNothingThatDiffersFromWhatTheCallerHas) {
  const auto view = Evaluated({.segments = 3});
  ASSERT_NE(view, nullptr);
  const auto all = AllChunks(*plan_);
  const auto old = ReadAll(*plan_, *view);
  std::vector<VertexDigest> digests(all.size());
  ASSERT_OK(view->Encode(all, Encoding::kQuantised, digests));
  std::vector<Vec3d> moved = points_;
  moved[moved.size() / 2].z += 0.01;
  ASSERT_OK(view->Evaluate(moved, box_, all));
  const auto expected = ReadAll(*plan_, *view);

  const auto news = view->Encode(all, Encoding::kQuantised, digests);

  ASSERT_OK(news);
  for (size_t c = 0; c < all.size(); ++c) {
    const auto bytes =
        (*news)[c].data == nullptr ? std::span<const uint8_t>(old[c]) : (*news)[c].span();
    EXPECT_TRUE(std::ranges::equal(bytes, expected[c])) << "chunk " << c;
  }
  EXPECT_NE(old, expected);
}

TEST_P(View, DracoStreamsHoldTheIntegers) {
  for (NormalMode normals : {NormalMode::kNone, NormalMode::kFacet}) {
    const ViewSpec spec{.segments = 4, .normals = normals, .position_bits = 14};
    const auto view = Evaluated(spec);
    ASSERT_NE(view, nullptr);
    const auto chunks = ReadAll(*plan_, *view);
    for (Encoding encoding : {Encoding::kDracoPoints, Encoding::kDracoMesh}) {
      const auto streams = view->Encode(AllChunks(*plan_), encoding);
      ASSERT_OK(streams);
      for (size_t c = 0; c < chunks.size(); ++c) {
        const auto got = DecodeDracoChunkIntegers((*streams)[c].span());
        ASSERT_OK(got);
        const size_t points = ChunkPoints(*plan_, c, spec.segments);
        ASSERT_EQ(got->positions.size(), 3 * points);
        EXPECT_EQ(got->normals.size(), normals == NormalMode::kNone ? 0 : 2 * points);
        for (size_t i = 0; i < points; ++i) {
          for (size_t axis = 0; axis < 3; ++axis) {
            const size_t at = 2 * (axis * points + i);
            ASSERT_EQ(got->positions[3 * i + axis],
                      static_cast<uint32_t>(chunks[c][at] | chunks[c][at + 1] << 8));
          }
        }
      }
    }
  }
}

TEST_P(View, ControlNetsSpanTheDeformedPatches) {
  auto target = backend_->Prepare(plan_, GetParam().pipeline);
  ASSERT_OK(target);
  const int n = plan_->structure.patch_degree();
  const auto m = static_cast<size_t>(BernsteinCount(n));
  const size_t last = plan_->patches.size(), first = last / 2;

  const auto nets = (*target)->ControlNets(points_, first, last);

  ASSERT_OK(nets);
  ASSERT_EQ(nets->size(), (last - first) * m * 3);
  const DirectFfd direct(*plan_, points_);
  for (size_t p = first; p < last; ++p) {
    for (const auto& b : {std::array{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.2, 0.3, 0.5}}) {
      Vec3d sum;
      const double* net = nets->data() + (p - first) * 3 * m;
      for (int i = n; i >= 0; --i) {
        for (int j = n - i; j >= 0; --j, net += 3) {
          sum += Bernstein(i, j, n - i - j, b[0], b[1], b[2]) * Vec3d{net[0], net[1], net[2]};
        }
      }
      ASSERT_LE(Norm(sum - direct.EvaluatePosition(p, b).position), 1e-12) << "patch " << p;
    }
  }
}

TEST_P(View, ThreadsDoNotChangeABit) {
  const ViewSpec spec{.segments = 4, .format = VertexFormat::kFloat32};
  const auto expected = ReadAll(*plan_, *Evaluated(spec));
  for (int threads : {1, 3}) {
    auto backend = MakeBackendByName(GetParam().backend, threads);
    ASSERT_OK(backend);
    backend_ = *std::move(backend);
    EXPECT_TRUE(ReadAll(*plan_, *Evaluated(spec)) == expected) << threads << " threads";
  }
}

TEST_P(View, RefusesSpecsOutOfLimits) {
  auto target = backend_->Prepare(plan_, GetParam().pipeline);
  ASSERT_OK(target);
  for (const ViewSpec& spec :
       {ViewSpec{.segments = 0}, ViewSpec{.segments = 33}, ViewSpec{.position_bits = 7},
        ViewSpec{.position_bits = 17}, ViewSpec{.normal_bits = 5}, ViewSpec{.normal_bits = 13}}) {
    EXPECT_THAT((*target)->CreateView(spec), StatusIs(absl::StatusCode::kInvalidArgument));
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

  auto target = backend_->Prepare(plan_, GetParam().pipeline);
  ASSERT_OK(target);
  EXPECT_THAT((*target)->ControlNets(points_, 0, plan_->patches.size() + 1), StatusIs(kInvalid));
  EXPECT_THAT((*target)->ControlNets(std::span(points_).first(3), 0, 1), StatusIs(kInvalid));
}

TEST_P(View, FirstEvaluationNeedsAllChunks) {
  const auto view = MakeView(plan_, {.segments = 2});
  const std::vector<uint32_t> one{0};

  EXPECT_THAT(view->Evaluate(points_, box_, one), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_P(View, ReportsItsVertexMemory) {
  const ViewSpec spec{.segments = 10};
  const auto view = Evaluated(spec);
  auto target = backend_->Prepare(plan_, GetParam().pipeline);
  ASSERT_OK(target);

  const MemoryUse use = view->memory();

  const bool on_device = (*target)->Traits(spec).on_device;
  const char* const purpose = on_device ? "device_vertices" : "vertices";
  ASSERT_TRUE(use.contains(purpose));
  EXPECT_GE(use.at(purpose), plan_->patches.size() * 66 * BytesPerPoint(spec));
  EXPECT_EQ(DeviceBytes(use) > 0, on_device);
  EXPECT_EQ((*target)->memory().contains("device_plan"), on_device);
  EXPECT_GE((*target)->memory().at("plan"), plan_->patches.size() * sizeof(Patch));
}

INSTANTIATE_TEST_SUITE_P(Backends, View, ::testing::ValuesIn(Subjects()), SubjectName);

}  // namespace
}  // namespace latticed::testing
