// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views out of range, too many views, and unknown ids. Every rpc that takes one gives the same
// refusal.
#include <cmath>
#include <functional>
#include <limits>

#include "tests/server/support/server_test.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

struct BadView {
  const char* name;
  std::function<void(v1::ViewOptions&)> spoil;
  const char* reason;
  const char* field;
  const char* message;
};

const std::vector<BadView>& BadViews() {
  using V = v1::ViewOptions;
  static const auto& rows = *new std::vector<BadView>{
      {"segments 33", [](V& v) { v.set_segments(33); }, "OUT_OF_RANGE", "segments",
       "got 33, allowed is 1 to 32"},
      {"segments -1", [](V& v) { v.set_segments(-1); }, "OUT_OF_RANGE", "segments",
       "got -1, allowed is 1 to 32"},
      {"position bits 7", [](V& v) { v.set_position_bits(7); }, "OUT_OF_RANGE", "position_bits",
       "got 7, allowed is 8 to 16"},
      {"position bits 17", [](V& v) { v.set_position_bits(17); }, "OUT_OF_RANGE", "position_bits",
       "got 17, allowed is 8 to 16"},
      {"normal bits 5", [](V& v) { v.set_normal_bits(5); }, "OUT_OF_RANGE", "normal_bits",
       "got 5, allowed is 6 to 12"},
      {"normal bits 13", [](V& v) { v.set_normal_bits(13); }, "OUT_OF_RANGE", "normal_bits",
       "got 13, allowed is 6 to 12"},
      {"drag position bits 17", [](V& v) { v.set_drag_position_bits(17); }, "OUT_OF_RANGE",
       "drag_position_bits", "got 17, allowed is 8 to 16"},
      {"drag normal bits 5", [](V& v) { v.set_drag_normal_bits(5); }, "OUT_OF_RANGE",
       "drag_normal_bits", "got 5, allowed is 6 to 12"},
      {"negative tolerance", [](V& v) { v.set_tolerance(-1); }, "OUT_OF_RANGE", "tolerance",
       "got -1, allowed is 0 or more"},
      {"no tolerance at all", [](V& v) { v.set_tolerance(std::nan("")); }, "NOT_FINITE",
       "tolerance", ""},
      {"infinite tolerance", [](V& v) { v.set_tolerance(std::numeric_limits<double>::infinity()); },
       "NOT_FINITE", "tolerance", ""},
      {"a tolerance below any grid", [](V& v) { v.set_tolerance(1e-9); }, "OUT_OF_RANGE",
       "tolerance", "16 position bits allow"},
      {"a tolerance below floats",
       [](V& v) {
         v.set_tolerance(1e-9);
         v.set_encoding(v1::ENCODING_RAW);
       },
       "OUT_OF_RANGE", "tolerance", "float32 positions allow"},
      {"a tolerance below its bits",
       [](V& v) {
         v.set_tolerance(1e-3);
         v.set_position_bits(8);
       },
       "OUT_OF_RANGE", "position_bits", "got 8, a tolerance of 0.001 needs 1"},
      {"normals of a later version", [](V& v) { v.set_normals(static_cast<v1::NormalMode>(9)); },
       "UNSUPPORTED", "normals", "value 9"},
      {"control nets", [](V& v) { v.set_encoding(v1::ENCODING_CONTROL_NETS); }, "UNSUPPORTED",
       "encoding", "does not know"},
  };
  return rows;
}

class BadViewsTest : public SceneStreamTest {
 protected:
  absl::Status UpdateStatus(const v1::GetUpdateRequest& request) {
    EventLog log;
    const absl::Status status = Update(request, log);
    EXPECT_TRUE(status.ok() || log.events.empty());
    return status;
  }
  absl::Status WatchStatus(const v1::WatchRequest& request) {
    return WatchClient(*scenes_, request).Finish();
  }
  absl::Status DeformStatus(const v1::WatchRequest& request) {
    return DeformClient(*scenes_, request).Finish();
  }
};

TEST_F(BadViewsTest, EveryRpcRefusesThemByField) {
  WatchClient watcher(*scenes_, Watch("bob"));
  watcher.ReadUpdates(1);
  for (const BadView& row : BadViews()) {
    SCOPED_TRACE(row.name);
    const Refusal refusal{
        .reason = row.reason, .field = std::string("view.") + row.field, .message = row.message};
    v1::CreateSceneRequest create = SceneRequest("another-scene");
    row.spoil(*create.mutable_default_view());
    ExpectRefusal(Create(create), {.reason = row.reason,
                                   .field = std::string("default_view.") + row.field,
                                   .message = row.message});
    v1::WatchRequest watch = Watch();
    row.spoil(*watch.mutable_view());
    ExpectRefusal(WatchStatus(watch), refusal);
    ExpectRefusal(DeformStatus(watch), refusal);
    auto update = For<v1::GetUpdateRequest>();
    row.spoil(*update.mutable_view());
    ExpectRefusal(UpdateStatus(update), refusal);
    v1::ControlWatchRequest control;
    row.spoil(*control.mutable_view());
    ExpectRefusal(Control(watcher, control), refusal);
    DeformClient client(*scenes_, Watch());
    client.ReadUntilRevision(0);
    v1::DeformRequest steer;
    row.spoil(*steer.mutable_control()->mutable_view());
    ASSERT_TRUE(client.Send(steer));
    ExpectRefusal(client.Finish(), refusal);
  }

  EXPECT_EQ(SceneCount(), 1);
  ASSERT_OK(Apply(Move(1, 62, 0.1)));
  watcher.ReadUpdates(2);
  EXPECT_EQ(watcher.log.topologies.back().segments(), 4) << "the view that it had";
}

