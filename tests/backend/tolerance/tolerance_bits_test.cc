// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Neither the number of threads nor that of devices changes a bit of a view with a tolerance: levels, vertices, streams,
// the chunks that also changed, and the certificate. Devices that share a plan exchange what edges on the cuts need.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "tests/backend/tolerance/tolerance_scenes.h"

namespace latticed::testing {
namespace {

using Chunks = std::vector<uint32_t>;

class ToleranceBits : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { one_ = BackendOrSkip(GetParam()); }

  void Prepare(ToleranceScene scene) {
    structure_ = MakeStructure(scene.mesh.ComputeBounds(), scene.options);
    plan_ = MakeTestPlan(std::move(scene.mesh), structure_);
    ASSERT_NE(plan_, nullptr);
  }
  std::unique_ptr<DeformView> ViewOf(Backend& backend, const ViewSpec& spec) {
    return MakeView(backend, Pipeline::kFused, plan_, spec);
  }
  Watched WatchedOf(DeformView& view) {
    Watched watched(*plan_);
    watched.TakeAll(*plan_, view);
    return watched;
  }

  // Evaluates both views whole, at rest and then after a move of all control points.
  void ExpectSameBits(DeformView& a, DeformView& b, std::span<const Vec3d> points,
                      const QuantisationBox& box) {
    for (const std::span<const Vec3d> now :
         {std::span<const Vec3d>(plan_->identity_points), points}) {
      ExpectSameAfter(a, b, now, box, AllChunks(*plan_));
    }
  }
  void ExpectSameAfter(DeformView& a, DeformView& b, std::span<const Vec3d> points,
                       const QuantisationBox& box, const Chunks& chunks) {
    ASSERT_OK(a.Evaluate(points, box, chunks));
    ASSERT_OK(b.Evaluate(points, box, chunks));
    ASSERT_TRUE(std::ranges::equal(a.also_changed(), b.also_changed()));
    ASSERT_EQ(a.certified_error(), b.certified_error());
    ASSERT_EQ(a.curvature_tolerance(), b.curvature_tolerance());
    ASSERT_TRUE(WatchedOf(a) == WatchedOf(b));
  }

