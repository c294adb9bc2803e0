// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/base/utf8.h"

#include <gtest/gtest.h>

namespace latticed {
namespace {

TEST(Utf8Test, ValidTextStays) {
  const std::string text = "plain, \xC3\xA4, \xE2\x82\xAC, \xF0\x9F\x98\x80, \xEE\x80\x80, \x7F";

  EXPECT_EQ(ValidUtf8(text), text);
  EXPECT_EQ(ValidUtf8(""), "");
}

TEST(Utf8Test, WhatIsInNoCharacterIsReplaced) {
  const std::string r = "\xEF\xBF\xBD";

  EXPECT_EQ(ValidUtf8("a\xE4z"), "a" + r + "z");            // Latin-1
  EXPECT_EQ(ValidUtf8("\x80"), r);                          // continuation byte without a start
  EXPECT_EQ(ValidUtf8("\xC0\xAF"), r + r);                  // overlong
  EXPECT_EQ(ValidUtf8("\xE0\x80\x80"), r + r + r);          // overlong
  EXPECT_EQ(ValidUtf8("\xED\xA0\x80"), r + r + r);          // surrogate
  EXPECT_EQ(ValidUtf8("\xF4\x90\x80\x80"), r + r + r + r);  // above U+10FFFF
  EXPECT_EQ(ValidUtf8("a\xE2\x82"), "a" + r + r);           // cut short
  EXPECT_EQ(ValidUtf8(std::string_view("\0\xFF", 2)), std::string(1, '\0') + r);
}

TEST(Utf8Test, FirstCharacterHasAllOfItsBytes) {
  EXPECT_EQ(FirstCharacter("ab"), "a");
  EXPECT_EQ(FirstCharacter("\u00F6b"), "\u00F6");
  EXPECT_EQ(FirstCharacter("\u6587b"), "\u6587");
  EXPECT_EQ(FirstCharacter("\U0001F600b"), "\U0001F600");
}

TEST(Utf8Test, CutsBetweenCharacters) {
  const std::string text = "ab\xE2\x82\xAC";

  EXPECT_EQ(CutUtf8(text, 5), text);
  EXPECT_EQ(CutUtf8(text, 4), "ab");
  EXPECT_EQ(CutUtf8(text, 2), "ab");
  EXPECT_EQ(CutUtf8(text, 1), "a");
  EXPECT_EQ(CutUtf8(text, 0), "");
}

}  // namespace
}  // namespace latticed
