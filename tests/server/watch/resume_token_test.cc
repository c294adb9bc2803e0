// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/watch/resume_token.h"

#include <limits>
#include <optional>
#include <string>

#include <gtest/gtest.h>

namespace latticed::testing {
namespace {

std::optional<absl::Time> NotKnown(uint64_t) { return std::nullopt; }

TEST(ResumeToken, ResumesNothingOnceABitIsFlipped) {
  const TokenScope scope{"key", "cpu", "run"};
  SceneState state;
  state.revision = 1'000;
  const ClientSurface had{ViewKey(), state.structure_id, state.box.id, 5};
  const std::string token = MakeResumeToken(scope, had);
  ASSERT_TRUE(ParseResumeToken(token, scope, ViewKey(), state, NotKnown).has_value());

  for (size_t bit = 0; bit < 8 * token.size(); ++bit) {
    std::string flipped = token;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_EQ(ParseResumeToken(flipped, scope, ViewKey(), state, NotKnown), std::nullopt)
        << flipped;
  }
}

TEST(ResumeToken, ResumesTheSameScopeViewStructureAndBoxAlone) {
  const TokenScope scope{"key", "cpu", "run"};
  SceneState state;
  state.revision = 9;
  state.box.id = 3;
  ViewKey view;
  const ClientSurface had{view, state.structure_id, 3, 5};
  const std::string token = MakeResumeToken(scope, had);

  EXPECT_EQ(ParseResumeToken(token, scope, view, state, NotKnown), had);

  ViewKey finer = view;
  finer.spec.segments = 11;
  SceneState other_structure = state, other_box = state, older = state;
  other_structure.structure_id = 2;
  other_box.box.id = 4;
  older.revision = 4;
  EXPECT_EQ(ParseResumeToken(token, {"another", "cpu", "run"}, view, state, NotKnown),
            std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, {"key", "cuda", "run"}, view, state, NotKnown), std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, scope, finer, state, NotKnown), std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, scope, view, other_structure, NotKnown), std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, scope, view, other_box, NotKnown), std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, scope, view, older, NotKnown), std::nullopt);
  for (const char* garbage : {"", "a/b/c/d/e/f/g/h", "1/3/5/0/0/run/x/", "///////"}) {
    EXPECT_EQ(ParseResumeToken(garbage, scope, view, state, NotKnown), std::nullopt) << garbage;
  }
}

TEST(ResumeToken, OfAnotherRunCountsWhereItsRevisionIsKnown) {
  SceneState state;
  state.revision = 9;
  const absl::Time time = absl::FromUnixNanos(1'795'000'000'123'456'789);
  ViewKey view;
  const ClientSurface had{view, state.structure_id, state.box.id, 5, time};
  const std::string token = MakeResumeToken({"key", "cpu", "run one"}, had);
  const TokenScope two{"key", "cpu", "run two"};
  const auto at = [](absl::Time when) {
    return [when](uint64_t revision) { return revision == 5 ? std::optional(when) : std::nullopt; };
  };

  EXPECT_EQ(ParseResumeToken(token, two, view, state, at(time)), had);
  EXPECT_EQ(ParseResumeToken(token, two, view, state, NotKnown), std::nullopt);
  // The store went back, and another edit made the revision.
  EXPECT_EQ(ParseResumeToken(token, two, view, state, at(time + absl::Nanoseconds(1))),
            std::nullopt);
}

// Patterns depend on it: it is a double of the tolerance where the view has too many points.
TEST(ResumeToken, SaysWhichToleranceWasKept) {
  const TokenScope scope{"key", "cpu", "run"};
  SceneState state;
  state.revision = 9;
  const ViewKey view{{.tolerance = 0.5}};
  for (const double kept : {0.1, 1.0 / 3, 1e-300, std::numeric_limits<double>::infinity()}) {
    const ClientSurface had{view, state.structure_id, state.box.id, 5, absl::UnixEpoch(), kept};
    EXPECT_EQ(ParseResumeToken(MakeResumeToken(scope, had), scope, view, state, NotKnown), had);
  }
}

TEST(ResumeToken, OfAViewWithoutPositionsOutlivesABox) {
  const TokenScope scope{"key", "cpu", "run"};
  SceneState state;
  state.revision = 9;
  state.box.id = 3;
  const ViewKey view{{.format = VertexFormat::kEdgeBounds}, Encoding::kPatches};
  const ClientSurface had{view, state.structure_id, 0, 5};
  const std::string token = MakeResumeToken(scope, had);
  state.box.id = 4;

  EXPECT_EQ(ParseResumeToken(token, scope, view, state, NotKnown), had);
}

}  // namespace
}  // namespace latticed::testing
