// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A random session on a scene of several lattices: random edits of all kinds, and comparisons with a model that the test keeps
// (mixed_model.h). The sessions of ../points/random_session.h have drags, kept volumes and folds, but one kind of scene each.
//
// LATTICED_SEED sets the seed of the random numbers.
#ifndef LATTICED_TESTS_SERVER_LATTICES_MIXED_SESSION_H_
#define LATTICED_TESTS_SERVER_LATTICES_MIXED_SESSION_H_

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/server/lattices/mixed_model.h"
#include "tests/server/lattices/removed_fixture.h"

namespace latticed::testing {

class MixedSession : public RemovedLatticesTest, public ::testing::WithParamInterface<int> {
 protected:
  // A scene of a lattice around the cube, one around a part of it, which fades out, and one that is turned against both.
  void SetUp() override;

  // Random steps. Each is sent to the server and made in the model.
  void MovePoints();
  void MakeGesture();
  void AddLattice();
  void RemoveAny();
  void ChangeOutside();
  void SetStrength();
  void SetWeights();
  void Hold();
  void InsertKnot();
  void Elevate();
  void UndoStep();
  void RedoStep();
  void RestartServer();

  // Numbers, states, strengths and control points of all lattices are those of the model. Points of the surface and of the
  // world are where the definition puts them.
  void ExpectModel();
  // The same of all points of the surface's patches, as the backend evaluates them.
  void ExpectSurface();

  std::map<std::string, int> counts_;

 private:
  enum class Kind { kWhole, kHalf, kSpot };

  int Below(int end) { return std::uniform_int_distribution<int>(0, end - 1)(random_); }
  double Number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  uint32_t AnyPresent();
  uint32_t AnyPoint(uint32_t number);
  // As a scene may have it beside any other lattices: each contains the cube, or fades out, or goes on along lines.
  Outside DrawOutside(const LatticeStructure& structure);
  latticed::Lattice DrawLattice(Kind kind, double turn);
  // Moves some points by one offset, also in `next`.
  v1::EditBatch RandomMove(uint32_t number, NumberState& next);
  // Makes `next` the number's state, with what only the server tells: the last bits of control points, all of them where
  // `next` has none, and after a change of structure which of them are held.
  void TakeOver(uint32_t number, const std::string& what, NumberState next, bool is_structural);
  // Sends the batch and takes over `next`, unless it is refused for too large a sum.
  bool Send(const v1::EditBatch& batch, const std::string& what, NumberState next,
            bool is_structural = true);
  // The same, where the shape stays: `most` says how closely, at places from `low` to `high` of the frame's edges.
  void SendRefined(const v1::EditBatch& batch, const std::string& what, NumberState next,
                   double low, double high, double most);
  // A number that has a step to undo or redo; nullopt if none has.
  std::optional<uint32_t> AnyStep(bool undo);
  void UndoOrRedo(bool undo);
  void ExpectSurfacePoints(std::span<const LatticeDefinition> lattices);
  // Of all patches, in float32.
  std::vector<Vec3d> PointsOfPatches(const std::string& scene);
  static std::string BytesOfWeights(std::span<const float> weights) {
    return {reinterpret_cast<const char*>(weights.data()), weights.size_bytes()};
  }

  MixedModel model_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_LATTICES_MIXED_SESSION_H_
