// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/measure_scene.h"

#include <algorithm>

#include <array>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/measure/enclosed_volume.h"
#include "core/measure/surface_area.h"
#include "core/measure/surface_bounds.h"
#include "fmt/format.h"
#include "server/wire/converters.h"

namespace latticed {
namespace {

constexpr double kLeastAreaTolerance = 1e-12, kMostAreaTolerance = 0.1, kAreaTolerance = 1e-6;

struct Wanted {
  bool volume = false, area = false, centroid = false, bounds = false;
  double area_tolerance = kAreaTolerance;
};

absl::StatusOr<Wanted> Read(const v1::MeasureSceneRequest& request) {
  Wanted wanted;
  if (request.measures().empty()) {
    return error::InvalidField("measures", "at least one is needed");
  }
  for (int n = 0; n < request.measures_size(); ++n) {
    switch (request.measures(n)) {
      case v1::MEASURE_VOLUME:
        wanted.volume = true;
        break;
      case v1::MEASURE_AREA:
        wanted.area = true;
        break;
      case v1::MEASURE_CENTROID:
        wanted.centroid = true;
        break;
      case v1::MEASURE_BOUNDS:
        wanted.bounds = true;
        break;
      case v1::MEASURE_UNSPECIFIED:
        return error::InvalidField(fmt::format("measures[{}]", n), "must be set");
      default:
        return error::Unsupported(fmt::format("measures[{}]", n), "this measure");
    }
  }
  if (!request.has_area_tolerance()) return wanted;
  wanted.area_tolerance = request.area_tolerance();
  if (std::isnan(wanted.area_tolerance)) return error::NotFinite("area_tolerance");
  LATTICED_RETURN_IF_ERROR(error::CheckRange("area_tolerance", wanted.area_tolerance,
                                             kLeastAreaTolerance, kMostAreaTolerance));
  return wanted;
}

// By whose control points the derivatives are. Without a lattice of that number, any one.
const SceneLattice& LatticeOf(const SceneState& state, const v1::MeasureSceneRequest& request) {
  const size_t place = PlaceOf(state.lattices, request.lattice());
  return state.lattices[std::min(place, state.lattices.size() - 1)];
}

// A derivative by the plan's control points, by those of a lattice.
std::vector<Vec3d> ByLattice(const SceneLattice& lattice, std::vector<Vec3d> gradient) {
  if (lattice.map->is_identity() || gradient.empty()) return gradient;
  return lattice.map->ApplyTransposed(gradient);
}

// The same of three coordinates at once.
std::vector<std::array<Vec3d, 3>> ByLattice(const SceneLattice& lattice,
                                            std::vector<std::array<Vec3d, 3>> gradient) {
  if (lattice.map->is_identity()) return gradient;
  std::vector<std::array<Vec3d, 3>> result(lattice.points->size());
  for (size_t c = 0; c < 3; ++c) {
    std::vector<Vec3d> one;
    one.reserve(gradient.size());
    for (const auto& by_point : gradient) one.push_back(by_point[c]);
    one = lattice.map->ApplyTransposed(one);
    for (size_t n = 0; n < result.size(); ++n) result[n][c] = one[n];
  }
  return result;
}

// With the volume and its derivatives. They are all integrated at once.
absl::StatusOr<EnclosedCentroid> CentroidOf(const SceneState& state, bool with_gradient,
                                            StopCheck stop) {
  if (state.plan->is_weighted() || !state.plan->turned.empty()) {  // makes no moments
    return MeasureCentroidByPatches(*state.plan, *state.control_points, stop,
                                    state.measures->arena(), with_gradient);
  }
  LATTICED_ASSIGN_OR_RETURN(const auto moments,
                            state.measures->Moments(SurfaceMoments::Order::kCentroid, stop));
  return MeasureCentroid(*moments, *state.control_points);
}

absl::Status MeasureInside(const SceneState& state, const Wanted& wanted,
                           const v1::MeasureSceneRequest& request, StopCheck stop,
                           v1::MeasureSceneResponse& response) {
  const auto& points = *state.control_points;
  const SceneLattice& lattice = LatticeOf(state, request);
  const bool with_gradient = request.with_gradient();
  LATTICED_RETURN_IF_ERROR(state.measures->CheckClosed(points));
  EnclosedVolume volume;
  if (wanted.centroid) {
    LATTICED_ASSIGN_OR_RETURN(EnclosedCentroid centroid, CentroidOf(state, with_gradient, stop));
    if (!IsFinite(centroid.centroid)) {
      return error::FailedPrecondition("NO_VOLUME",
                                       "the enclosed volume is 0, so it has no centroid");
    }
    volume = std::move(centroid.volume);
    *response.mutable_centroid() = ToProto(centroid.centroid);
    if (with_gradient) {
      for (const auto& by_point : ByLattice(lattice, std::move(centroid.gradient))) {
        AppendPoints(by_point, *response.mutable_centroid_gradient());
      }
    }
  } else {
    LATTICED_ASSIGN_OR_RETURN(const auto moments,
                              state.measures->Moments(SurfaceMoments::Order::kVolume, stop));
    if (moments->is_by_patches()) {
      LATTICED_ASSIGN_OR_RETURN(
          volume, MeasureVolumeByPatches(*state.plan, points, stop, state.measures->arena(),
                                         with_gradient));
    } else {
      volume = MeasureVolume(*moments, points);
    }
  }
  if (!wanted.volume) return absl::OkStatus();
  response.set_volume(volume.volume);
  if (with_gradient) {
    AppendPoints(ByLattice(lattice, std::move(volume.gradient)),
                 *response.mutable_volume_gradient());
  }
  return absl::OkStatus();
}

}  // namespace

uint64_t MeasureReplyBytes(const SceneState& state, const v1::MeasureSceneRequest& request) {
  constexpr uint64_t kNumbers = 512;
  constexpr uint64_t kGradients = 24 + 24 + 72;  // bytes a control point: volume, area, centroid
  if (!request.with_gradient()) return kNumbers;
  // One that there is not is refused later.
  return kNumbers + kGradients * LatticeOf(state, request).points->size();
}

absl::Status MeasureState(const SceneState& state, const v1::MeasureSceneRequest& request,
                          StopCheck stop, v1::MeasureSceneResponse* response) {
  LATTICED_ASSIGN_OR_RETURN(const Wanted wanted, Read(request));
  // The field's default names no lattice where no derivative is asked for: the lattice 0 may have been removed.
  if (request.with_gradient() || request.lattice() != 0) {
    LATTICED_RETURN_IF_ERROR(CheckLattice(state.lattices, request.lattice(), "lattice"));
  }
  response->set_revision(state.revision);
  response->set_structure_id(state.structure_id);
  if (wanted.volume || wanted.centroid) {
    LATTICED_RETURN_IF_ERROR(MeasureInside(state, wanted, request, stop, *response));
  }
  if (wanted.area) {
    LATTICED_ASSIGN_OR_RETURN(const auto area,
                              MeasureArea(*state.plan, *state.control_points, wanted.area_tolerance,
                                          request.with_gradient(), stop, state.measures->arena()));
    response->set_area(area.area);
    response->set_area_error(area.error);
    AppendPoints(ByLattice(LatticeOf(state, request), area.gradient),
                 *response->mutable_area_gradient());
  }
  if (!wanted.bounds) return absl::OkStatus();
  LATTICED_ASSIGN_OR_RETURN(const Bounds bounds,
                            MeasureBounds(*state.plan, *state.patch_tree, *state.control_points,
                                          stop, state.measures->arena()));
  *response->mutable_least() = ToProto(bounds.min);
  *response->mutable_greatest() = ToProto(bounds.max);
  return absl::OkStatus();
}

}  // namespace latticed
