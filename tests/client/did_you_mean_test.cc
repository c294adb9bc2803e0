// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/command_line/did_you_mean.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace latticed::client {
namespace {

TEST(DidYouMeanTest, DistanceCountsInsertionsDeletionsAndSubstitutions) {
  EXPECT_EQ(EditDistance("", ""), 0);
  EXPECT_EQ(EditDistance("", "abc"), 3);
  EXPECT_EQ(EditDistance("abc", ""), 3);
  EXPECT_EQ(EditDistance("apply", "apply"), 0);
  EXPECT_EQ(EditDistance("aply", "apply"), 1);
  EXPECT_EQ(EditDistance("ifno", "info"), 2);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3);
}

TEST(DidYouMeanTest, FirstPrefixThenNearestThenNone) {
  const std::vector<std::string> commands{"apply", "info", "lattice", "sample", "scene", "edit"};
  const std::vector<std::string> options{"-h", "-o", "--output", "--lattice", "--tls", "--tls-ca"};
  EXPECT_EQ(DidYouMean("aply", commands), "apply");
  EXPECT_EQ(DidYouMean("ifno", commands), "info");
  EXPECT_EQ(DidYouMean("latice", commands), "lattice");
  EXPECT_EQ(DidYouMean("latt", commands), "lattice");
  EXPECT_EQ(DidYouMean("quick", std::vector<std::string>{"pick", "quickstart"}), "quickstart");
  EXPECT_EQ(DidYouMean("s", commands), "sample");
  EXPECT_EQ(DidYouMean("fly", commands), "");
  EXPECT_EQ(DidYouMean("", commands), "");
  EXPECT_EQ(DidYouMean("aply", {}), "");
  EXPECT_EQ(DidYouMean("--lattic", options), "--lattice");
  EXPECT_EQ(DidYouMean("--out", options), "--output");
  EXPECT_EQ(DidYouMean("--tls-cs", options), "--tls-ca");
  EXPECT_EQ(DidYouMean("-x", options), "");
  EXPECT_EQ(DidYouMean("--", options), "");
}

}  // namespace
}  // namespace latticed::client
