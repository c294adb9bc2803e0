// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/host_buffer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/error.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using testing::StatusIs;

TEST(HostBuffer, IsZeroedAndAligned) {
  ASSERT_OK_AND_ASSIGN(auto buffer, HostBuffer::Create("vertices", 1'000));
  ASSERT_EQ(buffer.size(), 1'000u);
  const auto bytes = buffer.span();
  EXPECT_TRUE(std::all_of(bytes.begin(), bytes.end(), [](uint8_t b) { return b == 0; }));
  EXPECT_EQ(reinterpret_cast<uintptr_t>(bytes.data()) % 64, 0u);
}

TEST(HostBuffer, RefusesMoreThanTheMachineHasAndTheNextRequestWorks) {
  constexpr size_t kFarTooMuch = size_t{1} << 60;

  const auto refused = HostBuffer::Create("vertices", kFarTooMuch);
  const auto next = HostBuffer::Create("vertices", 10);

  EXPECT_THAT(refused,
              StatusIs(absl::StatusCode::kResourceExhausted, ::testing::HasSubstr("vertices")));
  EXPECT_EQ(error::DetailsOf(refused.status()).asked_bytes, kFarTooMuch);
  EXPECT_GT(error::DetailsOf(refused.status()).free_bytes, 0u);
  EXPECT_OK(next);
}

}  // namespace
}  // namespace latticed
