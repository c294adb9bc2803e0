// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/verify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "core/base/bounds.h"
#include "core/codec/chunk_encoder.h"
#include "core/codec/octahedral.h"
#include "core/ffd/direct_ffd.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "tests/support/pipeline_name.h"
#include "tests/support/tolerances.h"

namespace latticed::bench {
namespace {

struct ReadPoint {
  Vec3d position;
  Vec3d normal;
};

// The points of a chunk in world coordinates, whatever the view's format.
std::vector<ReadPoint> ReadChunk(const Scenario& scenario, DeformView& view, uint32_t chunk) {
  const ViewSpec& spec = view.spec();
  const size_t count = ChunkPoints(*scenario.plan, chunk, spec.segments);
  std::vector<uint8_t> bytes(count * BytesPerPoint(spec));
  CheckOk(view.Read(chunk, bytes));
  std::vector<ReadPoint> points(count);
  const bool normals = spec.normals != NormalMode::kNone;
  if (spec.format == VertexFormat::kFloat32) {
    for (size_t i = 0; i < count; ++i) {
      std::array<float, 6> f{};
      std::memcpy(f.data(), bytes.data() + i * BytesPerPoint(spec), BytesPerPoint(spec));
      points[i].position = scenario.plan->local_origin + ToDouble(Vec3f{f[0], f[1], f[2]});
      points[i].normal = ToDouble(Vec3f{f[3], f[4], f[5]});
    }
    return points;
  }
  const auto v = QuantisedVertices::FromBytes(bytes, count, spec.position_bits,
                                              normals ? spec.normal_bits : 0);
  const double step = scenario.box.step(spec.position_bits);
  const auto code = [&](const uint8_t* values, size_t i) {
    if (spec.normal_bits <= 8) return static_cast<int32_t>(values[i]);
    return static_cast<int32_t>(values[2 * i] | (values[2 * i + 1] << 8));
  };
  for (size_t i = 0; i < count; ++i) {
    points[i].position =
        scenario.box.origin + step * Vec3d{static_cast<double>(v.x[i]), static_cast<double>(v.y[i]),
                                           static_cast<double>(v.z[i])};
    if (!normals) continue;
    points[i].normal = ToDouble(DequantiseNormal({code(v.s, i), code(v.t, i)}, spec.normal_bits));
  }
  return points;
}

// The larger; a NaN is the worst and stays.
double Worse(double a, double b) { return std::isnan(a) || b <= a ? a : b; }

double Angle(Vec3d a, Vec3d b) { return std::atan2(Norm(Cross(a, b)), Dot(a, b)); }

// Control points that any inside patch's box depends on.
Bounds InfluencingBounds(const Scenario& scenario) {
  const DeformPlan& plan = *scenario.plan;
  const auto& degree = plan.structure.degree;
  Bounds bounds;
  for (uint32_t b = 0; b < plan.outside_box(); ++b) {
    const auto& span = plan.boxes[b].span;
    for (int k = span[2] - degree[2]; k <= span[2]; ++k) {
      for (int j = span[1] - degree[1]; j <= span[1]; ++j) {
        for (int i = span[0] - degree[0]; i <= span[0]; ++i) {
          bounds.Extend(
              scenario.control_points[0][static_cast<size_t>(plan.structure.Index(i, j, k))]);
        }
      }
    }
  }
  return bounds;
}

}  // namespace

Precision Measure(const Scenario& scenario, Pipeline pipeline, DeformView& view, size_t stride) {
  const ViewSpec& spec = view.spec();
  const DirectFfd direct(*scenario.plan, scenario.control_points[0]);
  const auto mode =
      spec.normals == NormalMode::kSmooth ? DirectFfd::Normal::kSmooth : DirectFfd::Normal::kFacet;
  std::vector<std::array<double, 3>> places;
  for (const auto& p : TessellationPattern::Get(spec.segments).points) {
    const double s = spec.segments;
    places.push_back({p[0] / s, p[1] / s, p[2] / s});
  }
  std::vector<DirectFfd::SurfacePoint> expected(places.size());
  const bool quantised = spec.format == VertexFormat::kQuantised;
  // Per axis half a step; in angle a cell's half diagonal, which the map stretches by up to 2.
  const double rounding =
      quantised ? std::numbers::sqrt3 * 0.5 * scenario.box.step(spec.position_bits) : 0.0;
  const double cell = quantised ? 4.0 * std::numbers::sqrt2 / OctahedralMax(spec.normal_bits) : 0.0;
  Bounds deformed;
  double worst_distance = 0;
  Precision result;
  for (size_t chunk = 0; chunk < scenario.all_chunks.size(); chunk += stride) {
    const auto points = ReadChunk(scenario, view, static_cast<uint32_t>(chunk));
    const auto [first, last] = scenario.plan->ChunkPatches(chunk);
    size_t next = 0;
    for (size_t patch = first; patch < last; ++patch) {
      Bounds of_patch;
      for (size_t i = 0; i < places.size(); ++i) {
        expected[i] = direct.Evaluate(patch, places[i], mode);
        of_patch.Extend(expected[i].position);
      }
      deformed.Extend(of_patch);
      for (size_t i = 0; i < places.size(); ++i) {
        const ReadPoint& got = points[next++];
        worst_distance =
            Worse(worst_distance, Norm(got.position - expected[i].position) - rounding);
        const double kappa = expected[i].kappa;
        if (spec.normals == NormalMode::kNone || kappa > testing::kMostKappa) continue;
        const double angle = Angle(got.normal, expected[i].normal) - cell;
        const double allowed = testing::NormalTolerance(pipeline, *scenario.plan, direct,
                                                        {.patch = patch,
                                                         .barycentrics = places[i],
                                                         .kind = mode,
                                                         .kappa = kappa,
                                                         .patch_diagonal = of_patch.diagonal()});
        result.normal = Worse(result.normal, angle / kappa);
        result.normal_of_allowed = Worse(result.normal_of_allowed, angle / allowed);
      }
    }
  }
  result.scale = std::max(deformed.diagonal(), InfluencingBounds(scenario).diagonal());
  result.position = worst_distance / result.scale;
  return result;
}

absl::Status Verify(const Scenario& scenario, Pipeline pipeline, DeformView& view) {
  const size_t stride = std::max<size_t>(1, scenario.all_chunks.size() / 64);
  const Precision precision = Measure(scenario, pipeline, view, stride);
  const double allowed = testing::PositionTolerance(pipeline);
  if (!(precision.position <= allowed)) {
    return absl::InternalError(fmt::format("{} {}: position off by {:.2e} D, allowed {:.0e}",
                                           scenario.name, PipelineName(pipeline),
                                           precision.position, allowed));
  }
  if (!(precision.normal_of_allowed <= 1)) {
    return absl::InternalError(fmt::format("{} {}: normal off by {:.2e} times what is allowed",
                                           scenario.name, PipelineName(pipeline),
                                           precision.normal_of_allowed));
  }
  return absl::OkStatus();
}

}  // namespace latticed::bench
