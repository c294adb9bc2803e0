// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// set_weights through the stub: of all vertices, of some, none; its undo, restarts, and what is refused.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

// kGridObj has 3 x 3 vertices on [0,2]^2: those at x = 0 rest, those at x = 2 follow.
const std::vector<float> kGridWeights = {0, 0.5f, 1, 0, 0.5f, 1, 0, 0.5f, 1};

std::string BytesOf(const std::vector<float>& weights) {
  return {reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float)};
}

class SetWeightsTest : public SceneFixture {
 protected:
  void SetUp() override {
    Restart();
    mesh_ = Upload(kGridObj);
    ASSERT_OK(Create(SceneRequest()));
    v1::EditBatch lift = MoveOne("ann", ++sequence_, 0, {0, 0, 3});
    auto* all = lift.mutable_edits(0)->mutable_move_control_points();
    for (uint32_t i = 1; i < 64; ++i) all->add_indices(i);
    ASSERT_OK(Apply(lift));
  }
  void Restart() {
    const std::string mesh = mesh_;
    server_.reset();
    Options options;
    options.data_dir = folder_.Path("data");
    SceneFixture::StartServer(options);
    mesh_ = mesh;
  }
  v1::EditBatch Batch() {
    v1::EditBatch batch = MoveOne("ann", ++sequence_, 0, {});
    batch.set_structure_id(Get().structure_id());
    batch.clear_edits();
    return batch;
  }
  v1::EditBatch All(const std::vector<float>& weights) {
    v1::EditBatch batch = Batch();
    batch.add_edits()->mutable_set_weights()->set_values(BytesOf(weights));
    return batch;
  }
  v1::EditBatch Some(const std::vector<uint32_t>& vertices, const std::vector<float>& weights) {
    v1::EditBatch batch = Batch();
    auto& some = *batch.add_edits()->mutable_set_weights()->mutable_some();
    some.mutable_indices()->Add(vertices.begin(), vertices.end());
    some.set_values(BytesOf(weights));
    return batch;
  }
  v1::EditBatch Clear() {
    v1::EditBatch batch = Batch();
    batch.add_edits()->mutable_set_weights()->set_clear(true);
    return batch;
  }
  absl::Status Undo() { return Apply(UndoMine("ann", ++sequence_)); }
  absl::Status Redo() {
    v1::EditBatch batch = Batch();
    batch.add_edits()->mutable_redo();
    return Apply(batch);
  }
  // The heights of the vertices over 3, which are their weights.
  std::vector<float> Weights() {
    auto request = For<v1::EvaluatePointsRequest>();
    for (uint32_t face = 0; face < 4; ++face) {  // corner c of face f is 4 f + c
      for (uint32_t c = 0; c < 3; ++c) {
        auto& point = *request.mutable_surface_points()->add_points();
        point.set_face(face);
        for (uint32_t k = 0; k < 3; ++k) {
          point.add_corners(4 * face + k);
          point.add_barycentrics(k == c ? 1 : 0);
        }
      }
    }
    v1::EvaluatePointsResponse response;
    EXPECT_OK(Call(&Scenes::EvaluatePoints, request, &response));
    std::vector<float> weights(9, -1);
    const std::vector<uint32_t> vertices = {0, 1, 4, 1, 2, 5, 3, 4, 7, 4, 5, 8};
    for (size_t n = 0; n < vertices.size(); ++n) {
      weights[vertices[n]] =
          static_cast<float>(response.positions(3 * static_cast<int>(n) + 2) / 3);
    }
    weights.erase(weights.begin() + 6);  // no triangle above has it
    return weights;
  }
  static std::vector<float> Seen(std::vector<float> weights) {
    weights.erase(weights.begin() + 6);
    return weights;
  }

  TemporaryFolder folder_;
  uint64_t sequence_ = 0;
};