  std::unique_ptr<Backend> one_;
  LatticeStructure structure_;
  Plan plan_;
};

TEST_P(ToleranceBits, ThreadsDoNotChangeABit) {
  // So many chunks that a loop over them has many tasks.
  ASSERT_NO_FATAL_FAILURE(Prepare({"", TorusMesh(70, 48), {.extra = {3, 3, 3}}}));
  ASSERT_GT(plan_->chunk_count(), 200u);
  const std::vector<Vec3d> points = Jitter(structure_, 0.3, kToleranceSeed);
  const QuantisationBox box = BoxFor(*plan_, points);
  const ViewSpec spec{.segments = 32, .tolerance = 1e-4 * box.range, .position_bits = 16};
  const auto expected = ViewOf(*one_, spec);
  ASSERT_NE(expected, nullptr);
  for (const int threads : {1, 5}) {
    SCOPED_TRACE(fmt::format("{} threads", threads));
    ASSERT_OK_AND_ASSIGN(const auto backend, MakeBackendByName(GetParam(), threads));
    const auto view = ViewOf(*backend, spec);
    ASSERT_NE(view, nullptr);
    ASSERT_NO_FATAL_FAILURE(ExpectSameBits(*view, *expected, points, box));
  }
}

TEST_P(ToleranceBits, DevicesDoNotChangeABitOfAWholeEvaluation) {
  for (const int devices : {2, 4}) {
    ASSERT_OK_AND_ASSIGN(const auto spanned, MakeSpannedBackend(GetParam(), devices));
    for (ToleranceScene& scene : ToleranceScenes()) {
      const std::string_view name = scene.name;
      ASSERT_NO_FATAL_FAILURE(Prepare(std::move(scene)));
      const std::vector<Vec3d> points = Jitter(structure_, 0.3, kToleranceSeed);
      const QuantisationBox box = BoxFor(*plan_, points);
      for (const NormalMode normals : {NormalMode::kNone, NormalMode::kSmooth}) {
        for (const auto format : {VertexFormat::kFloat32, VertexFormat::kQuantised}) {
          SCOPED_TRACE(fmt::format("{}, {} devices, normals {}, seed {}", name, devices,
                                   static_cast<int>(normals), kToleranceSeed));
          const ViewSpec spec{.segments = 32,
                              .tolerance = 1e-4 * box.range,
                              .normals = normals,
                              .format = format,
                              .position_bits = 16};
          const auto one = ViewOf(*one_, spec), several = ViewOf(*spanned, spec);
          ASSERT_NE(one, nullptr);
          ASSERT_NE(several, nullptr);
          ASSERT_NO_FATAL_FAILURE(ExpectSameBits(*one, *several, points, box));
        }
      }
    }
  }
}

TEST_P(ToleranceBits, DevicesDoNotChangeABitAfterAnyEdits) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  size_t beyond_the_cut = 0;
  for (const int devices : {2, 4}) {
    ASSERT_OK_AND_ASSIGN(const auto spanned, MakeSpannedBackend(GetParam(), devices));
    for (ToleranceScene& scene : ToleranceScenes()) {
      const std::string_view name = scene.name;
      ASSERT_NO_FATAL_FAILURE(Prepare(std::move(scene)));
      const QuantisationBox box = BoxFor(*plan_, Jitter(structure_, 0.8, kToleranceSeed));
      const ViewSpec spec{.segments = 32, .tolerance = 1e-4 * box.range, .position_bits = 16};
      const auto one = ViewOf(*one_, spec), several = ViewOf(*spanned, spec);
      ASSERT_NE(one, nullptr);
      ASSERT_NE(several, nullptr);
      std::vector<Vec3d> points = plan_->identity_points;
      ASSERT_NO_FATAL_FAILURE(ExpectSameAfter(*one, *several, points, box, AllChunks(*plan_)));
      ASSERT_OK_AND_ASSIGN(const auto target, spanned->Prepare(plan_, Pipeline::kFused));
      const Chunks first_chunks = target->Traits(spec).device_chunks;
      const auto device_of = [&](uint32_t chunk) {
        return std::ranges::upper_bound(first_chunks, chunk) - first_chunks.begin();
      };
      std::mt19937 random(kToleranceSeed);
      for (int edit = 0; edit < 40; ++edit) {
        SCOPED_TRACE(
            fmt::format("{}, {} devices, edit {}, seed {}", name, devices, edit, kToleranceSeed));
        const auto index = static_cast<uint32_t>(random() % points.size());
        points[index] = random() % 4 == 0
                            ? plan_->identity_points[index]
                            : points[index] + Vec3d{noise(random), noise(random), noise(random)};
        const Chunks named = DirtyByControlPoints(*plan_, {{index}}).chunks;
        ASSERT_NO_FATAL_FAILURE(ExpectSameAfter(*one, *several, points, box, named));
        for (const uint32_t chunk : several->also_changed()) {
          beyond_the_cut += std::ranges::none_of(
              named, [&](uint32_t other) { return device_of(other) == device_of(chunk); });
        }
      }
    }
  }
  EXPECT_GT(beyond_the_cut, 0u) << "no edit changed a level on a device without a named chunk";
}

TEST_P(ToleranceBits, DevicesDoubleTheToleranceTogether) {
  ASSERT_OK_AND_ASSIGN(const auto spanned, MakeSpannedBackend(GetParam(), 4));
  ASSERT_NO_FATAL_FAILURE(Prepare({"", TorusMesh(12, 8), {}}));
  const std::vector<Vec3d> points = Jitter(structure_, 0.2, kToleranceSeed);
  const QuantisationBox box = BoxFor(*plan_, points);
  for (const int segments : {1, 2, 3}) {
    SCOPED_TRACE(fmt::format("{} segments", segments));
    const ViewSpec spec{
        .segments = segments, .tolerance = 1e-9 * box.range, .format = VertexFormat::kFloat32};
    const auto one = ViewOf(*one_, spec), several = ViewOf(*spanned, spec);
    ASSERT_NE(one, nullptr);
    ASSERT_NE(several, nullptr);

    ASSERT_NO_FATAL_FAILURE(ExpectSameBits(*one, *several, points, box));
    EXPECT_GT(several->certified_error(), 10 * spec.tolerance) << "nothing was doubled";
  }
}

