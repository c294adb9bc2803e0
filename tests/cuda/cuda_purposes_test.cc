// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a scene tells of its memory, as GetScene reports it: each purpose to the byte, and all of the
// device's in what the device tells of itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "cuda/cuda_backend.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {
namespace {

constexpr uint64_t kBudget = 256 * kMiB;
// Facet normals in 2 bytes beside 16-bit positions.
constexpr ViewSpec kSpec{.segments = 4};
constexpr uint64_t kPoints = 15, kBytesPerPoint = 8;
// Of degree 2 x 2 x 2: samples of a patch; rows of position and two derivatives.
constexpr uint64_t kSamples = 28, kRows = 3 * kPoints;
// Sample points, pattern, two stacks of floats and one of doubles, the inverse: each from a multiple
// of 256 bytes on.
constexpr uint64_t kStageBytes = 27'264;
static_assert(kStageBytes == 512 + 2 * 5'120 + 10'240 + kSamples * kSamples * sizeof(double));

constexpr uint64_t RoundUp(uint64_t bytes, uint64_t unit) {
  return (bytes + unit - 1) / unit * unit;
}
uint64_t Pinned(uint64_t bytes) { return std::bit_ceil(std::max<uint64_t>(bytes, 4096)); }

class CudaPurposes : public CudaTest {
 protected:
  CudaPurposes() : CudaTest(17) {}

  uint64_t patches() const { return plan_->patches.size(); }
  // An edit's copy: control points, a byte a seam, the chunks' numbers.
  uint64_t EditBytes() const {
    const uint64_t seams = points_.size() * sizeof(Vec3d) + plan_->seams.size();
    return RoundUp(RoundUp(seams, 4) + plan_->chunk_count() * 4, 16);
  }
  uint64_t WireBytes() const { return patches() * kPoints * kBytesPerPoint; }

  // Of a view that was evaluated, and read whole in one batch.
  MemoryUse OfFused() const {
    const uint64_t list = plan_->chunk_count() * 16, read = Pinned(WireBytes());
    return {{"device_vertices", plan_->chunk_count() * 32 * kPoints * kBytesPerPoint},
            {"device_box_polynomials", plan_->boxes.size() * (3 * 28 + 1) * sizeof(float)},
            {"device_staging", EditBytes() + list + read},
            {"staging", Pinned(EditBytes()) + Pinned(list) + read}};
  }
  MemoryUse OfProducts(Pipeline pipeline) const {
    const uint64_t columns = 3 * patches(), marks = RoundUp(patches() * kPoints, 32) / 8;
    uint64_t samples = columns * (kSamples + kRows) * sizeof(float) + marks +  //
                       patches() * sizeof(Vec3d);
    if (pipeline == Pipeline::kControlNet) samples += columns * 2 * kSamples * sizeof(double);
    const uint64_t own = kRows * kSamples * (sizeof(double) + sizeof(float));
    return {{"device_vertices", WireBytes()},
            {"device_samples", samples},
            {"device_stage_matrices", kStageBytes + (pipeline == Pipeline::kGemm12 ? own : 0)},
            {"device_staging", EditBytes()},
            {"staging", Pinned(EditBytes()) + Pinned(WireBytes())}};
  }
  // As the device names purposes: without the prefix.
  static void AddDevicePart(const MemoryUse& of, MemoryUse& sum) {
    for (const auto& [purpose, bytes] : of) {
      if (purpose.starts_with(kDevicePurpose)) sum[purpose.substr(kDevicePurpose.size())] += bytes;
    }
  }
};

TEST_F(CudaPurposes, EveryPurposeIsToldInBytesAndTheDeviceTellsTheirSum) {
  ASSERT_EQ(points_.size(), 100u);
  ASSERT_LT(WireBytes(), 8 * kMiB) << "one batch";
  for (const Pipeline pipeline : kPipelines) {
    SCOPED_TRACE(PipelineName(pipeline));
    const bool fused = pipeline == Pipeline::kFused;
    const auto backend = MakeCudaBackend({.memory_bytes = kBudget});
    ASSERT_OK(backend);
    const auto target = (*backend)->Prepare(plan_, pipeline);
    ASSERT_OK(target);
    const auto view = (*target)->CreateView(kSpec);
    ASSERT_OK(view);
    if (!fused) {
      EXPECT_EQ((*view)->memory().at("device_samples"), 0u) << "before the first use";
    }

    ASSERT_OK((*view)->Evaluate(points_, BoxFor(*plan_, points_), AllChunks(*plan_)));
    ASSERT_OK((*view)->Encode(AllChunks(*plan_), Encoding::kQuantised));

    EXPECT_EQ((*view)->memory(), fused ? OfFused() : OfProducts(pipeline));
    MemoryUse sum;
    AddDevicePart((*target)->memory(), sum);
    AddDevicePart((*view)->memory(), sum);
    EXPECT_EQ((*target)->device_use(), (DeviceUse{{0, sum.at("plan")}}));
    if (!fused) sum["gemm_workspace"] = 4 * kMiB;  // the lane's, of no scene
    const DeviceState state = (*backend)->devices().front();
    EXPECT_EQ(state.use, sum);
    uint64_t bytes = 0;
    for (const auto& [purpose, size] : sum) bytes += size;
    EXPECT_EQ(state.free_bytes, kBudget - bytes);
  }
}

}  // namespace
}  // namespace latticed::testing