TEST_F(SetWeightsTest, TheyAreSetInPartAndClearedAndUndone) {
  EXPECT_FALSE(Get().weighted());
  ASSERT_OK(Apply(All(kGridWeights)));
  EXPECT_TRUE(Get().weighted());
  EXPECT_EQ(Get().structure_id(), 2u);
  EXPECT_EQ(Weights(), Seen(kGridWeights));
  std::vector<float> changed = kGridWeights;
  changed[4] = 0.25f;
  changed[8] = 0.75f;
  ASSERT_OK(Apply(Some({8, 4}, {0.75f, 0.25f})));
  EXPECT_EQ(Weights(), Seen(changed));
  ASSERT_OK(Apply(Clear()));
  EXPECT_FALSE(Get().weighted());
  EXPECT_EQ(Weights(), std::vector<float>(8, 1));

  ASSERT_OK(Undo());
  EXPECT_EQ(Weights(), Seen(changed));
  ASSERT_OK(Undo());
  EXPECT_EQ(Weights(), Seen(kGridWeights));
  ASSERT_OK(Redo());
  EXPECT_EQ(Weights(), Seen(changed));
  ASSERT_OK(Undo());
  ASSERT_OK(Undo());
  EXPECT_FALSE(Get().weighted());
  EXPECT_GT(Get().structure_id(), 7u);  // each made another plan
}

TEST_F(SetWeightsTest, SomeOfASceneWithoutAreOfOnes) {
  ASSERT_OK(Apply(Some({0}, {0.5f})));
  std::vector<float> expected(8, 1);
  expected[0] = 0.5f;
  EXPECT_EQ(Weights(), expected);
}

TEST_F(SetWeightsTest, ARestartKeepsThem) {
  ASSERT_OK(Apply(All(kGridWeights)));
  ASSERT_OK(Apply(Some({4}, {0.25f})));
  const auto before = Weights();
  const std::string ply = Ply();

  Restart();

  EXPECT_EQ(Weights(), before);
  EXPECT_EQ(Ply(), ply);
  ASSERT_OK(Undo());
  EXPECT_EQ(Weights(), Seen(kGridWeights));
  ASSERT_OK(Undo());
  EXPECT_FALSE(Get().weighted());
}

TEST_F(SetWeightsTest, ManyStepsAreInASnapshotToo) {
  for (int n = 0; n < 70; ++n) ASSERT_OK(Apply(Some({4}, {static_cast<float>(n) / 100})));
  const auto before = Weights();
  Restart();
  EXPECT_EQ(Weights(), before);
  ASSERT_OK(Undo());
  EXPECT_NEAR(Weights()[4], 0.68, 1e-6);
}

TEST_F(SetWeightsTest, OtherEditorsUndoTheirMoves) {
  ASSERT_OK(Apply(Move("bob", 1, 21, 0.25)));
  const double moved = Lattice().lattice().control_points(3 * 21);
  ASSERT_OK(Apply(All(kGridWeights)));
  ASSERT_OK(Apply(UndoMine("bob", 2)));
  EXPECT_EQ(Lattice().lattice().control_points(3 * 21), moved - 0.25);
  EXPECT_EQ(Weights(), Seen(kGridWeights));
}

TEST_F(SetWeightsTest, TopologyTellsVerticesAndWeights) {
  ASSERT_OK(Apply(All(kGridWeights)));
  EventLog log;
  ASSERT_OK(Update(3, kScene, &log));
  auto request = For<v1::GetTopologyRequest>();
  request.set_topology_id(log.topologies.back().topology_id());
  std::vector<v1::TopologyPart> parts;
  ASSERT_OK(ReadAll(&Scenes::GetTopology, request, &parts));
  ASSERT_EQ(parts.size(), 1u);
  const v1::TopologyPart& part = parts[0];
  ASSERT_EQ(part.vertices_size(), part.corners_size());
  ASSERT_EQ(part.weights_size(), part.corners_size());
  const std::vector<uint32_t> of_corner = {0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7};
  for (int n = 0; n < part.corners_size(); ++n) {
    EXPECT_EQ(part.vertices(n), of_corner[part.corners(n)]);
    EXPECT_EQ(part.weights(n), kGridWeights[part.vertices(n)]);
  }
}

