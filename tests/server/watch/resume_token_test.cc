// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/watch/resume_token.h"

#include <optional>
#include <string>

#include <gtest/gtest.h>

namespace latticed::testing {
namespace {

TEST(ResumeToken, ResumesNothingOnceABitIsFlipped) {
  const TokenScope scope{"key", "cpu"};
  SceneState state;
  state.revision = 1'000;
  const ClientSurface had{ViewKey(), state.structure_id, state.box.id, 5};
  const std::string token = MakeResumeToken(scope, had);
  ASSERT_TRUE(ParseResumeToken(token, scope, ViewKey(), state).has_value());

  for (size_t bit = 0; bit < 8 * token.size(); ++bit) {
    std::string flipped = token;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_EQ(ParseResumeToken(flipped, scope, ViewKey(), state), std::nullopt) << flipped;
  }
}

TEST(ResumeToken, ResumesTheSameScopeViewStructureAndBoxAlone) {
  const TokenScope scope{"key", "cpu"};
  SceneState state;
  state.revision = 9;
  state.box.id = 3;
  ViewKey view;
  const ClientSurface had{view, state.structure_id, 3, 5};
  const std::string token = MakeResumeToken(scope, had);

  EXPECT_EQ(ParseResumeToken(token, scope, view, state), had);

  ViewKey finer = view;
  finer.spec.segments = 11;
  SceneState other_structure = state, other_box = state, older = state;
  other_structure.structure_id = 2;
  other_box.box.id = 4;
  older.revision = 4;
  EXPECT_EQ(ParseResumeToken(token, {"another", "cpu"}, view, state), std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, {"key", "cuda"}, view, state), std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, scope, finer, state), std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, scope, view, other_structure), std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, scope, view, other_box), std::nullopt);
  EXPECT_EQ(ParseResumeToken(token, scope, view, older), std::nullopt);
  for (const char* garbage : {"", "a/b/c/d/e", "1/3/5/x/", "////"}) {
    EXPECT_EQ(ParseResumeToken(garbage, scope, view, state), std::nullopt) << garbage;
  }
}

TEST(ResumeToken, OfAViewWithoutPositionsOutlivesABox) {
  const TokenScope scope{"key", "cpu"};
  SceneState state;
  state.revision = 9;
  state.box.id = 3;
  const ViewKey view{{.format = VertexFormat::kEdgeBounds}, Encoding::kPatches};
  const ClientSurface had{view, state.structure_id, 0, 5};
  const std::string token = MakeResumeToken(scope, had);
  state.box.id = 4;

  EXPECT_EQ(ParseResumeToken(token, scope, view, state), had);
}

}  // namespace
}  // namespace latticed::testing
