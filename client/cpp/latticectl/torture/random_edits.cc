// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/torture/random_edits.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "client/cpp/latticectl/geometry/lattice_json.h"

namespace latticed::client {
namespace {

constexpr int kMostLayers = 10;       // of control points along the last axis
constexpr uint32_t kMostPoints = 10;  // of an edit
constexpr int kLastAxis = 2;

void AddEdit(const SetControlPoints& set, v1::Edit* proto) {
  auto& to = *proto->mutable_set_control_points();
  to.mutable_indices()->Add(set.indices.begin(), set.indices.end());
  for (const Vec3d& p : set.positions) {
    for (const double number : {p.x, p.y, p.z}) to.add_positions(number);
  }
}

void AddEdit(const MoveControlPoints& move, v1::Edit* proto) {
  auto& to = *proto->mutable_move_control_points();
  to.mutable_indices()->Add(move.indices.begin(), move.indices.end());
  *to.mutable_offset() = ToProto(move.offset);
}

void AddEdit(const InsertKnot& knot, v1::Edit* proto) {
  proto->mutable_insert_knot()->set_axis(v1::LATTICE_AXIS_W);
  proto->mutable_insert_knot()->set_value(knot.value);
}

void AddEdit(const Undo&, v1::Edit* proto) {
  proto->mutable_undo()->set_scope(v1::UNDO_SCOPE_MINE);
}

void AddEdit(const Redo&, v1::Edit* proto) { proto->mutable_redo(); }

// The others are not made here.
template <typename Other>
void AddEdit(const Other&, v1::Edit*) {}

}  // namespace

v1::LatticeFit TorturedLattice() { return ToProto(FitFlags{.degree = "2,2,1"}); }

EditBatch RandomEdits::Next(const v1::LatticeState& state) {
  EditBatch batch;
  batch.structure_id = state.structure_id();
  batch.edits.push_back(NextEdit(state.lattice()));
  return batch;
}

Edit RandomEdits::NextEdit(const v1::Lattice& lattice) {
  const uint32_t percent = Below(100);
  if (percent < 2 && lattice.size().w() < kMostLayers) return NewKnot(lattice);
  if (percent < 12) return Undo{UndoScope::kMine};
  if (percent < 18) return Redo{};
  if (percent < 40) return NewOffset(lattice);
  return NewPositions(lattice);
}

Edit RandomEdits::NewKnot(const v1::Lattice& lattice) {
  std::vector<double> middles;
  for (int i = 0; i + 1 < lattice.knots_w_size(); ++i) {
    const double begin = lattice.knots_w(i), end = lattice.knots_w(i + 1);
    if (begin < end) middles.push_back(0.5 * (begin + end));
  }
  return InsertKnot{kLastAxis, middles[Below(static_cast<uint32_t>(middles.size()))]};
}

Edit RandomEdits::NewPositions(const v1::Lattice& lattice) {
  SetControlPoints set{.indices = SomePoints(lattice), .positions = {}};
  for (const uint32_t index : set.indices) {
    const double* xyz = lattice.control_points().data() + 3 * static_cast<size_t>(index);
    set.positions.push_back(
        {xyz[0] + Little(lattice), xyz[1] + Little(lattice), xyz[2] + Little(lattice)});
  }
  return set;
}

Edit RandomEdits::NewOffset(const v1::Lattice& lattice) {
  const Vec3d offset{Little(lattice), Little(lattice), Little(lattice)};
  return MoveControlPoints{SomePoints(lattice), offset};
}

std::vector<uint32_t> RandomEdits::SomePoints(const v1::Lattice& lattice) {
  const uint32_t points = static_cast<uint32_t>(lattice.control_points_size()) / 3;
  std::vector<uint32_t> own;
  for (uint32_t index = editor_; index < points; index += editors_) own.push_back(index);
  std::shuffle(own.begin(), own.end(), random_);
  own.resize(std::min<size_t>(own.size(), 1 + Below(kMostPoints)));
  return own;
}

double RandomEdits::Little(const v1::Lattice& lattice) {
  return std::uniform_real_distribution(-0.05, 0.05)(random_) * lattice.frame().u().x();
}

v1::EditBatch ToProto(const EditBatch& batch) {
  v1::EditBatch proto;
  proto.set_structure_id(batch.structure_id);
  for (const Edit& edit : batch.edits) {
    std::visit([&](const auto& kind) { AddEdit(kind, proto.add_edits()); }, edit);
  }
  return proto;
}

}  // namespace latticed::client
