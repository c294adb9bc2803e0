// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Random sessions that mix several lattices, parallel and turned, with all that a scene can do to them: they come and go, go on
// outside in other ways, take a part of the deformation, hold points, mirror them, keep the volume, get knots and degrees;
// vertices get weights; points of the surface are dragged; moves that fold are refused; steps and gestures are undone and
// redone, and the server restarts on its folder, also within a gesture. After each step:
//
//   lattices        numbers, structures, strengths, held points and control points are the model's, bit by bit; so a refused
//                   batch changes nothing
//   points          of the world and of the surface are where the definition in double puts them
//   knots, degrees  keep the shape
//   a kept volume   is kept to 1e-12 after each edit, and undone with it, bit by bit
//
// Now and then all points of the patches, as the backend evaluates them, are compared, too; and folds: they are where the
// definition has them, and nowhere in a certified scene.
#include <algorithm>
#include <cstdio>
#include <vector>

#include "tests/server/mixed/mixed_session.h"

namespace latticed::testing {
namespace {

constexpr int kMixedSessions = 8;
constexpr size_t kSurfaceEvery = 8;  // steps

class MixedSessions : public MixedSession {
 protected:
  // All kinds of steps, in random order.
  using Step = void (MixedSessions::*)();
  std::vector<Step> Deck() {
    struct Cards {
      Step step;
      size_t count;
    };
    std::vector<Step> deck;
    for (const auto& [step, count] : {Cards{&MixedSessions::MovePoints, 6},
                                      {&MixedSessions::DragPoints, 3},
                                      {&MixedSessions::MakeGesture, 3},
                                      {&MixedSessions::AddLattice, 4},
                                      {&MixedSessions::RemoveAny, 3},
                                      {&MixedSessions::ChangeOutside, 4},
                                      {&MixedSessions::SetStrength, 4},
                                      {&MixedSessions::SetWeights, 4},
                                      {&MixedSessions::Constrain, 4},
                                      {&MixedSessions::KeepVolume, 2},
                                      {&MixedSessions::InsertKnot, 2},
                                      {&MixedSessions::Elevate, 2},
                                      {&MixedSessions::UndoStep, 8},
                                      {&MixedSessions::RedoStep, 5},
                                      {&MixedSessions::RestartServer, 2}}) {
      deck.insert(deck.end(), count, step);
    }
    std::ranges::shuffle(deck, random_);
    return deck;
  }
};

TEST_P(MixedSessions, StayAsModelled) {
  ASSERT_NO_FATAL_FAILURE(ExpectModel());
  const std::vector<Step> deck = Deck();
  for (size_t n = 0; n < deck.size() && !HasFailure(); ++n) {
    SCOPED_TRACE(n);
    (this->*deck[n])();
    ExpectModel();
    if (n % kSurfaceEvery == kSurfaceEvery - 1) ExpectSurface();
  }
  for (const auto& [what, count] : counts_) std::printf("%s: %d\n", what.c_str(), count);
}

INSTANTIATE_TEST_SUITE_P(Seeds, MixedSessions, ::testing::Range(0, kMixedSessions));

}  // namespace
}  // namespace latticed::testing
