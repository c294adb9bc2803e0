// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/lattices/mixed_session.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "core/ffd/outside/outside_rules.h"
#include "fmt/format.h"
#include "server/wire/converters.h"
#include "tests/support/definition.h"
#include "tests/support/test_meshes.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

constexpr uint32_t kMixedSeed = 26'000;
constexpr int kPointsCompared = 20;
// Sizes are up to 10, and each of a few lattices keeps 1e-14 of its own (core/ffd/outside/README.md, core/ffd/sum/README.md).
constexpr double kCloseTo = 1e-12;
constexpr char kTooLarge[] = "lattices: their sum has";
constexpr char kAtRest[] = "rest-scene";

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
    const Vec3d at = map.ToParameter(p);
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      inside = inside && at[a] > s.domain_begin(a) && at[a] < s.domain_end(a);
    }
    return inside;
  });
}

std::vector<uint32_t> HeldBy(const v1::LatticeState& state) {
  const auto& held = state.constraints().held();
  std::vector<uint32_t> points(held.begin(), held.end());
  std::ranges::sort(points);
  return points;
}

Lattice LatticeOf(const v1::LatticeState& state) {
  const auto lattice = FromProto(state.lattice(), "");
  EXPECT_OK(lattice);
  return lattice.ok() ? *lattice : Lattice();
}

}  // namespace

void MixedSession::SetUp() {
  const char* const given = std::getenv("LATTICED_SEED");
  const auto seed = (given == nullptr ? kMixedSeed : static_cast<uint32_t>(std::atoi(given))) +
                    static_cast<uint32_t>(GetParam());
  RecordProperty("seed", static_cast<int>(seed));
  std::printf("seed %u\n", seed);
  random_.seed(seed);
  Restart();
  mesh_ = Upload(CubeOfTriangles());
  std::vector<v1::Lattice> lattices;
  for (const auto& [kind, turn] :
       {std::pair{Kind::kWhole, 0.0}, {Kind::kSpot, 0.0}, {Kind::kHalf, 0.5}}) {
    NumberState state{
        .present = true, .lattice = DrawLattice(kind, turn), .held = {}, .weights = {}};
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
    for (double& width : s.outside.widths) width = Number(0.15, 0.6);
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
  options.shift = {Number(-away, away), Number(-away, away), Number(-away, away)};
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
    if (wanted.empty()) wanted = points;
    EXPECT_EQ(points.size(), wanted.size()) << what;
    for (size_t i = 0; i < std::min(points.size(), wanted.size()); ++i) {
      EXPECT_LE(Norm(points[i] - wanted[i]), kCloseTo) << what << ' ' << i;
    }
    wanted = points;
    if (is_structural) next.held = HeldBy(state);
  }
  model_.Do(number, std::move(next));
}

