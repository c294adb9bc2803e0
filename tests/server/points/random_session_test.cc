// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A client's random session: edits, refused folds, constraints, kept volumes, knots, undo and redo, point sets, and restarts
// of the server on its folder. After each step the test compares with a model:
//
//   a refused batch       changes nothing, and each restart neither
//   undo and redo         bring back the lattice and the constraints that the model has, bit by bit
//   held control points   do not move
//   a kept volume         is kept to 1e-12 of it
//   refuse_folds          leaves a certified scene certified
//   a point set           has the positions of the definition
//
// LATTICED_SEED sets the seed of the random numbers.
#include <cstdlib>
#include <map>
#include <random>
#include <set>

#include "core/ffd/direct_ffd.h"
#include "server/wire/converters.h"
#include "tests/server/points/point_set_client.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

constexpr int kRandomSessions = 6, kSessionSteps = 40, kMostKnots = 3;
// A closed box of volume 2.
constexpr char kSessionBoxObj[] =
    "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 0 0 1\nv 2 0 1\nv 2 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

// What undo brings back.
struct Undoable {
  std::string lattice, constraints;  // serialised
  friend bool operator==(const Undoable&, const Undoable&) = default;
};

Undoable UndoableOf(const v1::LatticeState& state) {
  return {state.lattice().SerializeAsString(), state.constraints().SerializeAsString()};
}

Vec3d ControlPoint(const v1::LatticeState& state, uint32_t i) {
  const auto at = static_cast<int>(3 * i);
  const auto& points = state.lattice().control_points();
  return {points[at], points[at + 1], points[at + 2]};
}

class RandomSession : public SceneFixture, public ::testing::WithParamInterface<int> {
 protected:
  void SetUp() override {
    const char* const given = std::getenv("LATTICED_SEED");
    const auto seed = static_cast<uint32_t>(given == nullptr ? 2'600 : std::atoi(given)) +
                      static_cast<uint32_t>(GetParam());
    RecordProperty("seed", static_cast<int>(seed));
    std::printf("seed %u\n", seed);
    random_.seed(seed);
    Restart();
    mesh_ = Upload(kSessionBoxObj);
    ASSERT_OK(Create(SceneRequest()));
    state_ = Lattice();
    for (int i = 0; i < 60; ++i)
      world_.push_back({Number(-0.3, 2.3), Number(-0.3, 1.3), Number(-0.3, 1.3)});
  }
  void Restart() {
    server_.reset();
    Options options;
    options.data_dir = folder_.Path("data");
    SceneFixture::StartServer(options);
  }

  int Below(int end) { return std::uniform_int_distribution<int>(0, end - 1)(random_); }
  double Number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  uint32_t AnyPoint() {
    return static_cast<uint32_t>(Below(state_.lattice().control_points_size() / 3));
  }
  v1::LatticeAxis AnyAxis() { return static_cast<v1::LatticeAxis>(1 + Below(3)); }

  v1::EditBatch Batch() {
    v1::EditBatch batch;
    batch.set_scene(kScene);
    batch.set_editor_id("ann");
    batch.set_sequence(++sequence_);
    batch.set_structure_id(state_.structure_id());
    batch.add_edits();
    return batch;
  }
  v1::EditBatch MoveSome() {
    v1::EditBatch batch = Batch();
    std::set<uint32_t> indices;
    for (int i = Below(3); i >= 0; --i) indices.insert(AnyPoint());
    const double reach = Below(6) == 0 ? 1.5 : 0.15;  // some fold
    const int kind = Below(4);
    if (kind == 0) {
      auto& shear = *batch.mutable_edits(0)->mutable_transform_control_points();
      shear.mutable_indices()->Add(indices.begin(), indices.end());
      const double slope = Number(-reach, reach), offset = Number(-reach, reach);
      for (const double m :
           {1., 0., 0., 0., slope, 1., 0., 0., 0., 0., 1., 0., offset, 0., 0., 1.}) {
        shear.add_matrix(m);
      }
    } else if (kind == 1) {
      auto& set = *batch.mutable_edits(0)->mutable_set_control_points();
      for (const uint32_t i : indices) {
        set.add_indices(i);
        for (int a = 0; a < 3; ++a) {
          set.add_positions(ControlPoint(state_, i)[a] + Number(-reach, reach));
        }
      }
    } else {
      auto& move = *batch.mutable_edits(0)->mutable_move_control_points();
      move.mutable_indices()->Add(indices.begin(), indices.end());
      *move.mutable_offset() =
          ToVec3({Number(-reach, reach), Number(-reach, reach), Number(-reach, reach)});
    }
    batch.set_refuse_folds(Below(3) == 0);
    if (Below(4) == 0) batch.mutable_keep_volume();
    return batch;
  }
  v1::EditBatch Constrain() {
    v1::EditBatch batch = Batch();
    auto& constraints = *batch.mutable_edits(0)->mutable_set_constraints();
    if (Below(4) == 0) return batch;  // none
    auto& kept = *constraints.mutable_constraints();
    kept.add_held(AnyPoint());
    if (Below(2) == 0) {
      auto& layers = *kept.add_held_layers();
      layers.set_axis(AnyAxis());
      layers.set_at_end(Below(2) == 0);
      layers.set_layers(1);
    }
    if (Below(2) == 0) kept.mutable_volume();
    return batch;
  }
  v1::EditBatch InsertKnot() {
    v1::EditBatch batch = Batch();
    batch.mutable_edits(0)->mutable_insert_knot()->set_axis(AnyAxis());
    batch.mutable_edits(0)->mutable_insert_knot()->set_value(Number(0.05, 0.95));
    return batch;
  }

  double Volume() {
    auto request = For<v1::MeasureSceneRequest>();
    request.add_measures(v1::MEASURE_VOLUME);
    v1::MeasureSceneResponse response;
    EXPECT_OK(Call(&Scenes::MeasureScene, request, &response));
    return response.volume();
  }
  bool IsCertified() {
    auto request = For<v1::CertifyFoldsRequest>();
    request.set_scope(v1::FOLD_SCOPE_SURFACE);
    v1::FoldReport report;
    EXPECT_OK(Call(&Scenes::CertifyFolds, request, &report));
    return report.certified();
  }
  // Sends the batch. Returns whether it was applied; a refusal has changed nothing.
  bool Send(const v1::EditBatch& batch) {
    const absl::Status status = Apply(batch);
    before_ = std::exchange(state_, Lattice());
    if (status.ok()) {
      EXPECT_EQ(state_.revision(), before_.revision() + 1);
    } else {
      EXPECT_EQ(state_.SerializeAsString(), before_.SerializeAsString()) << status;
    }
    ++counts_[status.ok() ? "applied" : Reason(status)];
    return status.ok();
  }
  void ExpectHeld() const {
    for (const uint32_t i : before_.constraints().held()) {
      EXPECT_EQ(ControlPoint(state_, i), ControlPoint(before_, i)) << "held " << i;
    }
  }
  void ExpectDefinition() {
    PointSetClient client(server_->channel());
    ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client.CreateWorld(world_));
    ASSERT_OK_AND_ASSIGN(const auto deformed, client.Deform(set));
    ASSERT_OK(client.Delete(set.id()));
    EXPECT_EQ(deformed.header.revision(), state_.revision());
    ASSERT_OK_AND_ASSIGN(const LatticeStructure structure,
                         StructureFromProto(state_.lattice(), ""));
    std::vector<Vec3d> control_points;
    for (uint32_t i = 0; i < static_cast<uint32_t>(structure.control_point_count()); ++i) {
      control_points.push_back(ControlPoint(state_, i));
    }
    for (size_t i = 0; i < world_.size(); ++i) {
      const Vec3d expected = EvaluateWorld(structure, control_points, world_[i]).position;
      ASSERT_LE(Norm(deformed.vectors[i] - expected), 1e-13) << i;
    }
  }

