// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/surface_verifier.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/base/bounds.h"
#include "core/codec/octahedral.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr size_t kChunks = 4;
constexpr size_t kPointsPerChunk = 1024;  // of the 4,096 that one EvaluatePoints may have
constexpr double kFusedPrecision = 3e-7, kGemmPrecision = 1e-6;  // of D
constexpr double kNormalPrecision = 2e-5;                        // radians per kappa
constexpr double kLargestCondition = 100;

Vec3d VectorAt(const google::protobuf::RepeatedField<double>& flat, size_t i) {
  const int first = static_cast<int>(3 * i);
  return {flat[first], flat[first + 1], flat[first + 2]};
}

double ControlPointsDiagonal(const v1::Lattice& lattice) {
  Bounds bounds;
  for (int i = 0; i < lattice.control_points_size() / 3; ++i) {
    bounds.Extend(VectorAt(lattice.control_points(), static_cast<size_t>(i)));
  }
  return bounds.diagonal();
}

// How much the deformation with this Jacobian can turn the normal that it has made `deformed`.
double Condition(const google::protobuf::RepeatedField<double>& jacobians, size_t i,
                 Vec3d deformed) {
  const Vec3d u = VectorAt(jacobians, 3 * i), v = VectorAt(jacobians, 3 * i + 1),
              w = VectorAt(jacobians, 3 * i + 2);
  const Vec3d cofactor[3] = {Cross(v, w), Cross(w, u), Cross(u, v)};
  // deformed ~ cof(J) N = det(J) J^-T N
  const Vec3d rest{Dot(u, deformed), Dot(v, deformed), Dot(w, deformed)};
  const Vec3d carried = cofactor[0] * rest.x + cofactor[1] * rest.y + cofactor[2] * rest.z;
  const double norm = std::sqrt(Dot(cofactor[0], cofactor[0]) + Dot(cofactor[1], cofactor[1]) +
                                Dot(cofactor[2], cofactor[2]));
  return norm * Norm(rest) / Norm(carried);
}

absl::Status Mismatch(const char* what, const Surface& surface, double of_allowed, Vec3d got,
                      Vec3d definition) {
  return absl::DataLossError(
      fmt::format("a {} of revision {} is off by {:.3g} times what is allowed: decoded {} {} {}, "
                  "EvaluatePoints says {} {} {}",
                  what, surface.revision(), of_allowed, got.x, got.y, got.z, definition.x,
                  definition.y, definition.z));
}

}  // namespace

absl::Status SurfaceVerifier::Check(const Surface& surface, size_t offset) {
  if (provenance_.topology_id() != surface.topology().topology_id()) {
    auto topology = client_->GetTopology(scene_, surface.topology().topology_id());
    if (!topology.ok()) return topology.status();
    provenance_ = *std::move(topology);
  }
  const auto sample = TakeSample(surface, offset);
  if (!sample.ok()) return sample.status();
  if (sample->points.positions.empty()) return absl::OkStatus();
  const auto definition = client_->EvaluatePoints(sample->request);
  if (!definition.ok()) return definition.status();
  if (definition->revision() != surface.revision()) {
    return absl::AbortedError(fmt::format("scene {} is edited by somebody else: revision {} of {}",
                                          scene_, surface.revision(), definition->revision()));
  }
  const auto status = ComparePositions(surface, *sample, *definition);
  return status.ok() ? CompareNormals(surface, *sample, *definition) : status;
}

absl::StatusOr<SurfaceVerifier::Sample> SurfaceVerifier::TakeSample(const Surface& surface,
                                                                    size_t offset) const {
  Sample sample;
  sample.request.set_scene(scene_);
  const size_t count = surface.chunk_count();
  for (size_t i = 0; i < std::min(kChunks, count); ++i) {
    const auto status = AddChunk(surface, (offset + i * count / kChunks) % count, &sample);
    if (!status.ok()) return status;
  }
  return sample;
}

