// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views of the CPU backend: their bytes depend neither on threads nor on which chunks are encoded
// together. Then every backend: its bytes are those that our writer makes of the view's integers.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>
#include <vector>

#include "core/cpu/cpu_backend.h"
#include "tests/backend/conformance.h"
#include "tests/support/encode_chunk.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeed = 20'261'122;

// Our writer, which says how many chunks it has written.
class CountingEncoder : public ChunkEncoder {
 public:
  std::string_view name() const override { return writer_->name(); }
  size_t batch() const override { return writer_->batch(); }
  absl::Status Encode(std::span<const QuantisedVertices> chunks, double range,
                      const ChunkConnectivity* connectivity,
                      std::span<std::vector<uint8_t>> streams) const override {
    count_ += chunks.size();
    return writer_->Encode(chunks, range, connectivity, streams);
  }
  size_t TakeCount() const { return count_.exchange(0); }

 private:
  const std::unique_ptr<ChunkEncoder> writer_ = MakeChunkEncoder("latticed");
  mutable std::atomic<size_t> count_ = 0;
};

class Encoders : public ::testing::TestWithParam<Encoding> {
 protected:
  std::unique_ptr<DeformView> Evaluated(const char* encoder, int threads) {
    return Evaluated(std::shared_ptr<const ChunkEncoder>(MakeChunkEncoder(encoder)), threads);
  }
  std::unique_ptr<DeformView> Evaluated(std::shared_ptr<const ChunkEncoder> encoder, int threads) {
    const auto backend = MakeCpuBackend({.threads = threads, .encoder = std::move(encoder)});
    const auto target = backend->Prepare(plan_, Pipeline::kFused);
    EXPECT_OK(target);
    auto view = (*target)->CreateView({.segments = 5});
    EXPECT_OK(view);
    EXPECT_OK((*view)->Evaluate(points_, BoxFor(*plan_, points_), AllChunks(*plan_)));
    return *std::move(view);
  }

  std::vector<std::vector<uint8_t>> Encode(DeformView& view, std::span<const uint32_t> chunks) {
    const auto streams = view.Encode(chunks, GetParam());
    EXPECT_OK(streams);
    std::vector<std::vector<uint8_t>> bytes;
    for (const SharedBytes& stream : *streams) {
      bytes.emplace_back(stream.span().begin(), stream.span().end());
    }
    return bytes;
  }

  const PolygonMesh mesh_ = TorusMesh(31, 17);
  const LatticeStructure structure_ = MakeStructure(mesh_.ComputeBounds(), {.degree = {2, 2, 2}});
  const Plan plan_ = MakeTestPlan(mesh_, structure_);
  const std::vector<Vec3d> points_ = Jitter(structure_, 0.2, kSeed);
};
INSTANTIATE_TEST_SUITE_P(Draco, Encoders,
                         ::testing::Values(Encoding::kDracoPoints, Encoding::kDracoMesh));

TEST_P(Encoders, BytesDependOnTheChunkAlone) {
  const auto view = Evaluated("latticed", 1);
  const auto expected = Encode(*view, AllChunks(*plan_));
  EXPECT_EQ(Encode(*Evaluated("latticed", 3), AllChunks(*plan_)), expected);
  for (const uint32_t chunk : {0u, 7u, static_cast<uint32_t>(plan_->chunk_count()) - 1}) {
    EXPECT_EQ(Encode(*view, {{chunk}}).front(), expected[chunk]) << "chunk " << chunk;
  }
}

TEST_P(Encoders, WriteOnlyWhatTheCallerHasNoBytesOf) {
  const auto encoder = std::make_shared<CountingEncoder>();
  const auto view = Evaluated(encoder, 2);
  const std::vector<uint32_t> all = AllChunks(*plan_);
  std::vector<VertexDigest> digests(all.size());
  const auto first = view->Encode(all, GetParam(), digests);
  ASSERT_OK(first);
  EXPECT_EQ(encoder->TakeCount(), all.size());
  const auto before = Encode(*view, all);
  encoder->TakeCount();

  const auto again = view->Encode(all, GetParam(), digests);
  ASSERT_OK(again);
  EXPECT_EQ(encoder->TakeCount(), 0u);
  for (const SharedBytes& bytes : *again) EXPECT_EQ(bytes.data, nullptr);

  std::vector<Vec3d> moved = points_;
  moved[moved.size() / 2].z += 0.01;
  ASSERT_OK(view->Evaluate(moved, BoxFor(*plan_, points_), all));
  const auto news = view->Encode(all, GetParam(), digests);
  ASSERT_OK(news);
  const size_t encoded = encoder->TakeCount();
  const auto after = Encode(*view, all);
  size_t changed = 0;
  for (size_t c = 0; c < all.size(); ++c) {
    const bool same = before[c] == after[c];
    changed += same ? 0 : 1;
    EXPECT_EQ((*news)[c].data == nullptr, same) << "chunk " << c;
    const auto bytes = same ? std::span<const uint8_t>(before[c]) : (*news)[c].span();
    EXPECT_TRUE(std::ranges::equal(bytes, after[c])) << "chunk " << c;
  }
  EXPECT_EQ(encoded, changed);
  EXPECT_GT(changed, 0u);
  EXPECT_LT(changed, all.size());
}

class WrittenChunks : public BackendTest {};
INSTANTIATE_TEST_SUITE_P(Backends, WrittenChunks, ::testing::ValuesIn(Subjects()), SubjectName);

TEST_P(WrittenChunks, AreOurWritersOfTheViewsIntegers) {
  // More chunks than a device leaves to the threads of the host.
  const PolygonMesh mesh = TorusMesh(60, 40);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {.degree = {2, 2, 2}});
  const Plan plan = MakeTestPlan(mesh, structure);
  const auto points = Jitter(structure, 0.2, kSeed);
  const QuantisationBox box = BoxFor(*plan, points);
  const std::vector<ViewSpec> specs{
      {.segments = 10},
      {.segments = 3, .position_bits = 14, .normal_bits = 10},
      {.segments = 1, .normals = NormalMode::kNone, .position_bits = 16}};
  for (const ViewSpec& spec : specs) {
    const auto view = MakeView(plan, spec);
    ASSERT_NE(view, nullptr);
    ASSERT_OK(view->Evaluate(points, box, AllChunks(*plan)));
    const auto integers = ReadAll(*plan, *view);
    const std::vector<uint32_t> some{0, 3, static_cast<uint32_t>(plan->chunk_count()) - 1};
    for (const auto& chunks : {AllChunks(*plan), some}) {
      const auto streams = view->Encode(chunks, Encoding::kDracoPoints);
      ASSERT_OK(streams);
      for (size_t i = 0; i < chunks.size(); ++i) {
        const auto expected = testing::EncodePoints(
            *MakeChunkEncoder("latticed"),
            QuantisedVertices::FromBytes(
                integers[chunks[i]], ChunkPoints(*plan, chunks[i], spec.segments),
                spec.position_bits, spec.normals == NormalMode::kNone ? 0 : spec.normal_bits),
            box.range);
        ASSERT_OK(expected);
        ASSERT_TRUE(std::ranges::equal((*streams)[i].span(), *expected))
            << "chunk " << chunks[i] << ", " << spec.segments << " segments";
      }
    }
  }
}

}  // namespace
}  // namespace latticed::testing
