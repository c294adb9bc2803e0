// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/patch_chain.h"

#include <algorithm>
#include <numeric>
#include <random>

#include "gtest/gtest.h"

namespace latticed {
namespace {

using Corners = std::array<Vec3d, 3>;

// Triangles that share no vertex record; corners at one position count as one all the same.
SplitMesh Split(const std::vector<Corners>& triangles) {
  SplitMesh split;
  for (const Corners& triangle : triangles) {
    SplitPiece piece;
    for (size_t c = 0; c < 3; ++c) {
      piece.vertex[c] = static_cast<uint32_t>(split.vertices.size());
      split.vertices.push_back({.world = triangle[c], .parameter = {}});
    }
    split.pieces.push_back(piece);
  }
  return split;
}

std::vector<ChainedPiece> Chain(const SplitMesh& split) {
  Bounds bounds;
  for (const SplitVertex& vertex : split.vertices) bounds.Extend(vertex.world);
  PatchChain chain(split, bounds);
  std::vector<uint32_t> pieces(split.pieces.size());
  std::iota(pieces.begin(), pieces.end(), 0u);
  std::vector<ChainedPiece> chained;
  for (size_t p = 0; p < pieces.size(); ++p) chain.AddPiece();
  chain.BeginChunk();
  chain.Append(pieces, chained);
  return chained;
}

Vec3d Corner(const SplitMesh& split, const ChainedPiece& at, uint32_t corner) {
  return split.vertices[split.pieces[at.piece].vertex[(at.corner + corner) % 3]].world;
}

TEST(PatchChain, ThePatchThatBeginsWhereTheLastEndedComesNext) {
  // The second of the four is far away. The others are around (0, 0, 0).
  const SplitMesh split = Split({{{{1, 0, 0}, {0.5, 0.9, 0}, {0, 0, 0}}},
                                 {{{9, 0, 0}, {9, 1, 0}, {8, 0.5, 0}}},
                                 {{{0, 0, 0}, {0.5, 0.9, 0}, {-0.5, 0.9, 0}}},
                                 {{{-0.5, 0.9, 0}, {-1, 0, 0}, {0, 0, 0}}}});

  const auto chained = Chain(split);

  ASSERT_EQ(chained.size(), 4u);
  EXPECT_EQ(chained[0].piece, 0u);
  EXPECT_EQ(chained[3].piece, 1u);
  for (const size_t p : {1u, 2u}) {
    EXPECT_EQ(Corner(split, chained[p], 0), Corner(split, chained[p - 1], 2)) << p;
  }
}

TEST(PatchChain, AShortEdgeComesFirstUnlessAnAngleAtItIsObtuse) {
  const SplitMesh acute = Split({{{{0, 0, 0}, {4, 0, 0}, {4, 1, 0}}}});
  const SplitMesh obtuse = Split({{{{0, 0, 0}, {4, 0, 0}, {5, 1, 0}}}});

  EXPECT_EQ(Chain(acute).front().corner, 1u);
  EXPECT_EQ(Chain(obtuse).front().corner, 2u) << "the longest";
}

TEST(PatchChain, AnEdgeThatRoundingMayTurnDoesNotComeFirst) {
  const SplitMesh needle = Split({{{{0, 0, 0}, {16, 0, 0}, {16, 0.9, 0}}}});

  EXPECT_NE(Chain(needle).front().corner, 1u) << "less than 1/16 of the longest";
}

TEST(PatchChain, OfEqualCostsTheFirstComesNext) {
  const SplitMesh split =
      Split(std::vector<Corners>(8, {{{0, 0, 0}, {0.5, 0.9, 0}, {-0.5, 0.9, 0}}}));

  const auto chained = Chain(split);

  ASSERT_EQ(chained.size(), 8u);
  for (uint32_t p = 0; p < 8; ++p) {
    EXPECT_EQ(chained[p].piece, p);
  }
}

TEST(PatchChain, HasEveryPieceOnceAndEachLiesOverItsFirstEdge) {
  constexpr uint32_t kSeed = 7;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Corners> triangles(32);
  for (Corners& triangle : triangles) {
    for (Vec3d& corner : triangle) corner = {uniform(random), uniform(random), uniform(random)};
  }
  const SplitMesh split = Split(triangles);

  const auto chained = Chain(split);

  std::vector<uint32_t> pieces;
  size_t not_longest = 0;
  for (const ChainedPiece& at : chained) {
    pieces.push_back(at.piece);
    const Vec3d along = Corner(split, at, 1) - Corner(split, at, 0);
    const double x = Dot(Corner(split, at, 2) - Corner(split, at, 0), along) / Dot(along, along);
    EXPECT_GE(x, 0) << "seed " << kSeed;
    EXPECT_LE(x, 1) << "seed " << kSeed;
    const Vec3d other = Corner(split, at, 2) - Corner(split, at, 1);
    if (Dot(along, along) < Dot(other, other)) ++not_longest;
  }
  std::ranges::sort(pieces);
  std::vector<uint32_t> all(32);
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(pieces, all);
  EXPECT_GT(not_longest, 0u);
}

}  // namespace
}  // namespace latticed
