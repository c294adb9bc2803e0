// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A random session on a scene of several lattices: random edits of all kinds, and comparisons with a model that the test keeps
// (mixed_model.h).
//
// LATTICED_SEED sets the seed of the random numbers.
#ifndef LATTICED_TESTS_SERVER_MIXED_MIXED_SESSION_H_
#define LATTICED_TESTS_SERVER_MIXED_MIXED_SESSION_H_

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/server/lattices/removed_fixture.h"
#include "tests/server/mixed/mixed_model.h"

namespace latticed::testing {

// Sizes are up to 10, and each of a few lattices keeps 1e-14 of its own (core/ffd/outside/README.md, core/ffd/sum/README.md).
inline constexpr double kCloseTo = 1e-12;

// Of a lattice as the server tells it: its held points, ascending, the axis of its mirror, and itself.
[[nodiscard]] std::vector<uint32_t> HeldBy(const v1::LatticeState& state);
[[nodiscard]] std::optional<int> MirrorOf(const v1::LatticeState& state);
[[nodiscard]] Lattice LatticeOf(const v1::LatticeState& state);

class MixedSession : public RemovedLatticesTest, public ::testing::WithParamInterface<int> {
 protected:
  // A scene of a lattice around the cube, one around a part of it, which fades out, and one that is turned against both.
  void SetUp() override;

  // Random steps. Each is sent to the server and made in the model.
  void MovePoints();
  void DragPoints();
  void MakeGesture();
  void AddLattice();
  void RemoveAny();
  void ChangeOutside();
  void SetStrength();
  void SetWeights();
  void Constrain();
  void InsertKnot();
  void Elevate();
  void UndoStep();
  void RedoStep();
  void RestartServer();
  // A lattice keeps the volume while it and others are edited. Then all of that is undone.
  void KeepVolume();

  // Numbers, states, strengths and control points of all lattices are those of the model. Points of the surface and of the
  // world are where the definition puts them. In a third of the calls, it also folds where the server says.
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
  Vec3d Offset(double reach) {
    return {Number(-reach, reach), Number(-reach, reach), Number(-reach, reach)};
  }
  uint32_t AnyPresent();
  uint32_t AnyPoint(uint32_t number);
  // As a scene may have it beside any other lattices: each contains the cube, or fades out, or goes on along lines.
  Outside DrawOutside(const LatticeStructure& structure);
  latticed::Lattice DrawLattice(Kind kind, double turn);
  // Moves some points by one offset, by at most `reach` along each axis, also in `next`.
  v1::EditBatch RandomMove(uint32_t number, NumberState& next, double reach);
  void EndGesture(uint32_t number, const std::string& id, v1::GesturePhase phase);
  // Makes `next` the number's state, with what only the server tells: the last bits of control points, all of them where
  // `next` has none, and after a change of structure which of them are held.
  void TakeOver(uint32_t number, const std::string& what, NumberState next, bool is_structural);
  // Sends the batch and takes over `next`, unless it is refused for too large a sum, a fold or a volume.
  bool Send(const v1::EditBatch& batch, const std::string& what, NumberState next,
            bool is_structural = true);
  // The same, where the shape stays: `most` says how closely, at places from `low` to `high` of the frame's edges.
  void SendRefined(const v1::EditBatch& batch, const std::string& what, NumberState next,
                   double low, double high, double most);
  // A number that has a step to undo or redo; nullopt if none has.
  std::optional<uint32_t> AnyStep(bool undo);
  void UndoOrRedo(bool undo);

  // Held points of the number are where the model has them.
  void ExpectHeld(uint32_t number, std::span<const Vec3d> points);
  void ExpectSurfacePoints(std::span<const LatticeDefinition> lattices);
  v1::FoldReport Folds();
  // A certified scene has det J > 0 at points of its surface. The places of folds have the determinants of the report.
  void ExpectFolds(std::span<const LatticeDefinition> lattices);
  bool HasDeterminant(std::span<const LatticeDefinition> lattices, const v1::FoldedBox& fold);
  CubePlace AnyPlace();
  // Where the model puts it.
  Vec3d SurfaceOf(const CubePlace& place) const {
    return model_.SurfaceAt(model_.Definitions(), place, place.rest).position;
  }
  static v1::SurfacePoint SurfacePointOf(const CubePlace& place);
  // Up to three places where the number's lattice moves the surface well.
  std::vector<CubePlace> PlacesToDrag(uint32_t number);

  // While a lattice keeps the volume: the numbers that were edited, and all lattices before and after each of these steps.
  struct Kept {
    uint32_t keeper = 0;
    std::vector<uint32_t> steps;
    std::vector<std::vector<std::string>> states;  // serialised
  };
  bool keeps_volume(uint32_t number) const { return kept_.has_value() && kept_->keeper == number; }
  // Takes over what an edit of `number` made of the lattice that keeps the volume.
  void Follow(uint32_t number);
  void EditWithVolume();
  void UndoAll();
  std::vector<std::string> States();
  // A gesture that is cancelled: then there is nothing to redo.
  void ForgetUndone(uint32_t number);

  // Of all patches, in float32.
  std::vector<Vec3d> PointsOfPatches(const std::string& scene);
  static std::string BytesOfWeights(std::span<const float> weights) {
    return {reinterpret_cast<const char*>(weights.data()), weights.size_bytes()};
  }

  MixedModel model_;
  std::optional<Kept> kept_;
  double residual_ = 0;  // of the last edit
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_MIXED_MIXED_SESSION_H_
