// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Refused requests. An edit that cannot be read keeps its place in the editor's sequence. Oneof fields of
// later versions and missing scenes are refused alike by every call.
#include <limits>

#include "google/protobuf/unknown_field_set.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

class RefusedRequestsTest : public SceneStreamTest {
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
  // Adds a field that a later version may add to a oneof.
  static void AddLaterArm(google::protobuf::Message& message) {
    message.GetReflection()->MutableUnknownFields(&message)->AddLengthDelimited(900, "later");
  }
};

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
constexpr char kOffset[] = "edits[0].move_control_points.offset";

TEST_F(RefusedRequestsTest, UnreadableEditsKeepTheirPlaceInTheSequence) {
  ExpectRefused(Apply(NotFinite(1)), kInvalid, "NOT_FINITE", kOffset);

  ExpectRefused(Apply(Move(1, 0, 0.1)), kInvalid, "NOT_FINITE", kOffset);
  EXPECT_EQ(Get().revision(), 0u);
  v1::EditResult first, again;
  ASSERT_OK(Apply(Move(3, 0, 0.1), &first));
  ExpectRefused(Apply(NotFinite(2)), absl::StatusCode::kAborted, "OUT_OF_ORDER");
  ASSERT_OK(Apply(NotFinite(3), &again)) << "the stored result";
  EXPECT_EQ(again.sequence(), 3u);
  EXPECT_EQ(again.revision(), first.revision());
  ExpectRefused(Apply(OfLater(4)), kInvalid, "UNSUPPORTED", "edits[0]");
  ExpectRefused(Apply(Move(4, 0, 0.1)), kInvalid, "UNSUPPORTED", "edits[0]");
  EXPECT_EQ(Get().revision(), 1u);
}

TEST_F(RefusedRequestsTest, AlsoInAStream) {
  DeformClient client(*scenes_, Watch());
  v1::EditBatch elsewhere = Move(4, 0, 0.1);
  elsewhere.set_scene("another-scene");
  for (const auto& batch :
       {NotFinite(2), Move(2, 0, 0.1), Move(1, 0, 0.1), Move(3, 0, 0.1), elsewhere}) {
    ASSERT_TRUE(client.Send(batch));
  }

  client.ReadUntil([&] { return client.log.results.size() == 5; });

  const auto& results = client.log.results;
  EXPECT_EQ(results[0].status().code(), int{grpc::StatusCode::INVALID_ARGUMENT});
  EXPECT_EQ(results[1].status().SerializeAsString(), results[0].status().SerializeAsString());
  EXPECT_EQ(results[2].status().code(), int{grpc::StatusCode::ABORTED});
  EXPECT_FALSE(results[3].has_status());
  EXPECT_EQ(results[3].revision(), 1u);
  EXPECT_EQ(results[4].status().code(), int{grpc::StatusCode::INVALID_ARGUMENT});
}

TEST_F(RefusedRequestsTest, ArmsOfLaterVersionsAreUnsupported) {
  auto points = For<v1::EvaluatePointsRequest>();
  AddLaterArm(points);
  v1::CreateSceneRequest source = SceneRequest("another-scene");
  AddLaterArm(*source.add_lattices());
  DeformClient client(*scenes_, Watch());
  v1::DeformRequest message;
  AddLaterArm(message);
  ASSERT_TRUE(client.Send(message));

  ExpectRefused(Call(&Scenes::EvaluatePoints, points), kInvalid, "UNSUPPORTED", "points");
  ExpectRefused(Create(source), kInvalid, "UNSUPPORTED", "lattices[0]");
  ExpectRefused(client.Finish(), kInvalid, "UNSUPPORTED", "message");
}

TEST_F(RefusedRequestsTest, AMissingSceneIsNamedByStreamsToo) {
  EventLog log;
  ExpectRefused(Update({}, log), kInvalid, "INVALID_FIELD", "scene");
  ExpectRefused(ReadAll(&Scenes::Watch, {}), kInvalid, "INVALID_FIELD", "scene");
  DeformClient client(*scenes_, {});
  ExpectRefused(client.Finish(), kInvalid, "INVALID_FIELD", "scene");
}

}  // namespace
}  // namespace latticed::testing
