// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Several lattices on one mesh (core/ffd/sum/), and the first of them alone, by turns, one thread. The first one is around
// the torus; the others are around parts of it, where they fade out.
//
//   sums/torus-17k/<n>lattices/frame   all control points of the first lattice: to the vertices of all chunks
//   sums/torus-17k/<n>lattices/edit    one control point of the first lattice: to the vertices of the chunks that it touches
//   sums/torus-17k/<n>lattices/plan    from mesh and lattices to plan
//
//   sum_ms, one_ms, ratio      least times (turns.h)
//   patches, one_patches       of the plans; points, one_points: their control points; chunks, one_chunks: evaluated
#include <array>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/base/bounds.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/outside/outside_rules.h"
#include "core/ffd/plan/dirty_set.h"
#include "fmt/format.h"
#include "server/engine/lattices/scene_lattice.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/bench/turns.h"
#include "tests/bench/verify.h"

namespace latticed::bench {
namespace {

constexpr uint32_t kSumSeed = 20261129;
constexpr double kSpotWidth = 0.3;  // of the frame's edges

// The lattice around the torus, or one around a part of it.
Lattice LatticeOf(const PolygonMesh& mesh, size_t number) {
  if (number == 0) return Checked(FitLattice(mesh.ComputeBounds(), {7, 7, 7}, {2, 2, 2}, 0.05));
  constexpr std::array<Vec3d, 3> kCentres{Vec3d{1, 0, 0}, {-1, 0.1, 0}, {0.1, 1, 0}};
  constexpr Vec3d kReach{0.45, 0.45, 0.45};
  Bounds part;
  part.Extend(kCentres[number - 1] - kReach);
  part.Extend(kCentres[number - 1] + kReach);
  Lattice lattice = Checked(FitLattice(part, {5, 5, 5}, {2, 2, 2}, 0));
  lattice.structure.outside.mode = OutsideMode::kFalloff;
  lattice.structure.outside.widths.fill(kSpotWidth);
  lattice.structure.outside = ResolvedOutside(lattice.structure, mesh.positions);
  return lattice;
}

class SummedScene {
 public:
  explicit SummedScene(size_t count) : mesh_(MakeTorus(111, 46)) {
    std::mt19937 random(kSumSeed);
    std::uniform_real_distribution<double> move(-0.05, 0.05);
    std::map<uint32_t, LatticeStructure> structures;
    std::vector<std::vector<Vec3d>> points;
    for (size_t k = 0; k < count; ++k) {
      Lattice lattice = LatticeOf(*mesh_, k);
      for (Vec3d& p : lattice.control_points) p += {move(random), move(random), move(random)};
      structures[static_cast<uint32_t>(k)] = lattice.structure;
      points.push_back(std::move(lattice.control_points));
    }
    lattices_ = Checked(PlanLattices(structures, mesh_->positions)).lattices;
    for (size_t k = 0; k < count; ++k) TakePoints(lattices_, k, 1, points[k]);
    scenario_ = MakeScenario("sum", MakeSumPlan());
    planned_ = PlannedPoints(lattices_);
    scenario_.control_points[0] = *planned_;
    Bounds bounds = mesh_->ComputeBounds();
    for (const Vec3d p : scenario_.control_points[0]) bounds.Extend(p);
    scenario_.box = FitQuantisationBox(bounds, 1);
  }

  const Scenario& scenario() const { return scenario_; }
  size_t evaluated_chunks() const { return evaluated_; }
  std::shared_ptr<const DeformPlan> MakeSumPlan() const {
    return Checked(MakePlan(mesh_, lattices_[0].map->continued()));
  }

  // The view is that of the plan's definition, which is the sum of formulas (1).
  absl::Status Check(DeformView& view) const {
    constexpr double kAllowed = 1e-12;
    std::vector<Vec3d> want = mesh_->positions;
    for (const SceneLattice& lattice : lattices_) {
      const OutsideMap alone(lattice.structure());
      const std::vector<Vec3d> points = alone.Continue(*lattice.points);
      for (size_t i = 0; i < want.size(); ++i) {
        const Vec3d p = mesh_->positions[i];
        want[i] += EvaluateWorld(alone.continued(), points, p).position - p;
      }
    }
    for (size_t i = 0; i < want.size(); ++i) {
      const DeformedPoint got = EvaluateWorld(lattices_[0].map->continued(),
                                              scenario_.control_points[0], mesh_->positions[i]);
      if (!(Norm(got.position - want[i]) <= kAllowed)) {
        return absl::InternalError("the sum differs");
      }
    }
    return Verify(scenario_, Pipeline::kFused, view);
  }