bool MixedSession::Send(const v1::EditBatch& batch, const std::string& what, NumberState next,
                        bool is_structural) {
  const absl::Status status = Apply(batch);
  if (status.ok()) {
    TakeOver(batch.lattice(), what, std::move(next), is_structural);
    return true;
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

void MixedSession::ExpectModel() {
  ASSERT_EQ(Numbers(), model_.Present());
  EXPECT_EQ(Get().weighted(), model_.weights().has_value());
  for (const uint32_t number : model_.Present()) {
    SCOPED_TRACE(fmt::format("lattice {}", number));
    const NumberState& model = model_.Now(number);
    const v1::LatticeState state = LatticeAt(number);
    const latticed::Lattice lattice = LatticeOf(state);
    EXPECT_EQ(lattice.structure, model.lattice.structure);
    EXPECT_EQ(lattice.control_points, model.lattice.control_points);
    EXPECT_EQ(state.has_strength() ? state.strength() : 1, model.strength);
    EXPECT_EQ(HeldBy(state), model.held);
  }
  const std::vector<LatticeDefinition> lattices = model_.Definitions();
  // Within the cube: further out a lattice that ends would end the sum.
  const std::vector<Vec3d> world = SomePoints(kPointsCompared);
  const std::vector<Vec3d> moved = Evaluate(world);
  for (size_t n = 0; n < world.size(); ++n) {
    ASSERT_LE(Norm(moved[n] - SumAt(lattices, world[n], world[n]).position), kCloseTo) << n;
  }
  ExpectSurfacePoints(lattices);
}

void MixedSession::ExpectSurfacePoints(std::span<const LatticeDefinition> lattices) {
  auto request = For<v1::EvaluatePointsRequest>();
  std::vector<Vec3d> wanted;
  for (int n = 0; n < kPointsCompared; ++n) {
    const auto triangle = static_cast<uint32_t>(Below(static_cast<int>(kCubeTriangles.size())));
    const double a = Number(0, 1), b = Number(0, 1 - a);
    const std::array<double, 3> at{a, b, 1 - a - b};
    v1::SurfacePoint& point = *request.mutable_surface_points()->add_points();
    point.set_face(triangle);
    Vec3d x;
    for (uint32_t c = 0; c < 3; ++c) {
      point.add_corners(3 * triangle + c);
      point.add_barycentrics(at[c]);
      x += at[c] * kCubeVertices[kCubeTriangles[triangle][c]];
    }
    wanted.push_back(x + model_.WeightAt(triangle, at) * (SumAt(lattices, x, x).position - x));
  }
  v1::EvaluatePointsResponse response;
  ASSERT_OK(Call(&Scenes::EvaluatePoints, request, &response));
  ASSERT_EQ(static_cast<size_t>(response.positions_size()), 3 * wanted.size());
  for (int n = 0; n < kPointsCompared; ++n) {
    const Vec3d got{response.positions(3 * n), response.positions(3 * n + 1),
                    response.positions(3 * n + 2)};
    ASSERT_LE(Norm(got - wanted[static_cast<size_t>(n)]), kCloseTo) << n;
  }
}

// A scene of the same lattices at rest has the same patches.
void MixedSession::ExpectSurface() {
  std::vector<v1::Lattice> lattices;
  for (const uint32_t number : model_.Present()) {
    lattices.push_back(ToProto(model_.Now(number).lattice.structure, {}));
  }
  v1::CreateSceneRequest request = RequestOf(lattices, kAtRest);
  if (model_.weights().has_value()) {
    request.mutable_weights()->set_values(BytesOfWeights(*model_.weights()));
  }
  ASSERT_OK(Create(request));
  const std::vector<Vec3d> rest = PointsOfPatches(kAtRest), moved = PointsOfPatches(kScene);
  ASSERT_OK(DeleteScene(kAtRest));
  ASSERT_EQ(rest.size(), moved.size());
  const std::vector<LatticeDefinition> definitions = model_.Definitions();
  Bounds bounds;
  double most = 0;
  for (size_t n = 0; n < rest.size(); ++n) {
    const Vec3d x = rest[n];
    const Vec3d wanted = x + model_.WeightAt(x) * (SumAt(definitions, x, x).position - x);
    bounds.Extend(wanted);
    most = std::max(most, Norm(moved[n] - wanted));
  }
  // The D of this tolerance is no less, and rounding of the points at rest is a tenth of it.
  EXPECT_LE(most, kGemmPosition * bounds.diagonal());
  ++counts_["surfaces compared"];
}

std::vector<Vec3d> MixedSession::PointsOfPatches(const std::string& scene) {
  auto request = For<v1::GetUpdateRequest>(scene);
  request.mutable_view()->set_encoding(v1::ENCODING_RAW);
  request.mutable_view()->set_normals(v1::NORMAL_MODE_NONE);
  request.mutable_view()->set_segments(2);
  EventLog log;
  EXPECT_OK(Update(request, log));
  EXPECT_EQ(log.quantisations.size(), 1u);
  const v1::Vec3& origin = log.quantisations.back().origin();
  const Vec3d local_origin{origin.x(), origin.y(), origin.z()};
  std::vector<Vec3d> points;
  for (const auto& [index, bytes] : log.chunks) {
    for (size_t at = 0; at < bytes.size(); at += sizeof(Vec3f)) {
      Vec3f p;
      std::memcpy(&p, &bytes[at], sizeof(p));
      points.push_back(local_origin + ToDouble(p));
    }
  }
  EXPECT_FALSE(points.empty());
  return points;
}

}  // namespace latticed::testing