TEST_F(BadViewsTest, MaxPointsBelowOneSegmentAreRefused) {
  const uint64_t patches = Get().patches();
  const Refusal refusal{.reason = "OUT_OF_RANGE",
                        .field = "view.max_points",
                        .message = "already needs " + std::to_string(3 * patches) + " points"};
  auto request = For<v1::GetUpdateRequest>();
  request.mutable_view()->set_max_points(3 * patches - 1);
  ExpectRefusal(UpdateStatus(request), refusal);
  v1::WatchRequest watch = Watch();
  watch.mutable_view()->set_max_points(1);
  ExpectRefusal(WatchStatus(watch), refusal);
  ExpectRefusal(DeformStatus(watch), refusal);
}

TEST_F(BadViewsTest, TheNinthViewIsRefusedUntilOneIsLetGo) {
  std::vector<std::unique_ptr<WatchClient>> watchers;
  for (int segments = 1; segments <= 8; ++segments) {
    v1::WatchRequest watch = Watch();
    watch.mutable_view()->set_segments(segments);
    watchers.push_back(std::make_unique<WatchClient>(*scenes_, watch));
    watchers.back()->ReadUpdates(1);
  }
  const Refusal refusal{.code = absl::StatusCode::kResourceExhausted,
                        .reason = "LIMIT_EXCEEDED",
                        .message = "at most 8 at a time"};
  v1::WatchRequest ninth = Watch();
  ninth.mutable_view()->set_segments(9);
  auto update = For<v1::GetUpdateRequest>();
  *update.mutable_view() = ninth.view();
  v1::ControlWatchRequest control;
  *control.mutable_view() = ninth.view();

  ExpectRefusal(WatchStatus(ninth), refusal);
  ExpectRefusal(DeformStatus(ninth), refusal);
  ExpectRefusal(UpdateStatus(update), refusal);
  EXPECT_TRUE(UpdateStatus(For<v1::GetUpdateRequest>()).ok()) << "a view that is there is shared";
  ExpectRefusal(Control(*watchers[0], control), refusal);
  ASSERT_OK(Apply(Move(1, 62, 0.1)));
  watchers[0]->ReadUpdates(2);
  EXPECT_EQ(watchers[0]->log.topologies.back().segments(), 1) << "the view that it had";

  watchers.pop_back();
  absl::Status status;
  const auto updates = [&] {  // the server notices a cancellation a little later
    status = UpdateStatus(update);
    return status.ok();
  };
  EXPECT_TRUE(Becomes(2000, updates));
}

TEST_F(BadViewsTest, UnknownIdsAreNotFound) {
  const std::string scene = "no-such-scene";
  auto points = For<v1::EvaluatePointsRequest>(scene);
  for (int i = 0; i < 3; ++i) points.mutable_world_points()->add_positions(0);
  auto topology = For<v1::GetTopologyRequest>(scene);
  topology.set_topology_id("no-such-topology");
  v1::EditBatch batch = Move(1, 0, 1);
  batch.set_scene(scene);
  const absl::Status statuses[] = {Call(&Scenes::GetScene, For<v1::GetSceneRequest>(scene)),
                                   Call(&Scenes::GetLattice, For<v1::GetLatticeRequest>(scene)),
                                   Apply(batch),
                                   Call(&Scenes::EvaluatePoints, points),
                                   DeleteScene(scene),
                                   WatchStatus(For<v1::WatchRequest>(scene)),
                                   DeformStatus(For<v1::WatchRequest>(scene)),
                                   UpdateStatus(For<v1::GetUpdateRequest>(scene)),
                                   Export(For<v1::ExportRequest>(scene)).status(),
                                   ReadAll(&Scenes::GetTopology, topology)};
  for (const absl::Status& status : statuses) {
    ExpectRefusal(status, {.code = absl::StatusCode::kNotFound,
                           .reason = "NOT_FOUND",
                           .message = "no scene with id 'no-such-scene'"});
    auto metadata = error::DetailsOf(status).metadata;
    EXPECT_EQ(metadata["kind"], "scene");
    EXPECT_EQ(metadata["id"], "no-such-scene");
  }
  topology.set_scene(kScene);
  ExpectRefusal(ReadAll(&Scenes::GetTopology, topology),
                {.code = absl::StatusCode::kNotFound,
                 .reason = "NOT_FOUND",
                 .message = "no topology with id 'no-such-topology'"});
  EXPECT_EQ(Get().revision(), 0u);
}

}  // namespace
}  // namespace latticed::testing
