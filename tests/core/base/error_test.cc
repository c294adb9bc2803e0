// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Details stay unchanged in a status, whatever characters clients put into ids.
#include "core/base/error.h"

#include <gtest/gtest.h>

#include <string>

namespace latticed::error {
namespace {

void ExpectSame(const Details& got, const Details& expected) {
  EXPECT_EQ(got.reason, expected.reason);
  EXPECT_EQ(got.field, expected.field);
  EXPECT_EQ(got.metadata, expected.metadata);
  EXPECT_EQ(got.asked_bytes, expected.asked_bytes);
  EXPECT_EQ(got.free_bytes, expected.free_bytes);
  EXPECT_EQ(got.retry_after_ms, expected.retry_after_ms);
}

TEST(ErrorTest, DetailsComeBackAsTheyWere) {
  const Details details{.reason = "OUT_OF_MEMORY",
                        .field = "lattices[0].size.u",
                        .metadata = {{"id", "scene-one"}, {"kind", "scene"}},
                        .asked_bytes = UINT64_MAX,
                        .free_bytes = 7,
                        .retry_after_ms = 1'500};

  ExpectSame(DetailsOf(WithDetails(absl::InternalError("no"), details)), details);
  ExpectSame(DetailsOf(WithDetails(absl::InternalError("no"), {})), {});
}

TEST(ErrorTest, AnyCharacterOfAnIdStaysInIt) {
  using std::string_literals::operator""s;
  for (const std::string& id :
       {""s, "\x1f"s, "a\x1fkind\x1fmesh"s, "3:abc"s, ":"s, "nul\0nul"s, "\n\xff"s}) {
    const Details details = DetailsOf(NotFound("scene", id));

    EXPECT_EQ(details.reason, "NOT_FOUND");
    EXPECT_EQ(details.metadata,
              (std::map<std::string, std::string>{{"kind", "scene"}, {"id", id}}));
  }
}

TEST(ErrorTest, AForeignStatusHasTheReasonOfItsCode) {
  ExpectSame(DetailsOf(absl::CancelledError("gone")), {.reason = "CANCELLED"});
  ExpectSame(DetailsOf(absl::DeadlineExceededError("late")), {.reason = "DEADLINE_EXCEEDED"});
  ExpectSame(DetailsOf(absl::DataLossError("?")), {.reason = "INTERNAL"});
}

}  // namespace
}  // namespace latticed::error