TEST_F(SetWeightsTest, BadOnesAreRefusedAndChangeNothing) {
  const auto refused = [&](const v1::EditBatch& batch, const std::string& reason,
                           const std::string& field) {
    ExpectRefused(Apply(batch), Code::kInvalidArgument, reason, "edits[0].set_weights" + field);
  };
  refused(All({0.5f}), "INVALID_FIELD", ".values");
  refused(All({}), "INVALID_FIELD", ".values");
  std::vector<float> bad = kGridWeights;
  for (const float w : {-0.5f, 1.5f, std::numeric_limits<float>::quiet_NaN()}) {
    bad[3] = w;
    refused(All(bad), "OUT_OF_RANGE", ".values");
    refused(Some({3}, {w}), "OUT_OF_RANGE", ".values");
  }
  refused(Some({3, 4}, {0.5f}), "INVALID_FIELD", ".values");
  refused(Some({9}, {0.5f}), "OUT_OF_RANGE", ".some.indices");
  refused(Some({3, 3}, {0.5f, 0.5f}), "INVALID_FIELD", ".some.indices");
  refused(Some({}, {}), "INVALID_FIELD", ".some.indices");
  v1::EditBatch odd = All(kGridWeights);
  odd.mutable_edits(0)->mutable_set_weights()->mutable_values()->pop_back();
  refused(odd, "INVALID_FIELD", ".values");
  v1::EditBatch unset = Batch();
  unset.add_edits()->mutable_set_weights();
  refused(unset, "INVALID_FIELD", "");
  v1::EditBatch uncleared = Clear();
  uncleared.mutable_edits(0)->mutable_set_weights()->set_clear(false);
  refused(uncleared, "INVALID_FIELD", ".clear");
  v1::EditBatch together = All(kGridWeights);
  *together.add_edits() = together.edits(0);
  refused(together, "INVALID_FIELD", "");
  EXPECT_FALSE(Get().weighted());
  EXPECT_EQ(Get().revision(), 1u);
  EXPECT_EQ(Get().structure_id(), 1u);
}

TEST_F(SetWeightsTest, AViewOfPatchesTakesThem) {
  v1::CreateSceneRequest request = SceneRequest("other-scene");
  request.mutable_default_view()->set_encoding(v1::ENCODING_PATCHES);
  ASSERT_OK(Create(request));
  v1::EditBatch batch = All(kGridWeights);
  batch.set_scene("other-scene");
  batch.set_structure_id(1);
  ASSERT_OK(Apply(batch));
  EXPECT_TRUE(Get("other-scene").weighted());
}

TEST_F(SetWeightsTest, AnEditThatRefusesFoldsSetsThemToo) {
  for (const float w : {0.5f, 0.25f}) {
    v1::EditBatch batch = Some({4}, {w});
    batch.set_refuse_folds(true);
    ASSERT_OK(Apply(batch));
    EXPECT_NEAR(Weights()[4], w, 1e-6);
  }
}

TEST_F(SetWeightsTest, TheVolumeIsKeptByTheNextEdit) {
  mesh_ = Upload(CubeObj());
  ASSERT_OK(Create(SceneRequest("cube-scene")));
  v1::EditBatch keep = Batch();
  keep.set_scene("cube-scene");
  keep.set_structure_id(1);
  keep.add_edits()->mutable_set_constraints()->mutable_constraints()->mutable_volume();
  ASSERT_OK(Apply(keep));
  v1::EditBatch batch = Some({4}, {0.5f});
  batch.set_scene("cube-scene");
  batch.set_structure_id(1);
  ASSERT_OK(Apply(batch));
  v1::EditBatch move = Move("ann", ++sequence_, 21, 0.25);
  move.set_scene("cube-scene");
  move.set_structure_id(2);
  ASSERT_OK(Apply(move));
  EXPECT_NEAR(MeasuredVolume("cube-scene"), 1, 1e-12);
}

TEST_F(SetWeightsTest, WatchesGoOn) {
  v1::WatchRequest coarse = For<v1::WatchRequest>();
  coarse.mutable_view()->set_segments(2);
  v1::WatchRequest patches = For<v1::WatchRequest>();
  patches.mutable_view()->set_encoding(v1::ENCODING_PATCHES);
  WatchClient kept(*scenes_, coarse), evaluated(*scenes_, patches);
  kept.ReadUpdates(1);
  evaluated.ReadUpdates(1);
  ASSERT_OK(Apply(All(kGridWeights)));
  kept.ReadUntilRevision(2);
  evaluated.ReadUntilRevision(2);
  EXPECT_EQ(evaluated.log.topologies.size(), 2u);
}

}  // namespace
}  // namespace latticed::testing