  void TakeStep() {
    switch (Below(12)) {
      case 0:
      case 1:
        return UndoOrRedo(/*undo=*/Below(3) != 0);
      case 2:
        if (Send(Constrain())) Done();
        return;
      case 3:
        if (knots_ < kMostKnots && Send(InsertKnot())) ++knots_, Done();
        return;
      case 4: {
        const std::string state = state_.SerializeAsString();
        Restart();
        EXPECT_EQ(Lattice().SerializeAsString(), state) << "a restart changes nothing";
        ++counts_["restarts"];
        return;
      }
      default:
        return Edit();
    }
  }
  void Edit() {
    const v1::EditBatch batch = MoveSome();
    const bool certified = IsCertified();
    if (!Send(batch)) return;
    Done();
    ExpectHeld();
    if (batch.has_keep_volume() || state_.constraints().has_volume()) {
      EXPECT_NEAR(Volume() / 2, 1, 1e-12 + 4e-16);  // and rounding
      ++counts_["volumes kept"];
    }
    if (batch.refuse_folds() && certified) {
      EXPECT_TRUE(IsCertified());
    }
  }
  void Done() {
    undone_.clear();
    done_.push_back(UndoableOf(before_));
  }
  void UndoOrRedo(bool undo) {
    std::vector<Undoable>&from = undo ? done_ : undone_, &to = undo ? undone_ : done_;
    v1::EditBatch batch = Batch();
    if (undo) {
      batch.mutable_edits(0)->mutable_undo();
    } else {
      batch.mutable_edits(0)->mutable_redo();
    }
    ASSERT_EQ(Send(batch), !from.empty());
    if (from.empty()) return;
    EXPECT_EQ(UndoableOf(state_), from.back()) << (undo ? "undo" : "redo");
    to.push_back(UndoableOf(before_));
    from.pop_back();
    ++counts_[undo ? "undone" : "redone"];
  }

  TemporaryFolder folder_;
  std::mt19937 random_;
  v1::LatticeState state_, before_;      // after and before the last step
  std::vector<Undoable> done_, undone_;  // what undo and redo bring back
  std::vector<Vec3d> world_;
  std::map<std::string, int> counts_;
  uint64_t sequence_ = 0;
  int knots_ = 0;
};

TEST_P(RandomSession, KeepsWhatItPromises) {
  for (int step = 0; step < kSessionSteps && !HasFailure(); ++step) {
    SCOPED_TRACE(step);
    TakeStep();
    if (step % 4 == 3) ExpectDefinition();
  }
  for (const auto& [what, count] : counts_) std::printf("%s: %d\n", what.c_str(), count);
  EXPECT_GE(counts_["applied"], kSessionSteps / 3);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomSession, ::testing::Range(0, kRandomSessions));

}  // namespace
}  // namespace latticed::testing
