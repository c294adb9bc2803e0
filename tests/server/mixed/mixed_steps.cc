// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The random steps of a session.
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/ffd/constraints/constraints.h"
#include "fmt/format.h"
#include "server/wire/converters.h"
#include "tests/server/mixed/mixed_session.h"

namespace latticed::testing {
namespace {

constexpr size_t kMostPresent = 4;
constexpr uint32_t kMostNumbers = 6;
// By an inserted knot: proto/latticed/v1/edit.proto promises this of the diagonal.
constexpr double kKeptShape = 1e-12;
// A fit in the mean square (replace_lattice with keep_shape) solves systems of one axis; those of degree 3 lose 3 digits.
constexpr double kFitted = 1e-11;

constexpr double kSymmetric = 1e-12;

v1::LatticeAxis AxisOf(int axis) { return static_cast<v1::LatticeAxis>(axis + 1); }

// Whether a lattice may be mirrored along the axis: by its knots, and by what goes on outside.
bool IsSymmetric(const LatticeStructure& s, int axis) {
  const auto a = static_cast<size_t>(axis);
  const std::vector<double>& knots = s.knots[a];
  const double both = s.domain_begin(axis) + s.domain_end(axis);
  for (size_t i = 0; i < knots.size(); ++i) {
    if (std::abs(knots[i] + knots[knots.size() - 1 - i] - both) > kSymmetric) return false;
  }
  const size_t begin = SideOf(a, false), end = SideOf(a, true);
  return s.outside.widths[begin] == s.outside.widths[end] &&
         std::abs(s.outside.steps[begin] - s.outside.steps[end]) <= kSymmetric;
}

// Every knot once more, for one degree more.
void RaiseDegree(LatticeStructure& s, size_t axis) {
  std::vector<double> knots;
  for (const double knot : s.knots[axis]) {
    if (knots.empty() || knots.back() != knot) knots.push_back(knot);
    knots.push_back(knot);
  }
  ++s.degree[axis];
  s.knots[axis] = std::move(knots);
  s.size[axis] = static_cast<int>(s.knots[axis].size()) - s.degree[axis] - 1;
}

}  // namespace

void MixedSession::AddLattice() {
  std::vector<uint32_t> free;
  for (uint32_t n = 0; n <= model_.count() && n < kMostNumbers; ++n) {
    if (n == model_.count() || !model_.Now(n).present) free.push_back(n);
  }
  if (free.empty() || model_.Present().size() >= kMostPresent) return RemoveAny();
  const uint32_t number = free[static_cast<size_t>(Below(static_cast<int>(free.size())))];
  constexpr std::array kTurns{0.0, 0.0, 0.5, -0.8};
  const double turn = kTurns[static_cast<size_t>(Below(4))];
  NumberState next{.present = true,
                   .lattice = DrawLattice(static_cast<Kind>(Below(3)), turn),
                   .held = {},
                   .mirror = {},
                   .weights = number == 0 ? model_.weights() : CubeWeights()};
  const v1::EditBatch batch = Put(number, ToProto(next.lattice));
  Send(batch, turn == 0 ? "additions" : "additions of turned ones", std::move(next));
}

void MixedSession::RemoveAny() {
  const uint32_t number = AnyPresent();
  if (model_.Present().size() == 1) {
    ExpectRefused(Apply(Remove(number)), absl::StatusCode::kFailedPrecondition, "LAST_LATTICE");
    ++counts_["removals of the last one, refused"];
    return;
  }
  NumberState next = model_.Now(number);
  next.present = false;
  Send(Remove(number), "removals", std::move(next));
}

void MixedSession::ChangeOutside() {
  const uint32_t number = AnyPresent();
  NumberState next = model_.Now(number);
  next.lattice.structure.outside = DrawOutside(next.lattice.structure);
  if (next.mirror.has_value() && !IsSymmetric(next.lattice.structure, *next.mirror)) {
    next.mirror.reset();
  }
  const v1::EditBatch batch = Put(number, ToProto(next.lattice));
  Send(batch, "changes of outside", std::move(next));
}

void MixedSession::SetStrength() {
  const uint32_t number = AnyPresent();
  NumberState next = model_.Now(number);
  next.strength = Below(5) == 0 ? Below(2) : Number(0, 1);
  v1::EditBatch batch = Batch(number);
  batch.add_edits()->mutable_set_strength()->set_strength(next.strength);
  Send(batch, "strengths", std::move(next), /*is_structural=*/false);
}

void MixedSession::SetWeights() {
  NumberState next = model_.Now(0);
  v1::EditBatch batch = Batch(0);
  v1::SetWeights& set = *batch.add_edits()->mutable_set_weights();
  if (next.weights.has_value() && Below(4) == 0) {
    next.weights.reset();
    set.set_clear(true);
  } else if (Below(2) == 0) {
    if (!next.weights.has_value()) next.weights.emplace().fill(1);
    const auto vertex = static_cast<size_t>(Below(8));
    float& weight = (*next.weights)[vertex];
    weight = static_cast<float>(Number(0, 1));
    set.mutable_some()->add_indices(static_cast<uint32_t>(vertex));
    set.mutable_some()->set_values(BytesOfWeights(std::span(&weight, 1)));
  } else {
    next.weights.emplace();
    for (float& weight : *next.weights) {
      weight = static_cast<float>(std::clamp(Number(-0.5, 1.5), 0.0, 1.0));
    }
    set.set_values(BytesOfWeights(*next.weights));
  }
  Send(batch, "weights", std::move(next), /*is_structural=*/false);
}

void MixedSession::Constrain() {
  const uint32_t number = AnyPresent();
  NumberState next = model_.Now(number);
  std::set<uint32_t> held;
  for (int i = Below(4); i > 0; --i) held.insert(AnyPoint(number));
  next.held.assign(held.begin(), held.end());
  next.mirror.reset();
  const int axis = Below(3);
  if (Below(2) == 0 && IsSymmetric(next.lattice.structure, axis)) next.mirror = axis;
  v1::EditBatch batch = Batch(number);
  auto& constraints = *batch.add_edits()->mutable_set_constraints();
  constraints.mutable_constraints()->mutable_held()->Add(held.begin(), held.end());
  if (next.mirror.has_value()) constraints.mutable_constraints()->set_mirror(AxisOf(axis));
  const std::string what = next.mirror.has_value() ? "mirrors" : "held points";
  Send(batch, what, std::move(next), /*is_structural=*/false);
}

void MixedSession::InsertKnot() {
  const uint32_t number = AnyPresent();
  NumberState next = model_.Now(number);
  LatticeStructure& s = next.lattice.structure;
  const auto axis = static_cast<size_t>(Below(3));
  const auto a = static_cast<int>(axis);
  const double part = Number(0.1, 0.9);
  const double knot = (1 - part) * s.domain_begin(a) + part * s.domain_end(a);
  v1::EditBatch batch = Batch(number);
  auto& insert = *batch.add_edits()->mutable_insert_knot();
  insert.set_axis(AxisOf(a));
  insert.set_value(knot);
  std::vector<double> knots{knot};
  if (next.mirror == a) {
    if (const auto other = MirroredKnot(s, a, knot)) knots.push_back(*other);
  }
  for (const double value : knots) {
    s.knots[axis].insert(std::ranges::upper_bound(s.knots[axis], value), value);
    ++s.size[axis];
  }
  SendRefined(batch, "knots", std::move(next), -0.5, 1.5, kKeptShape);
}

void MixedSession::Elevate() {
  const uint32_t number = AnyPresent();
  NumberState next = model_.Now(number);
  const auto axis = static_cast<size_t>(Below(3));
  if (next.lattice.structure.degree[axis] == 3) return InsertKnot();
  RaiseDegree(next.lattice.structure, axis);
  v1::EditBatch batch = Put(number, ToProto(next.lattice.structure, {}));
  batch.mutable_edits(0)->mutable_replace_lattice()->set_keep_shape(true);
  // Outside it fades out in another way.
  SendRefined(batch, "degrees", std::move(next), 0, 1, kFitted);
}

void MixedSession::UndoStep() { UndoOrRedo(/*undo=*/true); }

// Most edits leave nothing to be redone.
void MixedSession::RedoStep() {
  if (Below(4) != 0 && !AnyStep(/*undo=*/false).has_value()) UndoOrRedo(/*undo=*/true);
  UndoOrRedo(/*undo=*/false);
}

std::optional<uint32_t> MixedSession::AnyStep(bool undo) {
  std::vector<uint32_t> numbers;
  for (uint32_t n = 0; n < model_.count(); ++n) {
    if (undo ? model_.CanUndo(n) : model_.CanRedo(n)) numbers.push_back(n);
  }
  if (numbers.empty()) return std::nullopt;
  return numbers[static_cast<size_t>(Below(static_cast<int>(numbers.size())))];
}

void MixedSession::UndoOrRedo(bool undo) {
  const std::string what = undo ? "undone" : "redone";
  const std::optional<uint32_t> found = AnyStep(undo);
  const uint32_t number = found.value_or(0);
  const absl::Status status = Apply(undo ? Undo(number) : Redo(number));
  if (!found.has_value()) {
    EXPECT_EQ(Reason(status), undo ? "NOTHING_TO_UNDO" : "NOTHING_TO_REDO") << status;
    ++counts_["nothing to be " + what];
  } else if (!model_.LeavesAny(number, undo)) {
    EXPECT_EQ(Reason(status), "LAST_LATTICE") << status;
    ++counts_["last lattice, not " + what];
  } else if (!status.ok()) {
    EXPECT_THAT(status.message(), ::testing::HasSubstr("lattices: their sum has"));
    ++counts_[what + ", refused for too large a sum"];
  } else {
    undo ? model_.Undo(number) : model_.Redo(number);
    ++counts_[what];
  }
}

void MixedSession::RestartServer() {
  const auto before = Chunks();
  Restart();
  EXPECT_TRUE(Chunks() == before) << "a restart changes nothing";
  ++counts_["restarts"];
}

}  // namespace latticed::testing
