// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Digests against published test vectors.
#include "core/base/sha256.h"

#include <gtest/gtest.h>

#include <string>

namespace latticed {
namespace {

TEST(Sha256Test, HasThePublishedDigests) {  // FIPS 180-4, "abc" in two parts and whole
  constexpr char kAbc[] = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
  Sha256 hash;
  hash.Update("a");
  hash.Update("bc");

  EXPECT_EQ(hash.FinishHex(), kAbc);
  EXPECT_EQ(Sha256Hex("abc"), kAbc);
  EXPECT_TRUE(IsSha256Hex(kAbc));
  EXPECT_FALSE(IsSha256Hex("BA" + std::string(kAbc + 2)));
  EXPECT_FALSE(IsSha256Hex(std::string(63, 'a')));
}

TEST(Sha256Test, HasThePublishedHmacs) {  // RFC 4231, cases 2 and 6
  EXPECT_EQ(HmacSha256Hex("Jefe", "what do ya want for nothing?"),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(HmacSha256Hex(std::string(131, '\xAA'),
                          "Test Using Larger Than Block-Size Key - Hash Key First"),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
}

}  // namespace
}  // namespace latticed
