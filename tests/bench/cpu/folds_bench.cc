// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Certifying folds of a torus in an 8 x 8 x 8 lattice on one core: after an edit of one control point in the middle, and of
// all boxes. The same of the volume under two lattices of 7^3 control points, degree 2, that are turned against each other.
// The reports are compared with samples of the definition first.
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/ffd/direct_ffd.h"
#include "core/folds/fold_certifier.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"
#include "tests/support/test_meshes.h"

namespace latticed::bench {
namespace {

constexpr int kSize = 8;
constexpr double kNoise = 0.02;  // of the frame's edge: nothing folds

double Determinant(const std::array<Vec3d, 3>& j) { return Dot(j[0], Cross(j[1], j[2])); }

// Whether det J > 0 at the middle of each box, as the report says of all of it.
bool AgreesWithSamples(const DeformPlan& plan, std::span<const Vec3d> points,
                       const FoldReport& report) {
  const FrameMap map(plan.structure);
  bool agrees = true;
  for (uint32_t box = 0; box < plan.outside_box(); ++box) {
    const Vec3d middle = map.ToWorld(0.5 * (plan.boxes[box].lower + plan.boxes[box].upper));
    const double there = Determinant(EvaluateWorld(plan, points, middle).jacobian);
    if (report.StateOf(box) == FoldState::kCertified) agrees = agrees && there > 0;
  }
  return agrees;
}

// After an edit of one control point, or of all boxes where there is none.
void TimeCertificate(benchmark::State& state, const std::shared_ptr<const DeformPlan>& plan,
                     FoldScope scope, const std::vector<Vec3d>& points,
                     std::optional<uint32_t> edited) {
  const FoldCertifier certifier(plan, scope);
  const FoldReport report = Checked(certifier.Certify(points));
  const std::array changed{edited.value_or(0)};
  if (!AgreesWithSamples(*plan, points, report) ||
      certifier.Recertify(report, changed, points) != report) {
    return state.SkipWithError("the report is wrong");
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(edited.has_value() ? certifier.Recertify(report, changed, points)
                                                : Checked(certifier.Certify(points)));
  }
  state.counters["boxes"] = static_cast<double>(report.boxes);
  state.counters["folded"] = static_cast<double>(report.Count(FoldState::kFolded));
  state.counters["undecided"] = static_cast<double>(report.Count(FoldState::kUndecided));
}

uint32_t MiddlePoint(const LatticeStructure& s) {
  return static_cast<uint32_t>(s.Index(s.size[0] / 2, s.size[1] / 2, s.size[2] / 2));
}

void Certify(benchmark::State& state, int degree, FoldScope scope, bool all) {
  const auto mesh = MakeTorus(250, 100);
  const auto lattice = Checked(
      FitLattice(mesh->ComputeBounds(), {kSize, kSize, kSize}, {degree, degree, degree}, 0.05));
  const auto plan = Checked(MakePlan(mesh, lattice.structure));
  const std::vector<Vec3d> points = testing::Jitter(plan->structure, kNoise, 1);
  std::optional<uint32_t> edited;
  if (!all) edited = MiddlePoint(plan->structure);
  TimeCertificate(state, plan, scope, points, edited);
}

// `noise`: of the shortest distance of control points. `of`: the lattice whose middle control point is edited.
void CertifyTurned(benchmark::State& state, double noise, std::optional<size_t> of) {
  const auto mesh = MakeTorus(250, 100);
  std::vector<LatticeStructure> structures;
  std::vector<Vec3d> points;
  for (const double turn : {0.0, 0.5}) {
    structures.push_back(testing::MakeStructure(
        mesh->ComputeBounds(),
        {.extra = {4, 4, 4}, .scale = turn == 0 ? 1.1 : 0.9, .turn = turn, .shift = {turn / 4}}));
    const std::vector<Vec3d> own = testing::Jitter(structures.back(), noise / 6, 1);
    points.insert(points.end(), own.begin(), own.end());
  }
  const auto plan = Checked(
      MakePlan(mesh, structures[0], {}, NeverStop, nullptr, std::span(structures).subspan(1)));
  std::optional<uint32_t> edited;
  if (of.has_value()) {
    edited = MiddlePoint(structures[*of]) +
             static_cast<uint32_t>(*of == 0 ? 0 : plan->turned[0].first_point);
  }
  TimeCertificate(state, plan, FoldScope::kVolume, points, edited);
}

}  // namespace

void RegisterFoldsBenches() {
  for (const int degree : {1, 2, 3}) {
    for (const auto& [scope, name] :
         {std::pair{FoldScope::kSurface, "surface"}, std::pair{FoldScope::kVolume, "volume"}}) {
      for (const bool all : {false, true}) {
        RegisterTimed(fmt::format("folds/degree{}/{}/{}", degree, name,
                                  all ? "all-boxes" : "one-control-point"),
                      [=](benchmark::State& state) { Certify(state, degree, scope, all); });
      }
    }
  }
  for (const int percent : {5, 15, 30}) {
    const auto add = [percent](const char* name, std::optional<size_t> of) {
      RegisterTimed(fmt::format("folds/turned/noise{}/{}", percent, name),
                    [=](benchmark::State& state) { CertifyTurned(state, 0.01 * percent, of); });
    };
    add("own-control-point", 0);
    add("turned-control-point", 1);
    add("all-boxes", std::nullopt);
  }
}

}  // namespace latticed::bench
