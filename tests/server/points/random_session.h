// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A random session on a box: a scene of one kind, random edits of it, and a model that says what they must do. All numbers
// of the model are doubles of core/ffd/direct_ffd.h.
//
// LATTICED_SEED sets the seed of the random numbers.
#ifndef LATTICED_TESTS_SERVER_POINTS_RANDOM_SESSION_H_
#define LATTICED_TESTS_SERVER_POINTS_RANDOM_SESSION_H_

#include <array>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "core/ffd/lattice.h"
#include "tests/server/points/point_set_client.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {

// What undo brings back.
struct Undoable {
  std::string lattice, constraints;  // serialised
  friend bool operator==(const Undoable&, const Undoable&) = default;
};
[[nodiscard]] Undoable UndoableOf(const v1::LatticeState& state);
[[nodiscard]] std::vector<Vec3d> ControlPointsOf(const v1::LatticeState& state);

class RandomSession : public SceneFixture, public ::testing::WithParamInterface<int> {
 protected:
  // By the parameter: a lattice around the box, one around its half that goes on outside, vertex weights, and two lattices,
  // parallel or turned against each other, of which the session edits the second, which was added, and another editor the
  // first, which keeps the volume in some. The last kind has both weights and turned lattices.
  enum class Kind { kPlain, kFalloff, kLinear, kWeighted, kSeveral, kTurned, kWeightedTurned };
  static constexpr int kKinds = 7;

  void SetUp() override;
  void Restart();

  Kind kind() const { return static_cast<Kind>(GetParam() % kKinds); }
  bool is_weighted() const { return kind() == Kind::kWeighted || kind() == Kind::kWeightedTurned; }
  bool is_turned() const { return kind() == Kind::kTurned || kind() == Kind::kWeightedTurned; }
  bool is_of_two() const { return kind() == Kind::kSeveral || is_turned(); }
  // The lattice that the session edits.
  v1::LatticeState State() { return StateOf(is_of_two() ? 1 : 0); }
  int Below(int end) { return std::uniform_int_distribution<int>(0, end - 1)(random_); }
  double Number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vec3d Step(double reach) {
    return {Number(-reach, reach), Number(-reach, reach), Number(-reach, reach)};
  }
  uint32_t AnyPoint() {
    return static_cast<uint32_t>(Below(state_.lattice().control_points_size() / 3));
  }

  // Random batches. Those of Change move control points: set, moved, sheared, carried or dragged.
  v1::EditBatch Batch();
  v1::EditBatch Change();
  v1::EditBatch Constrain();
  v1::EditBatch InsertKnot();

  // Another editor moves a point of the first of two lattices.
  void MoveOther();
  // Sends the batch. Returns whether it was applied; a refusal has changed nothing.
  bool Send(const v1::EditBatch& batch);
  // Checks what an edit made of the lattice that it began with, unless it is free to move other points.
  void ExpectChange(const v1::Edit& edit, const v1::LatticeState& begin);
  void ExpectHeld() const;
  // Compares points of the surface, and a point set where the scene takes any.
  void ExpectDefinition();
  // Whether the edited lattice keeps the volume, or the first of two, which then follows it.
  bool KeepsVolume(const v1::EditBatch& batch) const {
    return batch.has_keep_volume() || state_.constraints().has_volume();
  }
  bool IsFollowed(const v1::EditBatch& batch) const { return other_keeps_ && !KeepsVolume(batch); }
  // The control points of the first of two lattices.
  std::string OtherPoints() const { return other_.lattice().SerializeAsString(); }
  void ExpectVolume() {
    EXPECT_NEAR(MeasuredVolume() / 2, 1, 1e-12 + 4e-16);  // and rounding
    ++counts_["volumes kept"];
  }
  bool IsCertified() {
    v1::FoldReport report;  // of the surface
    EXPECT_OK(Call(&Scenes::CertifyFolds, For<v1::CertifyFoldsRequest>(), &report));
    return report.certified();
  }

  TemporaryFolder folder_;
  std::mt19937 random_;
  v1::LatticeState state_, before_;  // after and before the last step
  double residual_ = 0;              // of the last edit
  std::map<std::string, int> counts_;
  uint64_t sequence_ = 0;

 private:
  v1::LatticeState StateOf(uint32_t lattice);
  // The lattice of the kinds that go on outside: around a half of the box.
  v1::Lattice Half() const;
  void AddSecond();

  struct SurfacePlace {
    v1::SurfacePoint point;
    Vec3d rest;
    double weight = 1;
  };
  SurfacePlace AnyPlace();
  SurfacePlace PlaceOf(const v1::SurfacePoint& point) const;
  void AddDrag(v1::EditBatch& batch, double reach);
  void AddCarry(v1::EditBatch& batch, double reach);
  // F of the present state, by the definition.
  Vec3d Deformed(Vec3d rest) const;
  Vec3d DeformedPlace(const SurfacePlace& place) const;
  void ExpectPositions(const v1::Edit& edit, const std::vector<Vec3d>& begin);
  void ExpectTargets(const v1::DragPoints& drag);

  std::vector<Vec3d> world_;
  v1::LatticeState other_;  // the first of two lattices
  uint64_t other_sequence_ = 0;
  bool other_keeps_ = false;  // the volume
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_POINTS_RANDOM_SESSION_H_
