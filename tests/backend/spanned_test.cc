// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan that is shared among devices gives the same bits as on one device: all formats, normals
// and encodings, whole evaluations and dirty chunks. The rest of the suite, under the names
// "…-spanned", tests that it keeps the interface's contract.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/backend/conformance.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSpannedSeed = 20'261'122;
constexpr std::array kNormals{NormalMode::kNone, NormalMode::kFacet, NormalMode::kSmooth};

struct Case {
  const char* name;
  PolygonMesh mesh;
  LatticeOptions lattice;
};

// About 22, 14, 50 and 3 chunks: cuts inside boxes, at planes, through seams and unconnected pieces.
std::vector<Case> Cases() {
  return {
      {"partly outside", TorusMesh(20, 12), {.scale = 0.8}},
      {"aligned with knot planes",
       CubeMesh(5),
       {.degree = {2, 3, 1}, .extra = {3, 3, 3}, .scale = 1.0}},
      {"unconnected", TriangleSoup(300, kSpannedSeed), {.degree = {1, 1, 2}, .extra = {3, 3, 3}}},
      {"a box or two", TorusMesh(7, 5), {.degree = {3, 3, 3}, .extra = {0, 0, 0}}}};
}

class Spanned : public ::testing::TestWithParam<std::string> {
 protected:
  struct Views {
    std::unique_ptr<DeformView> one, spanned;
  };

  void SetUp() override {
    one_ = BackendOrSkip(GetParam());
    if (one_ == nullptr) return;
    ASSERT_OK_AND_ASSIGN(spanned_, MakeBackendByName(SpannedName(GetParam())));
  }

  void Prepare(Case c) {
    const LatticeStructure structure = MakeStructure(c.mesh.ComputeBounds(), c.lattice);
    plan_ = MakeTestPlan(std::move(c.mesh), structure);
    ASSERT_NE(plan_, nullptr);
    ASSERT_GT(plan_->chunk_count(), 2u);
    points_ = Jitter(structure, 0.1, kSpannedSeed);
  }
  Views MakeViews(const ViewSpec& spec) {
    return {MakeView(*one_, Pipeline::kFused, plan_, spec),
            MakeView(*spanned_, Pipeline::kFused, plan_, spec)};
  }

  static void Evaluate(Views& views, std::span<const Vec3d> points, const QuantisationBox& box,
                       const std::vector<uint32_t>& chunks) {
    ASSERT_OK(views.one->Evaluate(points, box, chunks));
    ASSERT_OK(views.spanned->Evaluate(points, box, chunks));
  }

  void ExpectSameBits(Views& views) {
    ASSERT_TRUE(ReadAll(*plan_, *views.one) == ReadAll(*plan_, *views.spanned));
  }

  std::unique_ptr<Backend> one_, spanned_;
  Plan plan_;
  std::vector<Vec3d> points_;
};

TEST_P(Spanned, WholeEvaluationsHaveTheBitsOfOneDevice) {
  for (const Case& c : Cases()) {
    ASSERT_NO_FATAL_FAILURE(Prepare(c));
    for (const NormalMode normals : kNormals) {
      for (const ViewSpec& spec :
           {ViewSpec{.segments = 5, .normals = normals, .format = VertexFormat::kFloat32},
            ViewSpec{.segments = 4, .normals = normals},
            ViewSpec{.segments = 10, .normals = normals, .position_bits = 16, .normal_bits = 12},
            ViewSpec{.segments = 1, .normals = normals}}) {
        SCOPED_TRACE(fmt::format("{}, normals {}, {} segments", c.name, static_cast<int>(normals),
                                 spec.segments));
        Views views = MakeViews(spec);
        // Seams are attached at rest, and later detached.
        Evaluate(views, plan_->identity_points, BoxFor(*plan_, points_), AllChunks(*plan_));
        ExpectSameBits(views);
        Evaluate(views, points_, BoxFor(*plan_, points_), AllChunks(*plan_));
        ExpectSameBits(views);
      }
    }
  }
}

