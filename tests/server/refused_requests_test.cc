// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What is refused, and what a refusal leaves behind: edits that cannot be read keep their place in
// the editor's sequence; arms of later versions and missing scenes are named alike everywhere.
#include <limits>

#include "client/cpp/library/status.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "google/protobuf/unknown_field_set.h"
#include "tests/server/stream_support.h"

namespace latticed::testing {
namespace {

class RefusedRequestsTest : public StreamTest {
 protected:
  v1::EditBatch NotFinite(uint64_t sequence) const {
    v1::EditBatch batch = Move(sequence, 0, 0);
    batch.mutable_edits(0)->mutable_move_control_points()->mutable_offset()->set_x(
        std::numeric_limits<double>::quiet_NaN());
    return batch;
  }
  v1::EditBatch OfLater(uint64_t sequence) const {
    v1::EditBatch batch = Move(sequence, 0, 0);
    batch.mutable_edits(0)->clear_edit();
    AddLaterArm(*batch.mutable_edits(0));
    return batch;
  }
  uint64_t Revision() {
    grpc::ClientContext context;
    v1::GetSceneRequest request;
    request.set_scene(kScene);
    v1::Scene scene;
    EXPECT_TRUE(scenes_->GetScene(&context, request, &scene).ok());
    return scene.revision();
  }
  static void ExpectRefused(const grpc::Status& status, grpc::StatusCode code,
                            const std::string& reason, const std::string& field) {
    const auto details = error::DetailsOf(client::FromGrpc(status));
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_EQ(details.reason, reason) << status.error_message();
    EXPECT_EQ(details.field, field) << status.error_message();
  }
  // An arm that a later version may add to a oneof.
  static void AddLaterArm(google::protobuf::Message& message) {
    message.GetReflection()->MutableUnknownFields(&message)->AddLengthDelimited(900, "later");
  }
};

constexpr auto kInvalid = grpc::StatusCode::INVALID_ARGUMENT;
constexpr char kOffset[] = "edits[0].move_control_points.offset";

TEST_F(RefusedRequestsTest, UnreadableEditsKeepTheirPlaceInTheSequence) {
  CreateScene();
  ExpectRefused(Apply(NotFinite(1)), kInvalid, "NOT_FINITE", kOffset);

  ExpectRefused(Apply(Move(1, 0, 0.1)), kInvalid, "NOT_FINITE", kOffset);
  EXPECT_EQ(Revision(), 0u);
  v1::EditResult first, again;
  ASSERT_TRUE(Apply(Move(3, 0, 0.1), &first).ok());
  ExpectRefused(Apply(NotFinite(2)), grpc::StatusCode::ABORTED, "OUT_OF_ORDER", "");
  ASSERT_TRUE(Apply(NotFinite(3), &again).ok()) << "the stored result";
  EXPECT_EQ(again.sequence(), 3u);
  EXPECT_EQ(again.revision(), first.revision());
  ExpectRefused(Apply(OfLater(4)), kInvalid, "UNSUPPORTED", "edits[0]");
  ExpectRefused(Apply(Move(4, 0, 0.1)), kInvalid, "UNSUPPORTED", "edits[0]");
  EXPECT_EQ(Revision(), 1u);
}

TEST_F(RefusedRequestsTest, AlsoInAStream) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  for (const auto& batch : {NotFinite(2), Move(2, 0, 0.1), Move(1, 0, 0.1), Move(3, 0, 0.1)}) {
    ASSERT_TRUE(client.Send(batch));
  }

  client.ReadUntil([&] { return client.log.results.size() == 4; });

  const auto& results = client.log.results;
  EXPECT_EQ(results[0].status().code(), int{kInvalid});
  EXPECT_EQ(results[1].status().SerializeAsString(), results[0].status().SerializeAsString());
  EXPECT_EQ(results[2].status().code(), int{grpc::StatusCode::ABORTED});
  EXPECT_FALSE(results[3].has_status());
  EXPECT_EQ(results[3].revision(), 1u);
}

TEST_F(RefusedRequestsTest, ArmsOfLaterVersionsAreUnsupported) {
  CreateScene();
  grpc::ClientContext evaluate, create;
  v1::EvaluatePointsRequest points;
  points.set_scene(kScene);
  AddLaterArm(points);
  v1::EvaluatePointsResponse evaluated;
  v1::CreateSceneRequest source;
  source.set_scene_id("another-scene");
  source.set_mesh(mesh_id_);
  AddLaterArm(*source.add_lattices());
  v1::Scene scene;
  DeformClient client(*scenes_);
  client.Open(Watch());
  v1::DeformRequest message;
  AddLaterArm(message);
  ASSERT_TRUE(client.Send(message));

  ExpectRefused(scenes_->EvaluatePoints(&evaluate, points, &evaluated), kInvalid, "UNSUPPORTED",
                "points");
  ExpectRefused(scenes_->CreateScene(&create, source, &scene), kInvalid, "UNSUPPORTED",
                "lattices[0]");
  ExpectRefused(client.Finish(), kInvalid, "UNSUPPORTED", "message");
}

TEST_F(RefusedRequestsTest, AMissingSceneIsNamedByStreamsToo) {
  EventLog log;
  ExpectRefused(Update({}, log), kInvalid, "INVALID_FIELD", "scene");
  grpc::ClientContext context;
  const auto watch = scenes_->Watch(&context, v1::WatchRequest());
  v1::SceneEvent event;
  EXPECT_FALSE(watch->Read(&event));
  ExpectRefused(watch->Finish(), kInvalid, "INVALID_FIELD", "scene");
  DeformClient client(*scenes_);
  client.Open({});
  ExpectRefused(client.Finish(), kInvalid, "INVALID_FIELD", "scene");
}

TEST_F(RefusedRequestsTest, MessagesAboveTheBoundAreNotTaken) {
  grpc::ClientContext context;
  v1::GetMeshRequest request;
  request.set_mesh(std::string(limits::kMaxMessageBytes, 'a'));
  v1::Mesh mesh;

  const grpc::Status status = meshes_->GetMesh(&context, request, &mesh);

  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
}

}  // namespace
}  // namespace latticed::testing
