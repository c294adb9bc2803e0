// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/surface_verifier.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "client/cpp/load/update_log.h"
#include "core/base/bounds.h"
#include "core/base/status_macros.h"
#include "core/codec/octahedral.h"
#include "core/ffd/vertex_normals.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

constexpr size_t kChunks = 4;
constexpr size_t kPointsPerChunk = 1024;  // one EvaluatePoints takes up to 4,096
constexpr double kFusedPrecision = 3e-7, kGemmPrecision = 1e-6;  // fraction of D
constexpr double kNormalPrecision = 2e-5;                        // radians per kappa
constexpr double kLargestKappa = 100;

Vec3d VectorAt(const google::protobuf::RepeatedField<double>& flat, size_t i) {
  const int first = static_cast<int>(3 * i);
  return {flat[first], flat[first + 1], flat[first + 2]};
}

double Diagonal(std::span<const Vec3d> points) {
  Bounds bounds;
  for (const Vec3d point : points) bounds.Extend(point);
  return bounds.diagonal();
}

std::vector<Vec3d> ControlPointsOf(const v1::Lattice& lattice) {
  std::vector<Vec3d> points(static_cast<size_t>(lattice.control_points_size()) / 3);
  for (size_t i = 0; i < points.size(); ++i) points[i] = VectorAt(lattice.control_points(), i);
  return points;
}

bool IsSmooth(const Surface& surface) { return surface.view().normals() == v1::NORMAL_MODE_SMOOTH; }

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
  LATTICED_RETURN_IF_ERROR(Prepare(surface));
  return Compare(surface, SpreadChunks(surface.chunk_count(), kChunks, offset),
                 {surface.revision(), Diagonal(ControlPointsOf(surface.lattice().lattice()))});
}

absl::Status SurfaceVerifier::CheckPast(const Surface& surface, std::span<const uint32_t> chunks,
                                        std::span<const Vec3d> control_points) {
  LATTICED_RETURN_IF_ERROR(Prepare(surface));
  if (past_ != surface.revision()) {
    LATTICED_RETURN_IF_ERROR(PutBack(control_points));
    past_ = surface.revision();
  }
  return Compare(surface, chunks, {put_back_.revision(), Diagonal(control_points)});
}

absl::Status SurfaceVerifier::PutBack(std::span<const Vec3d> control_points) {
  v1::EditBatch batch;
  batch.set_scene(scene_);
  batch.set_editor_id(editor_id_);
  batch.set_sequence(put_back_.sequence() + 1);
  batch.set_structure_id(lattice_.structure_id());
  auto& all = *batch.add_edits()->mutable_replace_control_points()->mutable_control_points();
  for (const Vec3d point : control_points) {
    for (int axis = 0; axis < 3; ++axis) all.Add(point[axis]);
  }
  LATTICED_ASSIGN_OR_RETURN(put_back_, client_->ApplyEdits(batch));
  return absl::OkStatus();
}

absl::Status SurfaceVerifier::Compare(const Surface& surface, std::span<const uint32_t> chunks,
                                      const Truth& truth) {
  LATTICED_ASSIGN_OR_RETURN(const auto sample, TakeSample(surface, chunks));
  if (sample.points.positions.empty()) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(const auto definition, client_->EvaluatePoints(sample.request));
  if (definition.revision() != truth.revision) {
    return absl::AbortedError(fmt::format("scene {} is edited by somebody else: revision {} of {}",
                                          scene_, truth.revision, definition.revision()));
  }
  auto status = ComparePositions(surface, sample, definition, truth.diagonal);
  if (status.ok()) status = CompareNormals(surface, sample, definition);
  if (status.ok()) ++result_.updates;
  return status;
}

absl::Status SurfaceVerifier::Prepare(const Surface& surface) {
  if (lattice_.structure_id() == 0) {
    LATTICED_ASSIGN_OR_RETURN(lattice_, client_->GetLattice(scene_));
  }
  if (provenance_.topology_id() != surface.topology().topology_id()) {
    LATTICED_ASSIGN_OR_RETURN(provenance_,
                              client_->GetTopology(scene_, surface.topology().topology_id()));
  }
  if (!IsSmooth(surface) || !corner_normals_.empty()) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, ParseMesh(*mesh_));
  LATTICED_ASSIGN_OR_RETURN(corner_normals_, UnitCornerNormals(mesh));
  return absl::OkStatus();
}