TEST_P(Spanned, DirtyChunksHaveTheBitsOfOneDevice) {
  constexpr int kEdits = 40;
  for (const Case& c : Cases()) {
    SCOPED_TRACE(fmt::format("{}, seed {}", c.name, kSpannedSeed));
    ASSERT_NO_FATAL_FAILURE(Prepare(c));
    std::vector<Vec3d> points = plan_->identity_points;
    QuantisationBox box = BoxFor(*plan_, points);
    box.range *= 2;
    Views views = MakeViews({.segments = 3, .normals = NormalMode::kSmooth});
    Evaluate(views, points, box, AllChunks(*plan_));
    std::mt19937 random(kSpannedSeed);
    for (int edit = 0; edit < kEdits; ++edit) {
      const auto moved = static_cast<uint32_t>(random() % points.size());
      points[moved] += Vec3d{0.02, -0.01, 0.03};
      Evaluate(views, points, box, DirtyByControlPoints(*plan_, {&moved, 1}).chunks);
      ExpectSameBits(views);
    }
    // No chunk, one chunk of the last part only, and both sides of every cut.
    const auto last = static_cast<uint32_t>(plan_->chunk_count()) - 1;
    for (const std::vector<uint32_t>& chunks :
         {std::vector<uint32_t>{}, {last}, {0, last}, {last / 3, last / 3 + 1}}) {
      Evaluate(views, points, box, chunks);
      ExpectSameBits(views);
    }
  }
}

TEST_P(Spanned, EncodedBytesAreThoseOfOneDeviceInTheOrderAsked) {
  ASSERT_NO_FATAL_FAILURE(Prepare(Cases().front()));
  ASSERT_OK_AND_ASSIGN(const auto target, spanned_->Prepare(plan_, Pipeline::kFused));
  ViewTraits traits = target->Traits({});
  traits.encode_batch = traits.device_chunks.size();  // alternate between the parts
  const std::vector<uint32_t> chunks = EncodeOrder(traits, AllChunks(*plan_));
  for (const Encoding encoding : {Encoding::kRaw, Encoding::kQuantised, Encoding::kDracoPoints,
                                  Encoding::kDracoMesh, Encoding::kMeshopt}) {
    Views views = MakeViews({.segments = 4, .format = FormatOf(encoding)});
    Evaluate(views, points_, BoxFor(*plan_, points_), AllChunks(*plan_));

    ASSERT_OK_AND_ASSIGN(const auto one, views.one->Encode(AllChunks(*plan_), encoding));
    ASSERT_OK_AND_ASSIGN(const auto spanned, views.spanned->Encode(chunks, encoding));
    ASSERT_EQ(spanned.size(), chunks.size());
    for (size_t i = 0; i < chunks.size(); ++i) {
      ASSERT_TRUE(std::ranges::equal(one[chunks[i]].span(), spanned[i].span())) << "place " << i;
    }

    std::vector<VertexDigest> digests(chunks.size()), half;
    ASSERT_OK(views.spanned->Encode(chunks, encoding, digests));
    half = digests;
    for (size_t i = 0; i < half.size(); i += 2) half[i] = {};
    ASSERT_OK_AND_ASSIGN(const auto rest, views.spanned->Encode(chunks, encoding, half));
    EXPECT_EQ(half, digests);
    for (size_t i = 0; i < half.size(); ++i) {
      EXPECT_EQ(rest[i].data == nullptr, i % 2 == 1) << "place " << i;
    }
  }
}

TEST_P(Spanned, PartsHaveWhatTheirPatchesNeedAndSayWhere) {
  ASSERT_NO_FATAL_FAILURE(Prepare(Cases().front()));

  ASSERT_OK_AND_ASSIGN(const auto one, one_->Prepare(plan_, Pipeline::kFused));
  ASSERT_OK_AND_ASSIGN(const auto spanned, spanned_->Prepare(plan_, Pipeline::kFused));
  ASSERT_OK_AND_ASSIGN(const auto gemm, spanned_->Prepare(plan_, Pipeline::kGemm));
  EXPECT_GT(spanned->Traits({}).device_chunks.size(), 1u);
  EXPECT_EQ(gemm->Traits({}).device_chunks.size(), 1u) << "fused alone spans";
  EXPECT_EQ(&spanned->plan(), plan_.get());
  const uint64_t plan_bytes = spanned->memory().at("plan");
  EXPECT_GT(plan_bytes, one->memory().at("plan"));
  EXPECT_LT(plan_bytes, 3 * one->memory().at("plan"));
  const uint64_t on_one = DeviceBytes(one->memory());
  const uint64_t on_all = DeviceBytes(spanned->memory());
  // Both neighbours hold the data at a cut, and every part holds the boxes.
  EXPECT_GE(on_all, on_one);
  EXPECT_LE(on_all, 2 * on_one);
  uint64_t told = 0;
  for (const auto& [device, bytes] : spanned->device_use()) told += bytes;
  EXPECT_EQ(told, on_all);
}

INSTANTIATE_TEST_SUITE_P(Backends, Spanned, ::testing::ValuesIn(KnownBackends()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