TEST_P(ToleranceBits, DevicesCertifyNothingThatOneOfThemCannotBound) {
  ASSERT_OK_AND_ASSIGN(const auto spanned, MakeSpannedBackend(GetParam(), 2));
  ASSERT_NO_FATAL_FAILURE(Prepare({"", TorusMesh(12, 8), {.extra = {3, 3, 3}}}));
  std::vector<Vec3d> points = plan_->identity_points;
  points[points.size() / 2].x = 1e200;
  const ViewSpec spec{.tolerance = 1e-3, .format = VertexFormat::kFloat32};
  const auto one = ViewOf(*one_, spec), several = ViewOf(*spanned, spec);
  ASSERT_NE(one, nullptr);
  ASSERT_NE(several, nullptr);

  ASSERT_NO_FATAL_FAILURE(
      ExpectSameAfter(*one, *several, points, BoxFor(*plan_, points), AllChunks(*plan_)));
  EXPECT_TRUE(std::isinf(several->certified_error())) << several->certified_error();
}

TEST_P(ToleranceBits, StreamsOfDevicesAreThoseOfOne) {
  ASSERT_OK_AND_ASSIGN(const auto spanned, MakeSpannedBackend(GetParam(), 2));
  ASSERT_NO_FATAL_FAILURE(Prepare({"", TorusMesh(14, 9), {}}));
  const std::vector<Vec3d> points = Jitter(structure_, 0.2, kToleranceSeed);
  const QuantisationBox box = BoxFor(*plan_, points);
  const ViewSpec spec{.segments = 32, .tolerance = 1e-3 * box.range, .position_bits = 14};
  const auto one = ViewOf(*one_, spec), several = ViewOf(*spanned, spec);
  ASSERT_NE(one, nullptr);
  ASSERT_NE(several, nullptr);
  ASSERT_NO_FATAL_FAILURE(ExpectSameAfter(*one, *several, points, box, AllChunks(*plan_)));
  for (const Encoding encoding :
       {Encoding::kQuantised, Encoding::kDracoPoints, Encoding::kDracoMesh, Encoding::kMeshopt}) {
    ASSERT_OK_AND_ASSIGN(const auto expected, one->Encode(AllChunks(*plan_), encoding));
    ASSERT_OK_AND_ASSIGN(const auto streams, several->Encode(AllChunks(*plan_), encoding));
    for (size_t i = 0; i < expected.size(); ++i) {
      ASSERT_TRUE(std::ranges::equal(expected[i].span(), streams[i].span())) << "chunk " << i;
    }
  }
}

// Together, two devices have at most a quarter more than one has for the whole, and what a device has whatever its slice.
TEST_P(ToleranceBits, DevicesHaveLittleMoreThanTheirSlices) {
  constexpr uint64_t kBytesOfADevice = uint64_t{128} << 10;
  ASSERT_OK_AND_ASSIGN(const auto spanned, MakeSpannedBackend(GetParam(), 2));
  ASSERT_NO_FATAL_FAILURE(Prepare({"", TorusMesh(120, 80), {.extra = {3, 3, 3}}}));
  const QuantisationBox box = BoxFor(*plan_, plan_->identity_points);
  const ViewSpec spec{.tolerance = 1e-3 * box.range};
  ASSERT_OK_AND_ASSIGN(const auto target, spanned->Prepare(plan_, Pipeline::kFused));
  const auto one = ViewOf(*one_, spec), several = ViewOf(*spanned, spec);
  ASSERT_NE(one, nullptr);
  ASSERT_NE(several, nullptr);
  ASSERT_NO_FATAL_FAILURE(
      ExpectSameAfter(*one, *several, plan_->identity_points, box, AllChunks(*plan_)));

  const MemoryUse use = several->memory(), of_one = one->memory();
  const auto bytes = [](const MemoryUse& of) { return HostBytes(of) + DeviceBytes(of); };
  EXPECT_GT(use.at("levels"), of_one.at("levels"));
  EXPECT_LT(4 * bytes(use), 5 * bytes(of_one) + 4 * kBytesOfADevice * 2);
  EXPECT_GT(bytes(of_one), 4 * kBytesOfADevice * 2) << "too small to tell whole views from slices";
  EXPECT_LE(HostBytes(use), target->Traits(spec).host_bytes);
}

INSTANTIATE_TEST_SUITE_P(Backends, ToleranceBits, ::testing::ValuesIn(KnownBackends()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace latticed::testing