  // Moves all control points of the first lattice, to and fro.
  void MoveAll(DeformView& view, size_t frame) {
    std::vector<Vec3d> points = *lattices_[0].points;
    for (Vec3d& p : points) p.x += frame % 2 == 0 ? 0.01 : -0.01;
    TakePoints(lattices_, 0, 1, points);
    planned_ = PlannedPoints(lattices_);
    evaluated_ = scenario_.all_chunks.size();
    CheckOk(view.Evaluate(*planned_, scenario_.box, scenario_.all_chunks));
  }

  // Moves one, as an edit does.
  void MoveOne(DeformView& view, size_t frame) {
    std::vector<Vec3d> points = *lattices_[0].points;
    points[static_cast<size_t>(lattices_[0].structure().Index(5, 3, 3))].x +=
        frame % 2 == 0 ? 0.01 : -0.01;
    TakePoints(lattices_, 0, 1, points);
    const auto before = std::exchange(planned_, PlannedPoints(lattices_));
    std::vector<uint32_t> moved;
    for (size_t i = 0; i < planned_->size(); ++i) {
      if ((*planned_)[i] != (*before)[i]) moved.push_back(static_cast<uint32_t>(i));
    }
    const DirtySet dirty = DirtyByControlPoints(*scenario_.plan, moved);
    evaluated_ = dirty.chunks.size();
    CheckOk(view.Evaluate(*planned_, scenario_.box, dirty.chunks));
  }

 private:
  std::shared_ptr<const PolygonMesh> mesh_;
  SceneLattices lattices_;
  std::shared_ptr<const std::vector<Vec3d>> planned_;  // the control points of the plan
  size_t evaluated_ = 0;                               // chunks at the last move
  Scenario scenario_;
};

using Move = void (SummedScene::*)(DeformView&, size_t);

void CountSum(benchmark::State& state, const SummedScene& sum, const SummedScene& one) {
  const auto count = [&](const char* name, size_t value) {
    state.counters[name] = static_cast<double>(value);
  };
  count("patches", sum.scenario().plan->patches.size());
  count("one_patches", one.scenario().plan->patches.size());
  count("points", sum.scenario().control_points[0].size());
  count("one_points", one.scenario().control_points[0].size());
}

void SumMoves(benchmark::State& state, size_t lattices, Move move) {
  SummedScene sum(lattices), one(1);
  const ViewSpec spec{.segments = 10, .position_bits = 12, .normal_bits = 8};
  const auto view = MakeView(sum.scenario(), Pipeline::kFused, spec, 1);
  const auto one_view = MakeView(one.scenario(), Pipeline::kFused, spec, 1);
  for (const absl::Status& status : {sum.Check(*view), one.Check(*one_view)}) {
    if (!status.ok()) return state.SkipWithError(std::string(status.message()).c_str());
  }
  TakeTurns(state, {"sum", [&](size_t frame) { (sum.*move)(*view, frame); }},
            {"one", [&](size_t frame) { (one.*move)(*one_view, frame); }});
  CountSum(state, sum, one);
  state.counters["chunks"] = static_cast<double>(sum.evaluated_chunks());
  state.counters["one_chunks"] = static_cast<double>(one.evaluated_chunks());
}

void SumPlans(benchmark::State& state, size_t lattices) {
  const SummedScene sum(lattices), one(1);
  TakeTurns(state, {"sum", [&](size_t) { benchmark::DoNotOptimize(sum.MakeSumPlan()); }},
            {"one", [&](size_t) { benchmark::DoNotOptimize(one.MakeSumPlan()); }});
  CountSum(state, sum, one);
}

}  // namespace

void RegisterSumBenches() {
  for (const size_t lattices : {size_t{2}, size_t{4}}) {
    const auto name = [&](const char* what) {
      return fmt::format("sums/torus-17k/{}lattices/{}", lattices, what);
    };
    RegisterTurns(name("frame"), [lattices](benchmark::State& state) {
      SumMoves(state, lattices, &SummedScene::MoveAll);
    });
    RegisterTurns(name("edit"), [lattices](benchmark::State& state) {
      SumMoves(state, lattices, &SummedScene::MoveOne);
    });
    RegisterTurns(name("plan"), [lattices](benchmark::State& state) { SumPlans(state, lattices); });
  }
}

}  // namespace latticed::bench
