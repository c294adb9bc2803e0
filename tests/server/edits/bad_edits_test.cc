// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bad edits in ApplyEdits and in a Deform stream. Each refusal names the field, nothing changes, and the
// stream goes on.
#include <functional>
#include <limits>
#include <thread>

#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr uint32_t kPoints = 125;  // StreamTest's lattice: degree 2, knots 0 0 0 1 2 3 3 3

v1::Edit Set(const std::vector<uint32_t>& indices, const std::vector<double>& positions) {
  v1::Edit edit;
  auto& set = *edit.mutable_set_control_points();
  set.mutable_indices()->Add(indices.begin(), indices.end());
  set.mutable_positions()->Add(positions.begin(), positions.end());
  return edit;
}

v1::Edit MoveBy(const std::vector<uint32_t>& indices, double x) {
  v1::Edit edit;
  auto& move = *edit.mutable_move_control_points();
  move.mutable_indices()->Add(indices.begin(), indices.end());
  move.mutable_offset()->set_x(x);
  return edit;
}

// Transforms by the identity matrix with one entry replaced.
v1::Edit Transform(const std::vector<uint32_t>& indices, int entry, double value) {
  v1::Edit edit;
  auto& transform = *edit.mutable_transform_control_points();
  transform.mutable_indices()->Add(indices.begin(), indices.end());
  for (int i = 0; i < 16; ++i) transform.add_matrix(i == entry ? value : i % 5 == 0 ? 1 : 0);
  return edit;
}

v1::Edit Replace(uint32_t points, double last) {
  v1::Edit edit;
  auto& all = *edit.mutable_replace_control_points()->mutable_control_points();
  for (uint32_t i = 0; i + 1 < 3 * points; ++i) all.Add(0);
  all.Add(last);
  return edit;
}

v1::Edit Knot(double value) {
  v1::Edit edit;
  edit.mutable_insert_knot()->set_axis(v1::LATTICE_AXIS_V);
  edit.mutable_insert_knot()->set_value(value);
  return edit;
}

v1::Edit Carry(const std::vector<uint32_t>& indices, double coordinate) {
  v1::Edit edit;
  auto& carry = *edit.mutable_carry_control_points();
  carry.mutable_indices()->Add(indices.begin(), indices.end());
  auto& frame = *carry.mutable_parent()->mutable_frame();
  frame.mutable_origin();
  frame.mutable_u()->set_x(1);
  frame.mutable_v()->set_y(1);
  frame.mutable_w()->set_z(1);
  for (int i = 0; i < 3 * 64; ++i) carry.mutable_parent()->add_control_points(coordinate);
  return edit;
}

v1::Edit CarryByNothing() {
  v1::Edit edit = Carry({}, 0);
  edit.mutable_carry_control_points()->clear_parent();
  return edit;
}

v1::Edit CarryByIdentity() {
  v1::Edit edit = Carry({}, 0);
  edit.mutable_carry_control_points()->mutable_parent()->clear_control_points();
  return edit;
}

v1::Edit CarryByLinear(const std::vector<double>& widths) {
  v1::Edit edit = Carry({}, 0);
  auto& outside = *edit.mutable_carry_control_points()->mutable_parent()->mutable_outside();
  outside.set_mode(v1::OUTSIDE_MODE_LINEAR);
  outside.mutable_widths()->Add(widths.begin(), widths.end());
  return edit;
}

v1::Edit NoLattice() {
  v1::Edit edit;
  edit.mutable_replace_lattice();
  return edit;
}

v1::Edit ShapeAndPoints() {
  v1::Edit edit = NoLattice();
  edit.mutable_replace_lattice()->set_keep_shape(true);
  edit.mutable_replace_lattice()->mutable_lattice()->add_control_points(1);
  return edit;
}

v1::Edit MoveWithoutOffset() {
  v1::Edit edit = MoveBy({1}, 0);
  edit.mutable_move_control_points()->clear_offset();
  return edit;
}

v1::Edit ShortMatrix() {
  v1::Edit edit = Transform({1}, 0, 1);
  edit.mutable_transform_control_points()->mutable_matrix()->RemoveLast();
  return edit;
}

struct BadEdit {
  const char* name;
  v1::Edit edit;
  const char* reason;
  const char* field;  // path below edits[n]
  const char* message;
};

