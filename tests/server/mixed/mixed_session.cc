// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/mixed/mixed_session.h"

#include <algorithm>
#include <utility>

#include "core/ffd/direct_ffd.h"
#include "core/ffd/outside/outside_rules.h"
#include "fmt/format.h"
#include "server/wire/converters.h"
#include "tests/support/seed.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

constexpr uint32_t kMixedSeed = 26'000;
constexpr char kTooLarge[] = "lattices: their sum has";

std::string CubeOfTriangles() {
  std::string obj;
  for (const Vec3d p : kCubeVertices) obj += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  for (const auto& t : kCubeTriangles) {
    obj += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  }
  return obj;
}

Bounds CubeBounds() {
  Bounds bounds;
  for (const Vec3d p : kCubeVertices) bounds.Extend(p);
  return bounds;
}

bool ContainsCube(const LatticeStructure& s) {
  return std::ranges::all_of(kCubeVertices, [map = FrameMap(s), &s](Vec3d p) {
    return FindVolumePlace(s, map, p).has_value();
  });
}

}  // namespace

std::vector<uint32_t> HeldBy(const v1::LatticeState& state) {
  const auto& held = state.constraints().held();
  std::vector<uint32_t> points(held.begin(), held.end());
  std::ranges::sort(points);
  return points;
}

std::optional<int> MirrorOf(const v1::LatticeState& state) {
  const v1::LatticeAxis axis = state.constraints().mirror();
  if (axis == v1::LATTICE_AXIS_UNSPECIFIED) return std::nullopt;
  return static_cast<int>(axis) - 1;
}

Lattice LatticeOf(const v1::LatticeState& state) {
  const auto lattice = FromProto(state.lattice(), "");
  EXPECT_OK(lattice);
  return lattice.ok() ? *lattice : Lattice();
}

void MixedSession::SetUp() {
  random_.seed(SeedOfCase(kMixedSeed, GetParam()));
  Restart();
  mesh_ = Upload(CubeOfTriangles());
  std::vector<v1::Lattice> lattices;
  for (const auto& [kind, turn] :
       {std::pair{Kind::kWhole, 0.0}, {Kind::kSpot, 0.0}, {Kind::kHalf, 0.5}}) {
    NumberState state{.present = true,
                      .lattice = DrawLattice(kind, turn),
                      .held = {},
                      .mirror = {},
                      .weights = {}};
    lattices.push_back(ToProto(state.lattice));
    model_.Begin(static_cast<uint32_t>(lattices.size()) - 1, std::move(state));
  }
  ASSERT_OK(Create(RequestOf(lattices)));
}

uint32_t MixedSession::AnyPresent() {
  const std::vector<uint32_t> present = model_.Present();
  return present[static_cast<size_t>(Below(static_cast<int>(present.size())))];
}

uint32_t MixedSession::AnyPoint(uint32_t number) {
  return static_cast<uint32_t>(Below(model_.Now(number).lattice.structure.control_point_count()));
}

Outside MixedSession::DrawOutside(const LatticeStructure& structure) {
  LatticeStructure s = structure;
  const int any = Below(3);
  const bool contains = ContainsCube(s);
  if (contains && any == 0) return {};
  // A small one would explode before it reaches the end of the cube.
  const bool is_line = !contains && any == 0 && Norm(s.frame.edges[0]) > 0.6;
  s.outside = {.mode = is_line ? OutsideMode::kLinear : OutsideMode::kFalloff,
               .smooth = is_line || Below(2) == 0,
               .widths = {},
               .steps = {}};
  if (!is_line) {
    const bool is_symmetric = Below(2) == 0;
    for (size_t side = 0; side < 6; ++side) {
      s.outside.widths[side] =
          is_symmetric && side % 2 == 1 ? s.outside.widths[side - 1] : Number(0.15, 0.6);
    }
  }
  return ResolvedOutside(s, kCubeVertices);
}

