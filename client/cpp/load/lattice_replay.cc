// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/lattice_replay.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

Vec3d VectorOf(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }

std::array<int, 3> AxesOf(const v1::LatticeAxes& axes) { return {axes.u(), axes.v(), axes.w()}; }

Lattice LatticeOf(const v1::Lattice& from) {
  Lattice lattice;
  lattice.structure = {.degree = AxesOf(from.degree()),
                       .size = AxesOf(from.size()),
                       .knots = {{{from.knots_u().begin(), from.knots_u().end()},
                                  {from.knots_v().begin(), from.knots_v().end()},
                                  {from.knots_w().begin(), from.knots_w().end()}}},
                       .frame = {VectorOf(from.frame().origin()),
                                 {VectorOf(from.frame().u()), VectorOf(from.frame().v()),
                                  VectorOf(from.frame().w())}}};
  const auto& flat = from.control_points();
  for (int i = 0; i < flat.size(); i += 3) {
    lattice.control_points.push_back({flat[i], flat[i + 1], flat[i + 2]});
  }
  return lattice;
}

}  // namespace

LatticeReplay::LatticeReplay(const LoadPlan& plan, const v1::LatticeState& before,
                             std::vector<AppliedEdit> edits)
    : plan_(plan),
      before_(before),
      edits_(std::move(edits)),
      history_(LatticeOf(before.lattice())) {
  std::ranges::sort(edits_, {}, &AppliedEdit::revision);
}

absl::StatusOr<std::span<const Vec3d>> LatticeReplay::At(uint64_t revision) {
  for (; next_ < edits_.size() && edits_[next_].revision <= revision; ++next_) {
    LATTICED_RETURN_IF_ERROR(Apply(edits_[next_]));
  }
  return history_.lattice().control_points;
}

absl::Status LatticeReplay::Apply(const AppliedEdit& edit) {
  const bool warm_up = edit.editor == kWarmUpEditor;
  const v1::EditBatch sent = MakeLoadEdit(before_, warm_up || plan_.all_points, edit.step);
  const auto& move = sent.edits(0).move_control_points();
  EditBatch batch{.editor_id = fmt::to_string(edit.editor),
                  .sequence = next_ + 1,
                  .structure_id = history_.structure_id()};
  if (plan_.mode == LoadMode::kInterval && !warm_up) batch.gesture_id = "load";
  batch.edits.emplace_back(
      MoveControlPoints{.indices = {move.indices().begin(), move.indices().end()},
                        .offset = VectorOf(move.offset())});
  const auto admit = [](const LatticeStructure&) { return absl::OkStatus(); };
  return history_.Apply(batch, {}, admit).status();
}

}  // namespace latticed::client
