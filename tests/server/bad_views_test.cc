// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views out of range, too many views, and ids of nothing: refused alike by every rpc that takes
// one.
#include <functional>

#include "tests/server/refusal.h"
#include "tests/server/watch_client.h"
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
      {"normals of a later version", [](V& v) { v.set_normals(static_cast<v1::NormalMode>(9)); },
       "UNSUPPORTED", "normals", "value 9"},
      {"control nets", [](V& v) { v.set_encoding(v1::ENCODING_CONTROL_NETS); }, "UNSUPPORTED",
       "encoding", "does not know"},
  };
  return rows;
}

class BadViewsTest : public StreamTest {
 protected:
  void SetUp() override {
    StreamTest::SetUp();
    CreateScene();
  }

  static v1::GetUpdateRequest UpdateRequest() {
    v1::GetUpdateRequest request;
    request.set_scene(kScene);
    return request;
  }
  grpc::Status UpdateStatus(const v1::GetUpdateRequest& request) {
    EventLog log;
    const grpc::Status status = Update(request, log);
    EXPECT_TRUE(status.ok() || log.events.empty());
    return status;
  }
  grpc::Status WatchStatus(const v1::WatchRequest& request) {
    WatchClient watcher(*scenes_, request);
    return watcher.Finish();
  }
  grpc::Status DeformStatus(const v1::WatchRequest& request) {
    DeformClient client(*scenes_);
    client.Open(request);
    return client.Finish();
  }
  grpc::Status Control(const v1::ControlWatchRequest& request) {
    grpc::ClientContext context;
    v1::ControlWatchResponse response;
    return scenes_->ControlWatch(&context, request, &response);
  }
  v1::Scene Scene() {
    grpc::ClientContext context;
    v1::GetSceneRequest request;
    request.set_scene(kScene);
    v1::Scene scene;
    EXPECT_TRUE(scenes_->GetScene(&context, request, &scene).ok());
    return scene;
  }
};

TEST_F(BadViewsTest, EveryRpcRefusesThemByField) {
  WatchClient watcher(*scenes_, Watch("bob"));
  watcher.ReadUpdates(1);
  for (const BadView& row : BadViews()) {
    SCOPED_TRACE(row.name);
    const Refusal refusal{
        .reason = row.reason, .field = std::string("view.") + row.field, .message = row.message};
    v1::CreateSceneRequest create;
    create.set_scene_id("another-scene");
    create.set_mesh(Scene().mesh());
    row.spoil(*create.mutable_default_view());
    v1::Scene scene;
    grpc::ClientContext context;
    ExpectRefusal(scenes_->CreateScene(&context, create, &scene),
                  {.reason = row.reason,
                   .field = std::string("default_view.") + row.field,
                   .message = row.message});
    v1::WatchRequest watch = Watch();
    row.spoil(*watch.mutable_view());
    ExpectRefusal(WatchStatus(watch), refusal);
    ExpectRefusal(DeformStatus(watch), refusal);
    v1::GetUpdateRequest update = UpdateRequest();
    row.spoil(*update.mutable_view());
    ExpectRefusal(UpdateStatus(update), refusal);
    v1::ControlWatchRequest control;
    control.set_watch_id(watcher.log.hello.watch_id());
    row.spoil(*control.mutable_view());
    ExpectRefusal(Control(control), refusal);
    DeformClient client(*scenes_);
    client.Open(Watch());
    client.ReadUntilRevision(0);
    v1::DeformRequest steer;
    row.spoil(*steer.mutable_control()->mutable_view());
    ASSERT_TRUE(client.Send(steer));
    ExpectRefusal(client.Finish(), refusal);
  }

  grpc::ClientContext context;
  v1::ListScenesResponse scenes;
  ASSERT_TRUE(scenes_->ListScenes(&context, {}, &scenes).ok());
  EXPECT_EQ(scenes.scenes_size(), 1);
  ASSERT_TRUE(Apply(Move(1, 62, 0.1)).ok());
  watcher.ReadUpdates(2);
  EXPECT_EQ(watcher.log.topologies.back().segments(), 4) << "the view that it had";
}