latticed::Lattice MixedSession::DrawLattice(Kind kind, double turn) {
  LatticeOptions options{.turn = turn};
  for (size_t a = 0; a < 3; ++a) {
    options.degree[a] = Below(4) == 0 ? 3 : 1 + Below(2);  // few sums are then too large
    options.extra[a] = Below(2);
  }
  const double away = kind == Kind::kWhole ? 0.05 : kind == Kind::kHalf ? 0.2 : 0.35;
  options.shift = Offset(away);
  options.scale = kind == Kind::kHalf ? 0.75 : 0.4;
  if (kind == Kind::kWhole) options.scale = turn == 0 ? 1.2 : 2;
  latticed::Lattice lattice{.structure = MakeStructure(CubeBounds(), options),
                            .control_points = {}};
  lattice.structure.outside = DrawOutside(lattice.structure);
  lattice.control_points = Jitter(lattice.structure, 0.06, static_cast<uint32_t>(random_()));
  return lattice;
}

void MixedSession::TakeOver(uint32_t number, const std::string& what, NumberState next,
                            bool is_structural) {
  ++counts_[what];
  if (next.present) {
    const v1::LatticeState state = LatticeAt(number);
    const std::vector<Vec3d> points = LatticeOf(state).control_points;
    std::vector<Vec3d>& wanted = next.lattice.control_points;
    if (wanted.empty() || keeps_volume(number)) wanted = points;
    EXPECT_EQ(points.size(), wanted.size()) << what;
    for (size_t i = 0; i < std::min(points.size(), wanted.size()); ++i) {
      EXPECT_LE(Norm(points[i] - wanted[i]), kCloseTo) << what << ' ' << i;
    }
    wanted = points;
    if (is_structural) next.held = HeldBy(state);
    if (!is_structural) ExpectHeld(number, points);
  }
  model_.Do(number, std::move(next));
  if (kept_.has_value()) Follow(number);
}

void MixedSession::ExpectHeld(uint32_t number, std::span<const Vec3d> points) {
  const NumberState& before = model_.Now(number);
  for (uint32_t i = 0; i < points.size(); ++i) {
    if (!IsHeld(before, i)) continue;
    EXPECT_EQ(points[i], before.lattice.control_points[i]) << number << ", held " << i;
  }
}

bool MixedSession::Send(const v1::EditBatch& batch, const std::string& what, NumberState next,
                        bool is_structural) {
  v1::EditResult result;
  const absl::Status status = Apply(batch, &result);
  residual_ = result.drag_residual();
  if (status.ok()) {
    TakeOver(batch.lattice(), what, std::move(next), is_structural);
    return true;
  }
  const std::string reason = Reason(status);
  if ((batch.refuse_folds() && reason == "FOLD") ||
      (kept_.has_value() && reason == "VOLUME_NOT_KEPT")) {
    ++counts_[what + ", refused: " + reason];
    return false;
  }
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(kTooLarge))) << what;
  ++counts_[what + ", refused for too large a sum"];
  return false;
}

void MixedSession::SendRefined(const v1::EditBatch& batch, const std::string& what,
                               NumberState next, double low, double high, double most) {
  const latticed::Lattice before = model_.Now(batch.lattice()).lattice;
  next.lattice.control_points.clear();
  if (!Send(batch, what, std::move(next))) return;
  const latticed::Lattice& after = model_.Now(batch.lattice()).lattice;
  const LatticeStructure& s = before.structure;
  const FrameMap map(s);
  const std::array old_one{LatticeDefinition(s, before.control_points)};
  const std::array new_one{LatticeDefinition(after.structure, after.control_points)};
  for (int n = 0; n < 60; ++n) {
    Vec3d parameter;
    for (int a = 0; a < 3; ++a) {
      const double range = s.domain_end(a) - s.domain_begin(a);
      parameter[a] = s.domain_begin(a) + Number(low, high) * range;
    }
    const Vec3d x = map.ToWorld(parameter);
    ASSERT_LE(Norm(SumAt(new_one, x, x).position - SumAt(old_one, x, x).position), most) << what;
  }
}

}  // namespace latticed::testing