const std::vector<BadEdit>& BadEdits() {
  static const auto& rows = *new std::vector<BadEdit>{
      {"nothing", {}, "INVALID_FIELD", "", "one kind of edit must be set"},
      {"set NaN", Set({1}, {0, kNan, 0}), "NOT_FINITE", ".set_control_points.positions", "finite"},
      {"set beyond float32", Set({1}, {0, 1e19, 0}), "OUT_OF_RANGE",
       ".set_control_points.positions[1]", "allowed is -1e+18 to 1e+18"},
      {"set infinity", Set({1, 2}, {0, 0, 0, 0, 0, kInfinity}), "NOT_FINITE",
       ".set_control_points.positions", "finite"},
      {"set out of range", Set({1, kPoints}, {0, 0, 0, 0, 0, 0}), "OUT_OF_RANGE",
       ".set_control_points.indices[1]", "got 125, allowed is 0 to 124"},
      {"set twice", Set({7, 8, 7}, {0, 0, 0, 0, 0, 0, 0, 0, 0}), "INVALID_FIELD",
       ".set_control_points.indices[2]", "control point 7 is named twice"},
      {"set nothing", Set({}, {}), "INVALID_FIELD", ".set_control_points.indices", "at least one"},
      {"set too few", Set({1, 2}, {0, 0, 0}), "INVALID_FIELD", ".set_control_points.positions",
       "got 1 points for 2 indices"},
      {"set a part", Set({1}, {0, 0}), "INVALID_FIELD", ".set_control_points.positions",
       "got 2 numbers"},
      {"move by NaN", MoveBy({1}, kNan), "NOT_FINITE", ".move_control_points.offset", "finite"},
      {"move by infinity", MoveBy({1}, -kInfinity), "NOT_FINITE", ".move_control_points.offset",
       "finite"},
      {"move out of range", MoveBy({4'000'000'000}, 1), "OUT_OF_RANGE",
       ".move_control_points.indices[0]", "allowed is 0 to 124"},
      {"move twice", MoveBy({3, 3}, 1), "INVALID_FIELD", ".move_control_points.indices[1]",
       "control point 3 is named twice"},
      {"move nothing", MoveBy({}, 1), "INVALID_FIELD", ".move_control_points.indices",
       "at least one"},
      {"move too many", MoveBy(std::vector<uint32_t>(32'769), 1), "OUT_OF_RANGE",
       ".move_control_points.indices", ""},
      {"move nowhere", MoveWithoutOffset(), "INVALID_FIELD", ".move_control_points.offset",
       "is required"},
      {"transform by NaN", Transform({1}, 13, kNan), "NOT_FINITE",
       ".transform_control_points.matrix", "finite"},
      {"transform by infinity", Transform({1}, 0, kInfinity), "NOT_FINITE",
       ".transform_control_points.matrix", "finite"},
      {"transform, projective", Transform({1}, 3, 0.5), "INVALID_FIELD",
       ".transform_control_points.matrix", "an affine matrix has (0, 0, 0, 1)"},
      {"transform, scaled", Transform({1}, 15, 2), "INVALID_FIELD",
       ".transform_control_points.matrix", "an affine matrix has (0, 0, 0, 1)"},
      {"transform by 15 numbers", ShortMatrix(), "INVALID_FIELD",
       ".transform_control_points.matrix", "got 15 numbers, 16 are needed"},
      {"transform out of range", Transform({kPoints}, 0, 1), "OUT_OF_RANGE",
       ".transform_control_points.indices[0]", "got 125, allowed is 0 to 124"},
      {"transform twice", Transform({0, 1, 0}, 0, 1), "INVALID_FIELD",
       ".transform_control_points.indices[2]", "control point 0 is named twice"},
      {"carry by NaN", Carry({1}, kNan), "NOT_FINITE",
       ".carry_control_points.parent.control_points", "finite"},
      {"carry by nothing", CarryByNothing(), "INVALID_FIELD", ".carry_control_points.parent",
       "must be set"},
      {"carry by an identity", CarryByIdentity(), "INVALID_FIELD",
       ".carry_control_points.parent.control_points", "an identity moves nothing"},
      {"carry by a line without widths", CarryByLinear({}), "INVALID_FIELD",
       ".carry_control_points.parent.outside.widths", "no mesh says how far"},
      {"carry by a line of widths 0", CarryByLinear({0}), "INVALID_FIELD",
       ".carry_control_points.parent.outside.widths", "no mesh says how far"},
      {"carry by a line of two widths", CarryByLinear({1, 1}), "INVALID_FIELD",
       ".carry_control_points.parent.outside.widths", "got 2 numbers"},
      {"carry out of range", Carry({kPoints}, 1), "OUT_OF_RANGE",
       ".carry_control_points.indices[0]", "got 125, allowed is 0 to 124"},
      {"carry twice", Carry({3, 3}, 1), "INVALID_FIELD", ".carry_control_points.indices[1]",
       "control point 3 is named twice"},
      {"replace by NaN", Replace(kPoints, kNan), "NOT_FINITE",
       ".replace_control_points.control_points", "finite"},
      {"replace too few", Replace(kPoints - 1, 0), "INVALID_FIELD",
       ".replace_control_points.control_points", "375 are needed"},
      {"replace too many", Replace(kPoints + 1, 0), "INVALID_FIELD",
       ".replace_control_points.control_points", "375 are needed"},
      {"replace by one number", Replace(0, 0), "INVALID_FIELD",
       ".replace_control_points.control_points", ""},
      {"no lattice", NoLattice(), "INVALID_FIELD", ".replace_lattice.lattice", "must be set"},
      {"shape and points", ShapeAndPoints(), "INVALID_FIELD",
       ".replace_lattice.lattice.control_points", "must be empty with keep_shape"},
      {"knot NaN", Knot(kNan), "NOT_FINITE", ".insert_knot.value", "finite"},
      {"knot infinity", Knot(kInfinity), "NOT_FINITE", ".insert_knot.value", "finite"},
      {"knot below", Knot(-0.5), "OUT_OF_RANGE", ".insert_knot.value",
       "got -0.5, allowed is strictly between 0 and 3"},
      {"knot at the begin", Knot(0), "OUT_OF_RANGE", ".insert_knot.value",
       "allowed is strictly between 0 and 3"},
      {"knot at the end", Knot(3), "OUT_OF_RANGE", ".insert_knot.value",
       "allowed is strictly between 0 and 3"},
  };
  return rows;
}

class BadEditsTest : public SceneStreamTest {
 protected:
  v1::EditBatch Batch(uint64_t sequence, const std::vector<v1::Edit>& edits) const {
    auto batch = For<v1::EditBatch>();
    batch.set_editor_id("alice");
    batch.set_sequence(sequence);
    batch.set_structure_id(structure_id_);
    for (const v1::Edit& edit : edits) *batch.add_edits() = edit;
    return batch;
  }

  static Refusal RefusalOf(const BadEdit& row, const std::string& edit) {
    return {.reason = row.reason, .field = edit + row.field, .message = row.message};
  }
};

TEST_F(BadEditsTest, ApplyEditsRefusesThemAndChangesNothing) {
  const std::string before = Lattice().SerializeAsString();
  uint64_t sequence = 0;
  for (const BadEdit& row : BadEdits()) {
    SCOPED_TRACE(row.name);
    ExpectRefusal(Apply(Batch(++sequence, {row.edit})), RefusalOf(row, "edits[0]"));
    EXPECT_EQ(Lattice().SerializeAsString(), before);
  }
  v1::EditResult result;
  ASSERT_OK(Apply(Batch(++sequence, {MoveBy({62}, 0.1)}), &result));
  EXPECT_EQ(result.revision(), 1u);
}

TEST_F(BadEditsTest, ABatchWhoseSecondEditIsBadChangesNothing) {
  const std::string before = Lattice().SerializeAsString();
  uint64_t sequence = 0;
  for (const BadEdit& row : BadEdits()) {
    if (row.edit.has_insert_knot() || row.edit.has_replace_lattice()) continue;
    SCOPED_TRACE(row.name);
    ExpectRefusal(Apply(Batch(++sequence, {MoveBy({62}, 0.1), row.edit})),
                  RefusalOf(row, "edits[1]"));
    EXPECT_EQ(Lattice().SerializeAsString(), before);
  }
  ExpectRefusal(Apply(Batch(++sequence, {MoveBy({62}, 0.1), Knot(0.5)})),
                {.reason = "INVALID_FIELD",
                 .field = "edits[1].insert_knot",
                 .message = "must be the only edit of its batch"});
  EXPECT_EQ(Lattice().SerializeAsString(), before);
}

TEST_F(BadEditsTest, DeformAnswersThemAndGoesOn) {
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);
  uint64_t sequence = 0;
  for (const BadEdit& row : BadEdits()) {
    SCOPED_TRACE(row.name);
    ASSERT_TRUE(client.Send(Batch(++sequence, {row.edit})));
    client.ReadUntil([&] { return client.log.results.size() == sequence; });
    const v1::EditResult& result = client.log.results.back();
    ExpectRefusal(client::FromRpc(result.status()), RefusalOf(row, "edits[0]"));
    EXPECT_EQ(result.sequence(), sequence);
    EXPECT_EQ(result.revision(), 0u);
  }
  ASSERT_TRUE(client.Send(Batch(++sequence, {MoveBy({62}, 0.1)})));
  client.ReadUntilRevision(1);

  EXPECT_EQ(client.log.results.back().status().code(), 0);
  EXPECT_EQ(client.log.deltas, 1u) << "refused edits move no cage";
  client.HalfClose();
  EXPECT_TRUE(client.Finish().ok());
}

// Workers handle knots and then ask for the next message. Other edits are handled where they are read.
TEST_F(BadEditsTest, DeformReadsOnBehindAnEditOnAWorker) {
  constexpr uint64_t kEdits = 2000;
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);
  std::thread sender([&] {
    for (uint64_t i = 1; i <= kEdits; ++i)
      client.Send(Batch(i, {i % 2 == 0 ? Knot(kNan) : MoveBy({}, 1)}));
  });

  client.ReadUntil([&] { return client.log.results.size() == kEdits; });
  sender.join();

  for (uint64_t i = 0; i < kEdits; ++i) ASSERT_EQ(client.log.results[i].sequence(), i + 1);
  client.HalfClose();
  EXPECT_TRUE(client.Finish().ok());
}

TEST_F(BadEditsTest, AKnotIsInsertedAtMostDegreeTimes) {
  v1::EditResult result;
  ASSERT_OK(Apply(Batch(1, {Knot(0.5)}), &result));
  structure_id_ = result.structure_id();
  ASSERT_OK(Apply(Batch(2, {Knot(0.5)}), &result));
  structure_id_ = result.structure_id();
  const std::string before = Lattice().SerializeAsString();

  const Refusal refusal{.reason = "INVALID_FIELD",
                        .field = "edits[0].insert_knot.value",
                        .message = "knot 0.5 already has multiplicity 2; degree 2 allows no more"};
  ExpectRefusal(Apply(Batch(3, {Knot(0.5)})), refusal);

  EXPECT_EQ(Lattice().SerializeAsString(), before);
  DeformClient client(*scenes_, Watch());
  ASSERT_TRUE(client.Send(Batch(4, {Knot(0.5)})));
  ASSERT_TRUE(client.Send(Batch(5, {Knot(0.75)})));
  client.ReadUntilRevision(3);
  ASSERT_EQ(client.log.results.size(), 2u);
  ExpectRefusal(client::FromRpc(client.log.results[0].status()), refusal);
}

TEST_F(BadEditsTest, AStaleStructureIsAborted) {
  const Refusal refusal{.code = absl::StatusCode::kAborted,
                        .reason = "STRUCTURE_CHANGED",
                        .message = "the scene is at 2"};
  v1::EditResult result;
  ASSERT_OK(Apply(Batch(1, {Knot(0.5)}), &result));
  ASSERT_EQ(result.structure_id(), 2u);
  const std::string before = Lattice().SerializeAsString();
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(1);
  uint64_t sequence = 1;
  for (const uint64_t stale : {0u, 1u, 3u}) {
    structure_id_ = stale;
    ExpectRefusal(Apply(Batch(++sequence, {MoveBy({1}, 1)})), refusal);
    ASSERT_TRUE(client.Send(Batch(++sequence, {MoveBy({1}, 1)})));
    client.ReadUntil([&] { return 2 * client.log.results.size() + 1 == sequence; });
    ExpectRefusal(client::FromRpc(client.log.results.back().status()), refusal);
  }
  EXPECT_EQ(Lattice().SerializeAsString(), before);
  structure_id_ = 2;
  ASSERT_TRUE(client.Send(Batch(++sequence, {MoveBy({1}, 1)})));
  client.ReadUntilRevision(2);
}

TEST_F(BadEditsTest, AnEditToADeletedSceneEndsTheStreamNotFound) {
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);
  ASSERT_OK(DeleteScene());
  (void)client.Send(Batch(1, {MoveBy({1}, 1)}));  // the stream may have ended already

  const Refusal refusal{.code = absl::StatusCode::kNotFound,
                        .reason = "NOT_FOUND",
                        .message = "no scene with id 'scene-one'"};
  ExpectRefusal(client.Finish(), refusal);
  for (const v1::EditResult& result : client.log.results) {
    ExpectRefusal(client::FromRpc(result.status()), refusal);
  }
  ExpectRefusal(Apply(Batch(2, {MoveBy({1}, 1)})), refusal);
}

}  // namespace
}  // namespace latticed::testing