absl::StatusOr<SurfaceVerifier::Sample> SurfaceVerifier::TakeSample(
    const Surface& surface, std::span<const uint32_t> chunks) const {
  Sample sample;
  sample.request.set_scene(scene_);
  for (const uint32_t chunk : chunks) {
    LATTICED_RETURN_IF_ERROR(AddChunk(surface, chunk, &sample));
  }
  return sample;
}

absl::Status SurfaceVerifier::AddChunk(const Surface& surface, size_t chunk, Sample* sample) const {
  LATTICED_ASSIGN_OR_RETURN(const auto decoded, surface.Decode(chunk));
  const Surface::PatchRange patches = surface.PatchesOf(chunk);
  const size_t count = decoded.positions.size();
  const size_t per_patch = count / patches.count;
  size_t stride = (count + kPointsPerChunk - 1) / kPointsPerChunk;
  while (std::gcd(stride, per_patch) > 1) ++stride;  // so that patches differ in their points
  for (size_t i = 0; i < count; i += stride) {
    const uint64_t patch = patches.first + i / per_patch;
    if (provenance_.on_lattice_face(static_cast<int>(patch))) continue;
    *sample->request.mutable_surface_points()->add_points() =
        SurfacePointOf(surface, patch, i % per_patch);
    sample->points.positions.push_back(decoded.positions[i]);
    if (!decoded.normals.empty()) sample->points.normals.push_back(decoded.normals[i]);
    const auto pattern = surface.topology().pattern().points().begin() +
                         static_cast<std::ptrdiff_t>(3 * (i % per_patch));
    sample->at_patch_edge.push_back(std::find(pattern, pattern + 3, 0u) != pattern + 3);
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
                                               const v1::EvaluatePointsResponse& definition,
                                               double diagonal) {
  const double allowed =
      0.5 * surface.quantisation().step() + (fused_ ? kFusedPrecision : kGemmPrecision) * diagonal;
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

CarriedNormal SurfaceVerifier::NormalOf(const Surface& surface, const Sample& sample,
                                        const v1::EvaluatePointsResponse& definition,
                                        size_t i) const {
  const auto& degree = lattice_.lattice().degree();
  if (sample.at_patch_edge[i] && std::min({degree.u(), degree.v(), degree.w()}) == 1) return {};
  const Vec3d jacobian[3] = {VectorAt(definition.jacobians(), 3 * i),
                             VectorAt(definition.jacobians(), 3 * i + 1),
                             VectorAt(definition.jacobians(), 3 * i + 2)};
  Vec3d rest;
  if (!IsSmooth(surface)) {
    // deformed ~ cof(J) N = det(J) J^-T N
    const Vec3d deformed = VectorAt(definition.normals(), i);
    for (int c = 0; c < 3; ++c) rest[c] = Dot(jacobian[c], deformed);
    return {deformed, CarryNormal(jacobian, rest).kappa};
  }
  const auto& point = sample.request.surface_points().points(static_cast<int>(i));
  for (int k = 0; k < 3; ++k) {
    rest += point.barycentrics(k) * ToDouble(corner_normals_[point.corners(k)]);
  }
  CarriedNormal normal = CarryNormal(jacobian, rest);
  normal.kappa /= Norm(rest);
  return normal;
}

absl::Status SurfaceVerifier::CompareNormals(const Surface& surface, const Sample& sample,
                                             const v1::EvaluatePointsResponse& definition) {
  if (!fused_) return absl::OkStatus();
  const int bits = surface.quantisation().normal_bits();
  const double cell = bits == 0 ? 0 : 4 * std::numbers::sqrt2 / OctahedralMax(bits);
  for (size_t i = 0; i < sample.points.normals.size(); ++i) {
    const auto [expected, kappa] = NormalOf(surface, sample, definition, i);
    if (!(kappa <= kLargestKappa)) continue;  // also where the normal is undefined
    const Vec3d got = ToDouble(sample.points.normals[i]);
    const double angle = std::atan2(Norm(Cross(got, expected)), Dot(got, expected));
    const double of_allowed = angle / (cell + kNormalPrecision * kappa);
    if (!(of_allowed <= 1)) return Mismatch("normal", surface, of_allowed, got, expected);
    result_.worst_normal = std::max(result_.worst_normal, of_allowed);
    ++result_.normals;
  }
  return absl::OkStatus();
}

}  // namespace latticed::client
