// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/pinned_memory.h"

#include <algorithm>

#include "core/base/error.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {
namespace {

class PinnedMemoryTest : public CudaTest {
 protected:
  PinnedMemoryTest() : CudaTest(21) {}

  PinnedBuffer Borrow(size_t bytes) {
    auto buffer = memory_->Borrow(bytes);
    EXPECT_OK(buffer);
    return buffer.ok() ? *std::move(buffer) : PinnedBuffer();
  }

  const std::shared_ptr<PinnedMemory> memory_ = std::make_shared<PinnedMemory>(nullptr);
};

TEST_F(PinnedMemoryTest, ABlockIsPinnedFromEndToEnd) {
  for (const size_t bytes :
       {1ul, 4096ul, 4097ul, 100'000ul, 1'048'576ul, 4'300'000ul, 9'000'001ul}) {
    const PinnedBuffer buffer = Borrow(bytes);
    EXPECT_GE(buffer.size(), bytes);
    EXPECT_LE(buffer.size(), std::max<size_t>(2 * bytes, 4096));
    cudaPointerAttributes attributes{};
    for (const uint8_t* at : {buffer.data(), buffer.data() + buffer.size() - 1}) {
      ASSERT_EQ(cudaPointerGetAttributes(&attributes, at), cudaSuccess);
      EXPECT_EQ(attributes.type, cudaMemoryTypeHost) << bytes;
      // The upload kernel reads it at the host's address.
      EXPECT_EQ(attributes.devicePointer, at) << bytes;
    }
  }
}

TEST_F(PinnedMemoryTest, WhatIsLentIsCountedUntilItIsBack) {
  EXPECT_EQ(memory_->lent_bytes(), 0u);
  {
    const PinnedBuffer first = Borrow(4096);
    PinnedBuffer second = Borrow(5000);
    EXPECT_EQ(memory_->lent_bytes(), 4096u + 8192u);
    second = Borrow(1);
    EXPECT_EQ(memory_->lent_bytes(), 4096u + 4096u);
  }
  EXPECT_EQ(memory_->lent_bytes(), 0u);
}

TEST_F(PinnedMemoryTest, WhatIsMoreThanTheHostHasIsRefusedAndLeavesTheDeviceUsable) {
  const auto refused = memory_->Borrow(size_t{1} << 50);
  EXPECT_EQ(error::DetailsOf(refused.status()).reason, "OUT_OF_MEMORY") << refused.status();
  EXPECT_EQ(cudaGetLastError(), cudaSuccess);
  EXPECT_GT(Borrow(kMiB).size(), 0u);
}

}  // namespace
}  // namespace latticed::testing