TEST_F(BadViewsTest, MaxPointsBelowOneSegmentAreRefused) {
  const uint64_t patches = Scene().patches();
  const Refusal refusal{.reason = "OUT_OF_RANGE",
                        .field = "view.max_points",
                        .message = std::to_string(3 * patches) + " points already"};
  v1::GetUpdateRequest request = UpdateRequest();
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
  v1::GetUpdateRequest update = UpdateRequest();
  *update.mutable_view() = ninth.view();
  v1::ControlWatchRequest control;
  control.set_watch_id(watchers[0]->log.hello.watch_id());
  *control.mutable_view() = ninth.view();

  ExpectRefusal(WatchStatus(ninth), refusal);
  ExpectRefusal(DeformStatus(ninth), refusal);
  ExpectRefusal(UpdateStatus(update), refusal);
  EXPECT_TRUE(UpdateStatus(UpdateRequest()).ok()) << "a view that is there is shared";
  ExpectRefusal(Control(control), refusal);
  ASSERT_TRUE(Apply(Move(1, 62, 0.1)).ok());
  watchers[0]->ReadUpdates(2);
  EXPECT_EQ(watchers[0]->log.topologies.back().segments(), 1) << "the view that it had";

  watchers.pop_back();
  grpc::Status status;
  const auto updates = [&] {  // the server hears of a cancellation a little later
    status = UpdateStatus(update);
    return status.ok();
  };
  EXPECT_TRUE(Becomes(2000, updates)) << status.error_message();
}

TEST_F(BadViewsTest, UnknownIdsAreNotFound) {
  const Refusal refusal{.code = absl::StatusCode::kNotFound,
                        .reason = "NOT_FOUND",
                        .message = "no scene with id 'no-such-scene'"};
  const auto expect = [&](const auto& call) {
    grpc::ClientContext context;
    const grpc::Status status = call(&context);
    ExpectRefusal(status, refusal);
    auto metadata = error::DetailsOf(client::FromGrpc(status)).metadata;
    EXPECT_EQ(metadata["kind"], "scene");
    EXPECT_EQ(metadata["id"], "no-such-scene");
  };
  const auto unknown = [](auto request) {
    request.set_scene("no-such-scene");
    return request;
  };
  const auto read_all = [](const auto& reader, auto message) {
    while (reader->Read(&message)) ADD_FAILURE() << "a message";
    return reader->Finish();
  };
  expect([&](auto* context) {
    v1::Scene scene;
    return scenes_->GetScene(context, unknown(v1::GetSceneRequest()), &scene);
  });
  expect([&](auto* context) {
    v1::LatticeState state;
    return scenes_->GetLattice(context, unknown(v1::GetLatticeRequest()), &state);
  });
  expect([&](auto* context) {
    v1::EditResult result;
    return scenes_->ApplyEdits(context, unknown(Move(1, 0, 1)), &result);
  });
  expect([&](auto* context) {
    v1::EvaluatePointsRequest request = unknown(v1::EvaluatePointsRequest());
    for (int i = 0; i < 3; ++i) request.mutable_world_points()->add_positions(0);
    v1::EvaluatePointsResponse response;
    return scenes_->EvaluatePoints(context, request, &response);
  });
  expect([&](auto* context) {
    v1::DeleteSceneResponse response;
    return scenes_->DeleteScene(context, unknown(v1::DeleteSceneRequest()), &response);
  });
  expect([&](auto*) { return WatchStatus(unknown(Watch())); });
  expect([&](auto*) { return DeformStatus(unknown(Watch())); });
  expect([&](auto*) { return UpdateStatus(unknown(UpdateRequest())); });
  expect([&](auto* context) {
    return read_all(scenes_->Export(context, unknown(v1::ExportRequest())), v1::ExportResponse());
  });
  v1::GetTopologyRequest topology;
  topology.set_topology_id("no-such-topology");
  expect([&](auto* context) {
    return read_all(scenes_->GetTopology(context, unknown(topology)), v1::TopologyPart());
  });
  topology.set_scene(kScene);
  grpc::ClientContext context;
  ExpectRefusal(read_all(scenes_->GetTopology(&context, topology), v1::TopologyPart()),
                {.code = absl::StatusCode::kNotFound,
                 .reason = "NOT_FOUND",
                 .message = "no topology with id 'no-such-topology'"});
  EXPECT_EQ(Scene().revision(), 0u);
}

}  // namespace
}  // namespace latticed::testing
