// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The steps of a session that move control points: moves, drags and gestures.
#include <algorithm>
#include <set>
#include <utility>

#include "core/ffd/direct_ffd.h"
#include "fmt/format.h"
#include "tests/server/mixed/mixed_session.h"

namespace latticed::testing {
namespace {

constexpr double kReach = 0.1, kFar = 0.5;  // of a move along each axis

}  // namespace

v1::EditBatch MixedSession::RandomMove(uint32_t number, NumberState& next, double reach) {
  std::set<uint32_t> indices;
  for (int i = Below(3); i >= 0; --i) indices.insert(AnyPoint(number));
  const Vec3d offset = Offset(reach);
  v1::EditBatch batch = Batch(number);
  auto& move = *batch.add_edits()->mutable_move_control_points();
  move.mutable_indices()->Add(indices.begin(), indices.end());
  *move.mutable_offset() = ToVec3(offset);
  MoveAllowed(next, indices, offset);
  return batch;
}

void MixedSession::MovePoints() {
  const uint32_t number = AnyPresent();
  NumberState next = model_.Now(number);
  const bool refuses = Below(3) == 0;
  v1::EditBatch batch = RandomMove(number, next, refuses ? kFar : kReach);
  batch.set_refuse_folds(refuses);
  const bool is_certified = refuses && Folds().certified();
  const std::string what = refuses ? "moves that may not fold" : "moves";
  if (!Send(batch, what, std::move(next), /*is_structural=*/false) || !is_certified) return;
  EXPECT_TRUE(Folds().certified());
}

std::vector<CubePlace> MixedSession::PlacesToDrag(uint32_t number) {
  const LatticeStructure& s = model_.Now(number).lattice.structure;
  const FrameMap map(s);
  std::vector<CubePlace> places;
  const size_t count = 1 + static_cast<size_t>(Below(3));
  for (int n = 0; n < 40 && places.size() < count; ++n) {
    const CubePlace place = AnyPlace();
    if (model_.WeightAt(place) < 0.3 || !FindVolumePlace(s, map, place.rest)) continue;
    places.push_back(place);
  }
  return places;
}

// All by one offset, along the plane of a mirror: points next to each other, or to the plane, would take large moves to part.
void MixedSession::DragPoints() {
  const uint32_t number = AnyPresent();
  const NumberState& now = model_.Now(number);
  const std::vector<CubePlace> places = PlacesToDrag(number);
  if (places.empty() || (now.strength != 0 && now.strength < 0.2)) return MovePoints();
  Vec3d offset = Offset(kReach);
  if (now.mirror.has_value()) {
    offset -= Dot(offset, MirrorNormal(now)) * MirrorNormal(now);
  }
  v1::EditBatch batch = Batch(number);
  auto& drag = *batch.add_edits()->mutable_drag_points();
  std::vector<Vec3d> targets;
  for (const CubePlace& place : places) {
    *drag.add_points() = SurfacePointOf(place);
    targets.push_back(SurfaceOf(place) + offset);
    for (int a = 0; a < 3; ++a) drag.add_targets(targets.back()[a]);
  }
  if (now.strength == 0) {
    ExpectRefused(Apply(batch), absl::StatusCode::kFailedPrecondition, "NO_STRENGTH");
    ++counts_["drags at strength 0, refused"];
    return;
  }
  NumberState next = now;
  next.lattice.control_points.clear();
  if (!Send(batch, "drags", std::move(next), /*is_structural=*/false) || kept_.has_value()) return;
  double largest = 0;
  for (size_t n = 0; n < places.size(); ++n) {
    largest = std::max(largest, Norm(SurfaceOf(places[n]) - targets[n]));
  }
  EXPECT_NEAR(largest, residual_, 1e-9);
  if (places.size() > 1 || !model_.Now(number).held.empty()) return;
  EXPECT_LE(largest, 1e-9);
  ++counts_["drags that reach their target"];
}

void MixedSession::EndGesture(uint32_t number, const std::string& id, v1::GesturePhase phase) {
  v1::EditBatch end = Batch(number);
  end.set_gesture_id(id);
  end.set_gesture_phase(phase);
  ASSERT_OK(Apply(end));
}

// Each update is of the lattice at the begin. All are one step, or none if it is cancelled.
void MixedSession::MakeGesture() {
  const uint32_t number = AnyPresent();
  const NumberState begin = model_.Now(number);
  const std::string id = fmt::format("gesture {}", sequence_);
  NumberState next;
  for (int update = Below(3); update >= 0; --update) {
    next = begin;
    v1::EditBatch batch = RandomMove(number, next, kReach);
    batch.set_gesture_id(id);
    ASSERT_OK(Apply(batch));
    if (Below(6) == 0) RestartServer();
  }
  const bool is_cancelled = Below(3) == 0;
  EndGesture(number, id, is_cancelled ? v1::GESTURE_PHASE_CANCEL : v1::GESTURE_PHASE_COMMIT);
  if (is_cancelled) {
    model_.ForgetUndone(number);  // by its first update
    ++counts_["gestures cancelled"];
  } else {
    TakeOver(number, "gestures", std::move(next), /*is_structural=*/false);
  }
}

}  // namespace latticed::testing
