// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Comparisons of a session with its model.
#include <algorithm>
#include <cstring>

#include "fmt/format.h"
#include "server/wire/converters.h"
#include "tests/server/mixed/mixed_session.h"
#include "tests/support/definition.h"

namespace latticed::testing {
namespace {

constexpr int kPointsCompared = 20;
constexpr char kAtRest[] = "rest-scene";

}  // namespace

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
    EXPECT_EQ(MirrorOf(state), model.mirror);
  }
  const std::vector<LatticeDefinition> lattices = model_.Definitions();
  // Within the cube: further out a lattice that ends would end the sum.
  const std::vector<Vec3d> world = SomePoints(kPointsCompared);
  const std::vector<Vec3d> moved = Evaluate(world);
  for (size_t n = 0; n < world.size(); ++n) {
    ASSERT_LE(Norm(moved[n] - SumAt(lattices, world[n], world[n]).position), kCloseTo) << n;
  }
  ExpectSurfacePoints(lattices);
  if (Below(3) == 0) ExpectFolds(lattices);
}

CubePlace MixedSession::AnyPlace() {
  CubePlace place;
  place.triangle = static_cast<size_t>(Below(static_cast<int>(kCubeTriangles.size())));
  const double a = Number(0, 1), b = Number(0, 1 - a);
  place.barycentrics = {a, b, 1 - a - b};
  for (size_t c = 0; c < 3; ++c) {
    place.rest += place.barycentrics[c] * kCubeVertices[kCubeTriangles[place.triangle][c]];
  }
  return place;
}

v1::SurfacePoint MixedSession::SurfacePointOf(const CubePlace& place) {
  v1::SurfacePoint point;
  const auto triangle = static_cast<uint32_t>(place.triangle);
  point.set_face(triangle);
  for (uint32_t c = 0; c < 3; ++c) {
    point.add_corners(3 * triangle + c);
    point.add_barycentrics(place.barycentrics[c]);
  }
  return point;
}

void MixedSession::ExpectSurfacePoints(std::span<const LatticeDefinition> lattices) {
  auto request = For<v1::EvaluatePointsRequest>();
  std::vector<Vec3d> wanted;
  for (int n = 0; n < kPointsCompared; ++n) {
    const CubePlace place = AnyPlace();
    *request.mutable_surface_points()->add_points() = SurfacePointOf(place);
    wanted.push_back(model_.SurfaceAt(lattices, place, place.rest).position);
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
    const Vec3d wanted = model_.SurfaceAt(definitions, PlaceAt(rest[n]), rest[n]).position;
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