absl::Status SurfaceVerifier::AddChunk(const Surface& surface, size_t chunk, Sample* sample) const {
  const auto decoded = surface.Decode(chunk);
  if (!decoded.ok()) return decoded.status();
  const Surface::PatchRange patches = surface.PatchesOf(chunk);
  const size_t count = decoded->positions.size();
  const size_t per_patch = count / patches.count;
  size_t stride = (count + kPointsPerChunk - 1) / kPointsPerChunk;
  while (std::gcd(stride, per_patch) > 1) ++stride;  // so that patches differ in their points
  for (size_t i = 0; i < count; i += stride) {
    const uint64_t patch = patches.first + i / per_patch;
    if (provenance_.on_lattice_face(static_cast<int>(patch))) continue;
    *sample->request.mutable_surface_points()->add_points() =
        SurfacePointOf(surface, patch, i % per_patch);
    sample->points.positions.push_back(decoded->positions[i]);
    if (!decoded->normals.empty()) sample->points.normals.push_back(decoded->normals[i]);
  }
  return absl::OkStatus();
}

v1::SurfacePoint SurfaceVerifier::SurfacePointOf(const Surface& surface, uint64_t patch,
                                                 size_t point) const {
  const auto& pattern = surface.topology().pattern().points();
  const int p = static_cast<int>(patch);
  v1::SurfacePoint result;
  result.set_face(provenance_.faces(p));
  for (int k = 0; k < 3; ++k) {
    result.add_corners(provenance_.corners(3 * p + k));
    double barycentric = 0;
    for (int c = 0; c < 3; ++c) {
      barycentric += pattern[static_cast<int>(3 * point) + c] *
                     provenance_.barycentrics(9 * p + 3 * c + k) / surface.topology().segments();
    }
    result.add_barycentrics(std::clamp(barycentric, 0.0, 1.0));
  }
  return result;
}

absl::Status SurfaceVerifier::ComparePositions(const Surface& surface, const Sample& sample,
                                               const v1::EvaluatePointsResponse& definition) {
  const double allowed =
      0.5 * surface.quantisation().step() + (fused_ ? kFusedPrecision : kGemmPrecision) *
                                                ControlPointsDiagonal(surface.lattice().lattice());
  for (size_t i = 0; i < sample.points.positions.size(); ++i) {
    const Vec3d got = sample.points.positions[i], expected = VectorAt(definition.positions(), i);
    const Vec3d off = Max(got - expected, expected - got);
    const double of_allowed = std::max({off.x, off.y, off.z}) / allowed;
    // Also where it is not a number.
    if (!(of_allowed <= 1)) return Mismatch("point", surface, of_allowed, got, expected);
    result_.worst_position = std::max(result_.worst_position, of_allowed);
    ++result_.positions;
  }
  return absl::OkStatus();
}

absl::Status SurfaceVerifier::CompareNormals(const Surface& surface, const Sample& sample,
                                             const v1::EvaluatePointsResponse& definition) {
  if (!fused_ || surface.view().normals() != v1::NORMAL_MODE_FACET) return absl::OkStatus();
  const int bits = surface.quantisation().normal_bits();
  const double cell = bits == 0 ? 0 : 4 * std::numbers::sqrt2 / OctahedralMax(bits);
  for (size_t i = 0; i < sample.points.normals.size(); ++i) {
    const Vec3d got = ToDouble(sample.points.normals[i]),
                expected = VectorAt(definition.normals(), i);
    const double condition = Condition(definition.jacobians(), i, expected);
    if (!(condition <= kLargestCondition)) continue;  // also where the normal is undefined
    const double angle = std::atan2(Norm(Cross(got, expected)), Dot(got, expected));
    const double of_allowed = angle / (cell + kNormalPrecision * condition);
    if (!(of_allowed <= 1)) return Mismatch("normal", surface, of_allowed, got, expected);
    result_.worst_normal = std::max(result_.worst_normal, of_allowed);
    ++result_.normals;
  }
  return absl::OkStatus();
}

}  // namespace latticed::client
