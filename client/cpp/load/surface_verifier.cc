// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/surface_verifier.h"

#include <algorithm>
#include <numeric>

#include "core/base/bounds.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr size_t kChunks = 4;
constexpr size_t kPointsPerChunk = 1024;  // one EvaluatePoints takes up to 4,096 points
constexpr double kPrecision = 1e-6;       // as a fraction of D

std::vector<Vec3d> VectorsOf(const google::protobuf::RepeatedField<double>& flat) {
  std::vector<Vec3d> vectors;
  for (int i = 0; i + 2 < flat.size(); i += 3) {
    vectors.push_back({flat[i], flat[i + 1], flat[i + 2]});
  }
  return vectors;
}

double Diagonal(const v1::Lattice& lattice) {
  Bounds bounds;
  for (const Vec3d point : VectorsOf(lattice.control_points())) bounds.Extend(point);
  return bounds.diagonal();
}

}  // namespace

absl::Status SurfaceVerifier::Check(const Surface& surface, size_t offset,
                                    VerifiedPoints* verified) {
  if (provenance_.topology_id() != surface.topology().topology_id()) {
    LATTICED_ASSIGN_OR_RETURN(provenance_,
                              client_->GetTopology(scene_, surface.topology().topology_id()));
  }
  v1::EvaluatePointsRequest request;
  request.set_scene(scene_);
  std::vector<Vec3d> positions;
  const size_t chunks = surface.chunk_count(), most = std::min(kChunks, chunks);
  for (size_t i = 0; i < most; ++i) {  // evenly spread
    LATTICED_RETURN_IF_ERROR(
        Sample(surface, (offset + i * chunks / most) % chunks, &request, &positions));
  }
  ++verified->surfaces;
  if (positions.empty()) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(const auto definition, client_->EvaluatePoints(request));
  if (definition.revision() != surface.revision()) {
    return absl::AbortedError(fmt::format("scene {} is edited by somebody else: revision {} of {}",
                                          scene_, surface.revision(), definition.revision()));
  }
  const double allowed =
      0.5 * surface.quantisation().step() + kPrecision * Diagonal(surface.lattice().lattice());
  const std::vector<Vec3d> expected = VectorsOf(definition.positions());
  for (size_t i = 0; i < positions.size(); ++i) {
    const Vec3d got = positions[i], off = Max(got - expected[i], expected[i] - got);
    const double of_allowed = std::max({off.x, off.y, off.z}) / allowed;
    if (!(of_allowed <= 1)) {  // also true for NaN
      return absl::DataLossError(fmt::format(
          "a point of revision {} is off by {:.3g} times what is allowed: decoded {} {} {}, "
          "EvaluatePoints says {} {} {}",
          surface.revision(), of_allowed, got.x, got.y, got.z, expected[i].x, expected[i].y,
          expected[i].z));
    }
    verified->worst = std::max(verified->worst, of_allowed);
    ++verified->points;
  }
  return absl::OkStatus();
}

absl::Status SurfaceVerifier::Sample(const Surface& surface, size_t chunk,
                                     v1::EvaluatePointsRequest* request,
                                     std::vector<Vec3d>* positions) const {
  const auto index = static_cast<uint32_t>(chunk);
  LATTICED_ASSIGN_OR_RETURN(const auto decoded, surface.Decode({&index, 1}));
  const Surface::PatchRange patches = surface.PatchesOf(chunk);
  LATTICED_ASSIGN_OR_RETURN(const auto layouts, surface.Layouts(chunk));
  const size_t count = decoded.positions.size();
  size_t stride = (count + kPointsPerChunk - 1) / kPointsPerChunk;
  // So that all points of a common pattern occur.
  while (std::gcd(stride, layouts.front().point_count()) > 1) ++stride;
  size_t of_chunk = 0, first = 0;
  for (size_t i = 0; i < count; i += stride) {
    while (i - first >= layouts[of_chunk].point_count()) {
      first += layouts[of_chunk++].point_count();
    }
    const uint64_t patch = patches.first + of_chunk;
    if (provenance_.on_lattice_face(static_cast<int>(patch))) continue;
    *request->mutable_surface_points()->add_points() =
        SurfacePointOf(layouts[of_chunk], patch, i - first);
    positions->push_back(decoded.positions[i]);
  }
  return absl::OkStatus();
}

v1::SurfacePoint SurfaceVerifier::SurfacePointOf(const PatchLayout& layout, uint64_t patch,
                                                 size_t point) const {
  const int p = static_cast<int>(patch);
  v1::SurfacePoint result;
  result.set_face(provenance_.faces(p));
  for (int k = 0; k < 3; ++k) {
    result.add_corners(provenance_.corners(3 * p + k));
    double barycentric = 0;
    for (int c = 0; c < 3; ++c) {
      barycentric += layout.points[3 * point + static_cast<size_t>(c)] *
                     provenance_.barycentrics(9 * p + 3 * c + k) / layout.denominator;
    }
    result.add_barycentrics(std::clamp(barycentric, 0.0, 1.0));
  }
  return result;
}

}  // namespace latticed::client
