// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A lattice that goes on outside its frame (core/ffd/outside/), and the same with points outside that stay: half of a
// torus lies outside. Both follow the same moves of the same control points, by turns, one thread.
//
//   outside/torus-17k/<mode>/frame   from control points to vertices: 10 segments, facet normals, 12- and 8-bit integers
//   outside/torus-17k/<mode>/plan    from mesh and lattice to plan
//
//   continued_ms, fixed_ms, ratio    least times (turns.h)
//   patches, fixed_patches           of the plans
#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/base/bounds.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/outside/outside_map.h"
#include "core/ffd/outside/outside_rules.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/bench/turns.h"
#include "tests/bench/verify.h"

namespace latticed::bench {
namespace {

constexpr uint32_t kOutsideSeed = 20261129;
constexpr double kFalloffWidth = 0.3;  // of the frame's edges

struct OutsideCase {
  const char* name;
  Outside outside;
};

Outside AllSides(OutsideMode mode, bool smooth, double width) {
  Outside outside{.mode = mode, .smooth = smooth};
  outside.widths.fill(width);
  return outside;
}

class HalfTorus {
 public:
  explicit HalfTorus(const Outside& outside) : mesh_(MakeTorus(111, 46)) {
    Bounds half = mesh_->ComputeBounds();
    half.max.x = 0.5 * (half.min.x + half.max.x);
    Lattice lattice = Checked(FitLattice(half, {7, 7, 7}, {2, 2, 2}, 0.05));
    lattice.structure.outside = outside;
    lattice.structure.outside = ResolvedOutside(lattice.structure, mesh_->positions);
    CheckOk(Validate(lattice.structure));
    map_ = std::make_unique<OutsideMap>(lattice.structure);
    std::mt19937 random(kOutsideSeed);
    std::uniform_real_distribution<double> move(-0.1, 0.1);
    Bounds bounds = mesh_->ComputeBounds();
    for (size_t frame = 0; frame < 2; ++frame) {
      given_[frame] = lattice.control_points;
      for (Vec3d& p : given_[frame]) p += {move(random), move(random), move(random)};
    }
    scenario_ = MakeScenario("half-torus", MakeHalfPlan());
    for (size_t frame = 0; frame < 2; ++frame) {
      scenario_.control_points[frame] = Planned(frame);
      for (const Vec3d p : scenario_.control_points[frame]) bounds.Extend(p);
    }
    scenario_.box = FitQuantisationBox(bounds, 1);
  }

  const Scenario& scenario() const { return scenario_; }
  std::shared_ptr<const DeformPlan> MakeHalfPlan() const {
    return Checked(MakePlan(mesh_, map_->continued()));
  }
  // The control points of the plan, as the server makes them from the given ones.
  std::vector<Vec3d> Planned(size_t frame) const {
    return map_->is_identity() ? given_[frame] : map_->Continue(given_[frame]);
  }
  void Evaluate(DeformView& view, size_t frame) const {
    CheckOk(view.Evaluate(Planned(frame % 2), scenario_.box, scenario_.all_chunks));
  }

  // The view is that of the plan's definition, and inside the frame that is formula (1) of the given control points.
  absl::Status Check(DeformView& view) const {
    constexpr double kAllowed = 1e-12;
    const FrameMap frame(map_->structure());
    for (const Vec3d p : mesh_->positions) {
      const Vec3d place = frame.ToParameter(p);
      if (!(place.x > 0 && place.x < 1)) continue;  // the frame ends in x alone
      const Vec3d want = EvaluateWorld(map_->structure(), given_[0], p).position;
      const Vec3d got = EvaluateWorld(map_->continued(), scenario_.control_points[0], p).position;
      if (!(Norm(got - want) <= kAllowed)) return absl::InternalError("the inside differs");
    }
    return Verify(scenario_, Pipeline::kFused, view);
  }

 private:
  std::shared_ptr<const PolygonMesh> mesh_;
  std::unique_ptr<const OutsideMap> map_;
  std::array<std::vector<Vec3d>, 2> given_;
  Scenario scenario_;
};

void CountPatches(benchmark::State& state, const HalfTorus& continued, const HalfTorus& fixed) {
  state.counters["patches"] = static_cast<double>(continued.scenario().plan->patches.size());
  state.counters["fixed_patches"] = static_cast<double>(fixed.scenario().plan->patches.size());
}

void OutsideFrames(benchmark::State& state, const Outside& outside) {
  const HalfTorus continued(outside), fixed(Outside{});
  const ViewSpec spec{.segments = 10, .position_bits = 12, .normal_bits = 8};
  const auto view = MakeView(continued.scenario(), Pipeline::kFused, spec, 1);
  const auto fixed_view = MakeView(fixed.scenario(), Pipeline::kFused, spec, 1);
  for (const absl::Status& status : {continued.Check(*view), fixed.Check(*fixed_view)}) {
    if (!status.ok()) return state.SkipWithError(std::string(status.message()).c_str());
  }
  TakeTurns(state, {"continued", [&](size_t frame) { continued.Evaluate(*view, frame); }},
            {"fixed", [&](size_t frame) { fixed.Evaluate(*fixed_view, frame); }});
  CountPatches(state, continued, fixed);
}

void OutsidePlans(benchmark::State& state, const Outside& outside) {
  const HalfTorus continued(outside), fixed(Outside{});
  TakeTurns(state,
            {"continued", [&](size_t) { benchmark::DoNotOptimize(continued.MakeHalfPlan()); }},
            {"fixed", [&](size_t) { benchmark::DoNotOptimize(fixed.MakeHalfPlan()); }});
  CountPatches(state, continued, fixed);
}

}  // namespace

void RegisterOutsideBenches() {
  for (const OutsideCase& mode :
       {OutsideCase{"falloff-c1", AllSides(OutsideMode::kFalloff, true, kFalloffWidth)},
        OutsideCase{"falloff-c0", AllSides(OutsideMode::kFalloff, false, kFalloffWidth)},
        OutsideCase{"linear", AllSides(OutsideMode::kLinear, true, 0)}}) {
    const auto name = [&](const char* what) {
      return fmt::format("outside/torus-17k/{}/{}", mode.name, what);
    };
    RegisterTurns(name("frame"), [outside = mode.outside](benchmark::State& state) {
      OutsideFrames(state, outside);
    });
    RegisterTurns(name("plan"), [outside = mode.outside](benchmark::State& state) {
      OutsidePlans(state, outside);
    });
  }
}

}  // namespace latticed::bench
