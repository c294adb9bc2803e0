// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/points/random_session.h"

#include <set>
#include <span>
#include <utility>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/outside/outside_map.h"
#include "fmt/format.h"
#include "server/wire/converters.h"
#include "tests/support/seed.h"

namespace latticed::testing {
namespace {

// A closed box of volume 2. Faces are convex, so their first three corners are a triangle of them.
constexpr std::array<Vec3d, 8> kBoxVertices{
    {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 1}, {2, 1, 1}, {0, 1, 1}}};
constexpr std::array<std::array<uint32_t, 4>, 6> kBoxFaces{
    {{3, 2, 1, 0}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
constexpr std::array<float, 8> kBoxWeights{0, 0.5F, 1, 0.25F, 1, 0.75F, 0.5F, 1};
constexpr double kClose = 1e-12;  // sizes are about 2, and a line carries errors on

std::string BoxObj() {
  std::string obj;
  for (const Vec3d p : kBoxVertices) obj += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  for (const auto& f : kBoxFaces) {
    obj += fmt::format("f {} {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1, f[3] + 1);
  }
  return obj;
}

// What goes on outside included.
Vec3d EvaluatedBy(const v1::Lattice& lattice, std::span<const Vec3d> control_points, Vec3d rest) {
  const auto structure = StructureFromProto(lattice, "");
  EXPECT_OK(structure);
  const OutsideMap outside(*structure);
  return EvaluateWorld(outside.continued(), outside.Continue(control_points), rest).position;
}

std::vector<Vec3d> PointsOf(const google::protobuf::RepeatedField<double>& flat) {
  std::vector<Vec3d> points;
  for (int i = 0; i + 2 < flat.size(); i += 3) {
    points.push_back({flat[i], flat[i + 1], flat[i + 2]});
  }
  return points;
}

// Positions of the control points that an edit names, in its order, without constraints.
std::vector<Vec3d> Wanted(const v1::Edit& edit, const std::vector<Vec3d>& begin,
                          std::vector<uint32_t>& indices) {
  std::vector<Vec3d> wanted;
  const auto for_each = [&](const auto& named, auto&& position) {
    indices.assign(named.begin(), named.end());
    for (const uint32_t i : indices) wanted.push_back(position(begin[i]));
  };
  if (edit.has_set_control_points()) {
    const auto& set = edit.set_control_points();
    indices.assign(set.indices().begin(), set.indices().end());
    return PointsOf(set.positions());
  }
  if (edit.has_move_control_points()) {
    const v1::Vec3& by = edit.move_control_points().offset();
    for_each(edit.move_control_points().indices(), [&](Vec3d p) {
      return p + Vec3d{by.x(), by.y(), by.z()};
    });
  } else if (edit.has_transform_control_points()) {
    const auto& m = edit.transform_control_points().matrix();
    for_each(edit.transform_control_points().indices(), [&](Vec3d p) {
      Vec3d q;
      for (int a = 0; a < 3; ++a) q[a] = m[a] * p.x + m[4 + a] * p.y + m[8 + a] * p.z + m[12 + a];
      return q;
    });
  } else if (edit.has_carry_control_points()) {
    const v1::Lattice& parent = edit.carry_control_points().parent();
    const std::vector<Vec3d> points = PointsOf(parent.control_points());
    for_each(edit.carry_control_points().indices(),
             [&](Vec3d p) { return EvaluatedBy(parent, points, p); });
  }
  return wanted;
}

}  // namespace

Undoable UndoableOf(const v1::LatticeState& state) {
  return {state.lattice().SerializeAsString(), state.constraints().SerializeAsString()};
}

std::vector<Vec3d> ControlPointsOf(const v1::LatticeState& state) {
  return PointsOf(state.lattice().control_points());
}

void RandomSession::SetUp() {
  random_.seed(SeedOfCase(2'600, GetParam()));
  Restart();
  mesh_ = Upload(BoxObj());
  v1::CreateSceneRequest request = SceneRequest();
  if (is_weighted()) {
    request.mutable_weights()->set_values(
        std::string(reinterpret_cast<const char*>(kBoxWeights.data()), sizeof(kBoxWeights)));
  }
  if (kind() == Kind::kFalloff || kind() == Kind::kLinear) {
    *request.add_lattices()->mutable_lattice() = Half();
  } else if (is_of_two()) {  // both fade out: an end that does not would also end the sum
    v1::Lattice& whole = *request.add_lattices()->mutable_lattice();
    whole = Half();
    SetFrame(*whole.mutable_frame(), {-0.1, -0.1, -0.1}, {2.2, 1.2, 1.2});
  }
  ASSERT_OK(Create(request));
  if (is_of_two()) AddSecond();
  state_ = State();
  for (int i = 0; i < 60; ++i) {
    world_.push_back({Number(-0.3, 2.3), Number(-0.3, 1.3), Number(-0.3, 1.3)});
  }
}

v1::LatticeState RandomSession::StateOf(uint32_t lattice) {
  auto request = For<v1::GetLatticeRequest>();
  request.set_lattice(lattice);
  v1::LatticeState state;
  EXPECT_OK(Call(&Scenes::GetLattice, request, &state));
  return state;
}

v1::Lattice RandomSession::Half() const {
  v1::Lattice lattice;
  SetFrame(*lattice.mutable_frame(), {-0.1, -0.1, -0.1}, {1.1, 1.2, 1.2});
  const bool is_line = kind() == Kind::kLinear;
  lattice.mutable_outside()->set_mode(is_line ? v1::OUTSIDE_MODE_LINEAR : v1::OUTSIDE_MODE_FALLOFF);
  if (!is_line) lattice.mutable_outside()->add_widths(0.4);
  return lattice;
}

void RandomSession::AddSecond() {
  v1::EditBatch batch = MoveOne("bob", ++other_sequence_, 0, {});
  batch.set_lattice(1);
  v1::Lattice& second = *batch.mutable_edits(0)->mutable_replace_lattice()->mutable_lattice();
  second = Half();
  if (is_turned()) second.mutable_frame()->mutable_u()->set_y(0.4);
  ASSERT_OK(Apply(batch));
  MoveOther();
  if (Below(3) == 0) return;
  v1::EditBatch keep = MoveOne("bob", ++other_sequence_, 0, {});
  keep.mutable_edits(0)->mutable_set_constraints()->mutable_constraints()->mutable_volume();
  keep.set_structure_id(State().structure_id());
  ASSERT_OK(Apply(keep));
  other_ = StateOf(0);
  other_keeps_ = true;
}

void RandomSession::MoveOther() {
  if (state_.constraints().has_volume() && !other_keeps_)
    return;  // steps below could not be undone
  v1::EditBatch batch =
      MoveOne("bob", ++other_sequence_, static_cast<uint32_t>(Below(64)), Step(0.1));
  batch.set_structure_id(State().structure_id());
  const absl::Status status = Apply(batch);
  other_ = StateOf(0);
  state_ = State();
  if (other_keeps_ && Reason(status) == "VOLUME_NOT_KEPT") return;
  ASSERT_OK(status);
  if (other_keeps_) ExpectVolume();
}

void RandomSession::Restart() {
  server_.reset();
  Options options;
  options.data_dir = folder_.Path("data");
  SceneFixture::StartServer(options);
}

v1::EditBatch RandomSession::Batch() {
  v1::EditBatch batch;
  batch.set_scene(kScene);
  batch.set_editor_id("ann");
  batch.set_sequence(++sequence_);
  batch.set_structure_id(state_.structure_id());
  batch.set_lattice(is_of_two() ? 1 : 0);
  batch.add_edits();
  return batch;
}

v1::EditBatch RandomSession::Change() {
  v1::EditBatch batch = Batch();
  std::set<uint32_t> indices;
  for (int i = Below(3); i >= 0; --i) indices.insert(AnyPoint());
  const double reach = Below(6) == 0 ? 1.5 : 0.15;  // some fold
  v1::Edit& edit = *batch.mutable_edits(0);
  switch (Below(6)) {
    case 0: {
      auto& shear = *edit.mutable_transform_control_points();
      shear.mutable_indices()->Add(indices.begin(), indices.end());
      const double slope = Number(-reach, reach), offset = Number(-reach, reach);
      for (const double m :
           {1., 0., 0., 0., slope, 1., 0., 0., 0., 0., 1., 0., offset, 0., 0., 1.}) {
        shear.add_matrix(m);
      }
      break;
    }
    case 1: {
      auto& set = *edit.mutable_set_control_points();
      for (const uint32_t i : indices) {
        const Vec3d to = ControlPointsOf(state_)[i] + Step(reach);
        set.add_indices(i);
        for (int a = 0; a < 3; ++a) set.add_positions(to[a]);
      }
      break;
    }
    case 2:
      AddDrag(batch, reach);
      break;
    case 3:
      AddCarry(batch, reach);
      break;
    default:
      edit.mutable_move_control_points()->mutable_indices()->Add(indices.begin(), indices.end());
      *edit.mutable_move_control_points()->mutable_offset() = ToVec3(Step(reach));
  }
  batch.set_refuse_folds(Below(3) == 0);
  if (Below(4) == 0) batch.mutable_keep_volume();
  return batch;
}

void RandomSession::AddDrag(v1::EditBatch& batch, double reach) {
  auto& drag = *batch.mutable_edits(0)->mutable_drag_points();
  for (int i = Below(3); i >= 0; --i) {
    const SurfacePlace place = AnyPlace();
    *drag.add_points() = place.point;
    const Vec3d target = DeformedPlace(place) + Step(reach);
    for (int a = 0; a < 3; ++a) drag.add_targets(target[a]);
  }
}

void RandomSession::AddCarry(v1::EditBatch& batch, double reach) {
  auto& carry = *batch.mutable_edits(0)->mutable_carry_control_points();
  const size_t count = ControlPointsOf(state_).size();
  for (uint32_t i = 0; i < count; ++i) {
    if (Below(3) != 0) carry.add_indices(i);
  }
  if (carry.indices().empty()) carry.add_indices(0);
  v1::Lattice& parent = *carry.mutable_parent();
  SetFrame(*parent.mutable_frame(), {-0.5, -0.5, -0.5}, {Number(1, 3), 2, 2});
  SetAxes(*parent.mutable_size(), 3, 4, 3);
  if (Below(3) != 0) {
    const bool is_line = Below(2) == 0;
    parent.mutable_outside()->set_mode(is_line ? v1::OUTSIDE_MODE_LINEAR
                                               : v1::OUTSIDE_MODE_FALLOFF);
    parent.mutable_outside()->add_widths(Number(0.1, 2));
  }
  const auto structure = StructureFromProto(parent, "");
  ASSERT_OK(structure);
  for (const Vec3d rest : IdentityControlPoints(*structure)) {
    const Vec3d p = rest + Step(reach / 2);
    for (int a = 0; a < 3; ++a) parent.add_control_points(p[a]);
  }
}

v1::EditBatch RandomSession::Constrain() {
  v1::EditBatch batch = Batch();
  auto& constraints = *batch.mutable_edits(0)->mutable_set_constraints();
  if (Below(4) == 0) return batch;  // none
  auto& kept = *constraints.mutable_constraints();
  kept.add_held(AnyPoint());
  if (Below(2) == 0) {
    auto& layers = *kept.add_held_layers();
    layers.set_axis(static_cast<v1::LatticeAxis>(1 + Below(3)));
    layers.set_at_end(Below(2) == 0);
    layers.set_layers(1);
  }
  if (Below(2) == 0) kept.mutable_volume();
  return batch;
}

v1::EditBatch RandomSession::InsertKnot() {
  v1::EditBatch batch = Batch();
  auto& knot = *batch.mutable_edits(0)->mutable_insert_knot();
  knot.set_axis(static_cast<v1::LatticeAxis>(1 + Below(3)));
  knot.set_value(Number(0.05, 0.95));
  return batch;
}

bool RandomSession::Send(const v1::EditBatch& batch) {
  v1::EditResult result;
  const absl::Status status = Apply(batch, &result);
  residual_ = result.drag_residual();
  before_ = std::exchange(state_, State());
  const v1::LatticeState other = is_of_two() ? std::exchange(other_, StateOf(0)) : other_;
  if (status.ok()) {
    EXPECT_EQ(state_.revision(), before_.revision() + 1);
  } else {
    EXPECT_EQ(state_.SerializeAsString(), before_.SerializeAsString()) << status;
    EXPECT_EQ(other_.SerializeAsString(), other.SerializeAsString()) << status;
  }
  ++counts_[status.ok() ? "applied" : Reason(status)];
  return status.ok();
}

void RandomSession::ExpectChange(const v1::Edit& edit, const v1::LatticeState& begin) {
  if (edit.has_drag_points()) return ExpectTargets(edit.drag_points());
  ExpectPositions(edit, ControlPointsOf(begin));
}

void RandomSession::ExpectPositions(const v1::Edit& edit, const std::vector<Vec3d>& begin) {
  std::vector<uint32_t> indices;
  const std::vector<Vec3d> wanted = Wanted(edit, begin, indices);
  std::vector<Vec3d> expected = begin;
  for (size_t n = 0; n < indices.size(); ++n) expected[indices[n]] = wanted[n];
  for (const uint32_t held : state_.constraints().held()) expected[held] = begin[held];
  for (const auto& layers : state_.constraints().held_layers()) {
    if (layers.layers() > 0) return;  // indices of faces: ExpectHeld looks at single points alone
  }
  const std::vector<Vec3d> got = ControlPointsOf(state_);
  ASSERT_EQ(got.size(), expected.size());
  for (size_t i = 0; i < got.size(); ++i) ASSERT_LE(Norm(got[i] - expected[i]), kClose) << i;
  ++counts_["edits as defined"];
}

void RandomSession::ExpectTargets(const v1::DragPoints& drag) {
  const std::vector<Vec3d> targets = PointsOf(drag.targets());
  double largest = 0;
  for (int n = 0; n < drag.points_size(); ++n) {
    const Vec3d at = DeformedPlace(PlaceOf(drag.points(n)));
    largest = std::max(largest, Norm(at - targets[static_cast<size_t>(n)]));
  }
  EXPECT_NEAR(largest, residual_, 1e-9);
  ++counts_["drags as defined"];
}

void RandomSession::ExpectHeld() const {
  const auto before = ControlPointsOf(before_), after = ControlPointsOf(state_);
  for (const uint32_t i : before_.constraints().held()) {
    EXPECT_EQ(after[i], before[i]) << "held " << i;
  }
}

RandomSession::SurfacePlace RandomSession::AnyPlace() {
  v1::SurfacePoint point;
  const auto face = static_cast<uint32_t>(Below(static_cast<int>(kBoxFaces.size())));
  point.set_face(face);
  for (uint32_t k = 0; k < 3; ++k) point.add_corners(4 * face + k);
  const double a = Number(0, 1), b = Number(0, 1 - a);
  for (const double number : {a, b, 1 - a - b}) point.add_barycentrics(number);
  return PlaceOf(point);
}

RandomSession::SurfacePlace RandomSession::PlaceOf(const v1::SurfacePoint& point) const {
  SurfacePlace place{.point = point, .rest = {}, .weight = 0};
  for (int k = 0; k < 3; ++k) {
    const uint32_t vertex = kBoxFaces[point.face()][static_cast<size_t>(k)];
    place.rest = place.rest + point.barycentrics(k) * kBoxVertices[vertex];
    place.weight += point.barycentrics(k) * double{kBoxWeights[vertex]};
  }
  if (!is_weighted()) place.weight = 1;
  return place;
}

Vec3d RandomSession::Deformed(Vec3d rest) const {
  const Vec3d at = EvaluatedBy(state_.lattice(), ControlPointsOf(state_), rest);
  if (!is_of_two()) return at;
  return at + EvaluatedBy(other_.lattice(), ControlPointsOf(other_), rest) - rest;
}

Vec3d RandomSession::DeformedPlace(const SurfacePlace& place) const {
  return place.rest + place.weight * (Deformed(place.rest) - place.rest);
}

void RandomSession::ExpectDefinition() {
  std::vector<SurfacePlace> places;
  auto request = For<v1::EvaluatePointsRequest>();
  for (int i = 0; i < 20; ++i) {
    places.push_back(AnyPlace());
    *request.mutable_surface_points()->add_points() = places.back().point;
  }
  v1::EvaluatePointsResponse response;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &response));
  const std::vector<Vec3d> evaluated = PointsOf(response.positions());
  ASSERT_EQ(evaluated.size(), places.size());
  for (size_t i = 0; i < places.size(); ++i) {
    ASSERT_LE(Norm(evaluated[i] - DeformedPlace(places[i])), kClose) << i;
  }
  PointSetClient client(server_->channel());
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client.CreateWorld(world_));
  ASSERT_OK_AND_ASSIGN(const auto deformed, client.Deform(set));
  ASSERT_OK(client.Delete(set.id()));
  EXPECT_EQ(deformed.header.revision(), state_.revision());
  for (size_t i = 0; i < world_.size(); ++i) {
    ASSERT_LE(Norm(deformed.vectors[i] - Deformed(world_[i])), kClose) << i;
  }
}

}  // namespace latticed::testing
