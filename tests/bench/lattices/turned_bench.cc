// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Two lattices that are turned against each other, by pipeline gemm, and the first of them alone, by pipeline fused, by turns,
// one thread.
//
//   turned/torus-17k/uniform          all control points: to the vertices of all chunks, 10 segments
//   turned/torus-17k/tolerance        the same with a tolerance, 1e-3 of the quantisation box
//   turned/torus-17k/…/edit           one control point of the first lattice: to the vertices of the chunks that it touches
//
//   turned_ms, one_ms, ratio     least times (turns.h)
//   patches, one_patches         of the plans; chunks, one_chunks: evaluated
#include <array>
#include <vector>

#include "core/ffd/plan/dirty_set.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/bench/turns.h"
#include "tests/bench/verify.h"

namespace latticed::bench {
namespace {

constexpr uint32_t kMovedPoint = 3 + 7 * (3 + 7 * 3);  // in the middle of 7 x 7 x 7

// A view of a scenario, and the two sets of control points between which a row alternates.
class TurnedSubject {
 public:
  TurnedSubject(const Scenario& scenario, Pipeline pipeline, double share, bool is_edit)
      : scenario_(scenario), points_(scenario.control_points), chunks_(scenario.all_chunks) {
    const ViewSpec spec{.segments = 10,
                        .tolerance = share * scenario.box.range,
                        .position_bits = share > 0 ? 16 : 12,
                        .normal_bits = 8};
    view_ = MakeView(scenario, pipeline, spec, 1);
    if (!is_edit) return;
    points_[1] = points_[0];
    points_[1][kMovedPoint] = scenario.control_points[1][kMovedPoint];
    chunks_ = DirtyByControlPoints(*scenario.plan, {{kMovedPoint}}).chunks;
  }
  void Move(size_t frame) {
    CheckOk(view_->Evaluate(points_[(frame + 1) % 2], scenario_.box, chunks_));
  }
  absl::Status Check(Pipeline pipeline) {
    if (view_->spec().tolerance == 0) return Verify(scenario_, pipeline, *view_);
    if (view_->certified_error() <= view_->spec().tolerance) return absl::OkStatus();
    return absl::InternalError("the tolerance is not met");
  }
  size_t chunks() const { return chunks_.size(); }

 private:
  const Scenario& scenario_;
  std::array<std::vector<Vec3d>, 2> points_;
  std::vector<uint32_t> chunks_;
  std::unique_ptr<DeformView> view_;
};

void BesideOne(benchmark::State& state, double share, bool is_edit) {
  static const Scenario* const turned =
      new Scenario(MakeTurnedScenario("torus-17k-turned", MakeTorus(111, 46)));
  const Scenario& one = SmallScenario(2);
  TurnedSubject of_turned(*turned, Pipeline::kGemm, share, is_edit);
  TurnedSubject of_one(one, Pipeline::kFused, share, is_edit);
  for (const absl::Status& status :
       {of_turned.Check(Pipeline::kGemm), of_one.Check(Pipeline::kFused)}) {
    if (!status.ok()) return state.SkipWithError(std::string(status.message()).c_str());
  }
  TakeTurns(state, {"turned", [&](size_t frame) { of_turned.Move(frame); }},
            {"one", [&](size_t frame) { of_one.Move(frame); }});
  const auto count = [&](const char* name, size_t value) {
    state.counters[name] = static_cast<double>(value);
  };
  count("patches", turned->plan->patches.size());
  count("one_patches", one.plan->patches.size());
  count("chunks", of_turned.chunks());
  count("one_chunks", of_one.chunks());
}

}  // namespace

void RegisterTurnedBenches() {
  constexpr double kShare = 1e-3;
  RegisterTurns("turned/torus-17k/uniform",
                [](benchmark::State& state) { BesideOne(state, 0, false); });
  RegisterTurns("turned/torus-17k/uniform/edit",
                [](benchmark::State& state) { BesideOne(state, 0, true); });
  RegisterTurns("turned/torus-17k/tolerance",
                [](benchmark::State& state) { BesideOne(state, kShare, false); });
  RegisterTurns("turned/torus-17k/tolerance/edit",
                [](benchmark::State& state) { BesideOne(state, kShare, true); });
}

}  // namespace latticed::bench
