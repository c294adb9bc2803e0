// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/patches/patch_evaluator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/adaptive/edge_levels.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/patches/edge_bound.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

using Weights = std::array<uint16_t, 3>;
using Corners =
    std::array<std::array<int32_t, 3>, 3>;  // [corner][axis]: places less those of the span

// Local coordinates of a point from its sums of places. A common factor of sums and denominator, a power of two, does
// not change a bit: only the conversion and the product round.
LocalPoint LocalCoordinates(const std::array<int32_t, 3>& sums, int denominator) {
  const int32_t whole = static_cast<int32_t>(kPlacesPerSpan) * denominator;
  const float unit = 0.5f / static_cast<float>(whole);
  LocalPoint local;
  for (size_t a = 0; a < 3; ++a) local[a] = static_cast<float>(2 * sums[a] - whole) * unit;
  return local;
}

std::array<int32_t, 3> Sums(const Corners& corners, const Weights& weights) {
  std::array<int32_t, 3> sums;
  for (size_t a = 0; a < 3; ++a) {
    sums[a] = weights[0] * corners[0][a] + weights[1] * corners[1][a] + weights[2] * corners[2][a];
  }
  return sums;
}

Corners CornersFrom(const std::vector<Places>& places, const std::array<uint32_t, 3>& vertices,
                    const std::array<uint32_t, 3>& spans) {
  Corners corners;
  for (size_t c = 0; c < 3; ++c) {
    for (size_t a = 0; a < 3; ++a) {
      corners[c][a] = static_cast<int32_t>(places[vertices[c]][a] - kPlacesPerSpan * spans[a]);
    }
  }
  return corners;
}

std::array<uint32_t, 3> SpansOf(const PatchPlan& plan, const PatchPlan::Patch& patch) {
  std::array<uint32_t, 3> spans;
  for (size_t a = 0; a < 3; ++a) {
    uint64_t sum = 0;
    for (const uint32_t v : patch.vertex) sum += plan.places[v][a];
    spans[a] = SpanOfPatch(sum);
  }
  return spans;
}

// The axes on which points of a patch can lie on the lower plane of its box, and another box is below.
std::array<bool, 3> AxesWithLower(const Corners& corners, const std::array<uint32_t, 3>& spans) {
  std::array<bool, 3> lower{};
  for (size_t a = 0; a < 3; ++a) {
    lower[a] = spans[a] > 0 && (corners[0][a] == 0 || corners[1][a] == 0 || corners[2][a] == 0);
  }
  return lower;
}

Vec3f Blend(const PatchPlan& plan, const PatchPlan::Patch& patch, const Weights& weights) {
  Vec3f sum;
  for (size_t c = 0; c < 3; ++c) {
    const Vec3f n = plan.rest_normals[patch.normal[c]];
    const auto weight = static_cast<float>(weights[c]);
    sum = {sum.x + weight * n.x, sum.y + weight * n.y, sum.z + weight * n.z};
  }
  return sum;
}

// A common factor of the weights and the denominator, a power of two, does not change a bit.
float BlendWeight(const PatchPlan& plan, const PatchPlan::Patch& patch, const Weights& weights,
                  int denominator) {
  int32_t sum = 0;
  for (size_t c = 0; c < 3; ++c) sum += weights[c] * int32_t{plan.weights[patch.vertex[c]]};
  return static_cast<float>(sum) /
         (static_cast<float>(kWeightUnit) * static_cast<float>(denominator));
}

bool OnAttachedSeam(const Weights& weights, int denominator, const std::array<bool, 3>& vertices,
                    const std::array<bool, 3>& edges) {
  for (size_t c = 0; c < 3; ++c) {
    if (vertices[c] && weights[c] == denominator) return true;
    if (edges[c] && weights[(c + 2) % 3] == 0) return true;  // edge c joins corners c and c + 1
  }
  return false;
}

// A point on a lower plane has its position in the box below.
void MoveToLowerBox(std::array<int32_t, 3> sums, const std::array<bool, 3>& lower, int denominator,
                    uint32_t box, const BoxPolynomials& polynomials, PointBatch* batch) {
  uint32_t below = box;
  for (size_t a = 0; a < 3; ++a) {
    if (!lower[a] || sums[a] != 0) continue;
    sums[a] = static_cast<int32_t>(kPlacesPerSpan) * denominator;
    below -= polynomials.step(a);
  }
  if (below != box) batch->MoveLast(below, LocalCoordinates(sums, denominator));
}

}  // namespace

PatchEvaluator::PatchEvaluator(std::shared_ptr<const PatchPlan> plan,
                               const LatticeStructure& structure)
    : plan_(std::move(plan)),
      outside_(structure),
      size_(outside_.continued().size),
      polynomials_(outside_.continued(), plan_->header) {}

absl::StatusOr<PatchEvaluator> PatchEvaluator::Create(std::shared_ptr<const PatchPlan> plan,
                                                      const LatticeStructure& structure) {
  LATTICED_RETURN_IF_ERROR(Validate(structure));
  const Vec3d outside = plan->header.outside_upper - plan->header.outside_lower;
  const bool has_outside_box = IsFinite(outside) && outside.x > 0 && outside.y > 0 && outside.z > 0;
  if (plan->header.patches_outside > 0 && !has_outside_box) {
    return error::InvalidField("plan", "has patches outside the frame, but no box of theirs");
  }
  PatchEvaluator evaluator(std::move(plan), structure);
  LATTICED_RETURN_IF_ERROR(evaluator.CheckSeams(evaluator.outside_.continued()));
  LATTICED_RETURN_IF_ERROR(evaluator.FindBoxes());
  return evaluator;
}

absl::Status PatchEvaluator::CheckSeams(const LatticeStructure& structure) const {
  if (plan_->seam_ranges.empty()) return absl::OkStatus();
  if (plan_->identity_points.size() != static_cast<size_t>(structure.control_point_count())) {
    return error::InvalidField("plan", "is not of this lattice: it has other identity points");
  }
  for (const std::array<uint32_t, 6>& range : plan_->seam_ranges) {
    for (size_t a = 0; a < 3; ++a) {
      if (range[2 * a + 1] < static_cast<uint32_t>(size_[a])) continue;
      return error::InvalidField("plan",
                                 "is not of this lattice: a seam has control points beyond it");
    }
  }
  return absl::OkStatus();
}

absl::Status PatchEvaluator::FindBoxes() {
  patch_boxes_.assign(plan_->patches.size(), 0);
  std::vector<bool> used(polynomials_.count());
  for (size_t p = 0; p < plan_->inside_patches(); ++p) {
    const PatchPlan::Patch& patch = plan_->patches[p];
    const std::array<uint32_t, 3> spans = SpansOf(*plan_, patch);
    const Corners corners = CornersFrom(plan_->places, patch.vertex, spans);
    for (size_t a = 0; a < 3; ++a) {
      const auto in_span = [a](const auto& corner) {
        return corner[a] >= 0 && corner[a] <= int32_t{kPlacesPerSpan};
      };
      if (spans[a] < polynomials_.spans(a) && std::all_of(corners.begin(), corners.end(), in_span))
        continue;
      return error::InvalidField(
          "plan", fmt::format("is not of this lattice: patch {} is in no knot box", p));
    }
    patch_boxes_[p] = polynomials_.Number(spans);
    const std::array<bool, 3> lower = AxesWithLower(corners, spans);
    for (uint32_t axes = 0; axes < 8; ++axes) {
      uint32_t box = patch_boxes_[p];
      bool there = true;
      for (size_t a = 0; a < 3; ++a) {
        if ((axes >> a & 1) == 0) continue;
        there = there && lower[a];
        if (there) box -= polynomials_.step(a);
      }
      if (there) used[box] = true;
    }
  }
  for (uint32_t box = 1; box < used.size(); ++box) {
    if (used[box]) used_boxes_.push_back(box);
  }
  return absl::OkStatus();
}

void PatchEvaluator::FindAttached(std::span<const Vec3d> control_points) {
  attached_.assign(plan_->seam_ranges.size(), true);
  for (size_t s = 0; s < attached_.size(); ++s) {
    const auto [i0, i1, j0, j1, k0, k1] = plan_->seam_ranges[s];
    for (size_t k = k0; k <= k1; ++k) {
      for (size_t j = j0; j <= j1; ++j) {
        for (size_t i = i0; i <= i1; ++i) {
          const size_t at =
              i + static_cast<size_t>(size_[0]) * (j + static_cast<size_t>(size_[1]) * k);
          if (control_points[at] != plan_->identity_points[at]) attached_[s] = false;
        }
      }
    }
  }
}

absl::Status PatchEvaluator::ChoosePatterns(std::span<const uint8_t> edge_bounds, double tolerance,
                                            PatchSurface* surface) const {
  std::array<uint8_t, 256> levels;
  std::array<double, 256> errors;
  for (size_t byte = 0; byte < levels.size(); ++byte) {
    const double bound = EdgeBound(static_cast<uint8_t>(byte), plan_->header.curvature_unit);
    levels[byte] = EdgeLevel(bound, tolerance);
    errors[byte] = bound / 6 / std::ldexp(1.0, 2 * levels[byte]);
  }
  surface->error = 0;
  for (const uint8_t byte : edge_bounds) surface->error = std::max(surface->error, errors[byte]);
  surface->patterns.resize(plan_->patches.size());
  surface->first_points.resize(plan_->patches.size() + 1);
  uint64_t points = 0, triangles = 0;
  for (size_t p = 0; p < plan_->patches.size(); ++p) {
    PatternKey key;
    for (size_t e = 0; e < 3; ++e) key.levels[e] = levels[edge_bounds[plan_->patches[p].edge[e]]];
    const AdaptivePattern& pattern = AdaptivePattern::Get(key);
    surface->patterns[p] = key.Code();
    surface->first_points[p] = static_cast<uint32_t>(points);
    points += pattern.points.size();
    triangles += pattern.triangles.size();
  }
  if (points > std::numeric_limits<uint32_t>::max())
    return error::LimitExceeded("points", uint64_t{1} << 32);
  surface->first_points.back() = static_cast<uint32_t>(points);
  surface->positions.resize(points);
  surface->normals.resize(plan_->header.normals == RestNormals::kNone ? 0 : points);
  surface->triangles.resize(triangles);
  return absl::OkStatus();
}

void PatchEvaluator::EvaluatePatch(size_t p, const AdaptivePattern& pattern,
                                   PointBatch* batch) const {
  const PatchPlan::Patch& patch = plan_->patches[p];
  const uint32_t box = patch_boxes_[p];
  const bool inside = box != 0;
  const std::array<uint32_t, 3> spans = inside ? SpansOf(*plan_, patch) : std::array<uint32_t, 3>{};
  Corners corners = CornersFrom(plan_->places, patch.vertex, spans);
  std::array<bool, 3> vertex_attached{}, edge_attached{};
  bool any_attached = false;
  for (size_t c = 0; c < 3 && !plan_->seam_ranges.empty(); ++c) {
    if (!inside) {
      if (plan_->vertex_seams[patch.vertex[c]] != PatchPlan::kNoSeam) {
        for (size_t a = 0; a < 3; ++a)
          corners[c][a] = static_cast<int32_t>(plan_->outside_places[patch.vertex[c]][a]);
      }
      continue;
    }
    vertex_attached[c] = IsAttached(plan_->vertex_seams, patch.vertex[c]);
    edge_attached[c] = IsAttached(plan_->edge_seams, patch.edge[c]);
    any_attached = any_attached || vertex_attached[c] || edge_attached[c];
  }
  const std::array<bool, 3> lower = inside ? AxesWithLower(corners, spans) : std::array<bool, 3>{};
  const bool any_lower = lower[0] || lower[1] || lower[2];
  const RestNormals normals = plan_->header.normals;
  const Vec3f facet =
      normals == RestNormals::kFacet ? plan_->rest_normals[patch.normal[0]] : Vec3f{};

  const bool weighted = plan_->header.weighted;
  PointWeight weight;
  if (weighted && !plan_->slopes.empty()) weight.slope = plan_->slopes[p];
  for (const Weights& weights : pattern.points) {
    const std::array<int32_t, 3> sums = Sums(corners, weights);
    const Vec3f rest = normals == RestNormals::kSmooth ? Blend(*plan_, patch, weights) : facet;
    if (weighted) weight.value = BlendWeight(*plan_, patch, weights, pattern.denominator);
    batch->Add(box, LocalCoordinates(sums, pattern.denominator), rest, weight);
    if (any_attached &&
        OnAttachedSeam(weights, pattern.denominator, vertex_attached, edge_attached)) {
      const Corners outside = CornersFrom(plan_->outside_places, patch.vertex, {});
      batch->MoveLast(0, LocalCoordinates(Sums(outside, weights), pattern.denominator));
    } else if (any_lower) {
      MoveToLowerBox(sums, lower, pattern.denominator, box, polynomials_, batch);
    }
  }
}

absl::StatusOr<std::vector<Vec3d>> PatchEvaluator::Continued(
    std::span<const Vec3d> control_points) const {
  const auto expected = static_cast<size_t>(outside_.structure().control_point_count());
  if (control_points.size() == expected) return outside_.Continue(control_points);
  return error::InvalidField("control_points", fmt::format("has {} points, {} are needed",
                                                           control_points.size(), expected));
}

absl::StatusOr<double> PatchEvaluator::PositionError(std::span<const Vec3d> control_points) {
  LATTICED_ASSIGN_OR_RETURN(const auto continued, Continued(control_points));
  polynomials_.Update(continued, used_boxes_);
  return polynomials_.PositionError(used_boxes_);
}

absl::Status PatchEvaluator::Evaluate(std::span<const Vec3d> control_points,
                                      std::span<const uint8_t> edge_bounds, double tolerance,
                                      PatchSurface* surface) {
  LATTICED_ASSIGN_OR_RETURN(const auto continued, Continued(control_points));
  if (edge_bounds.size() != plan_->header.edge_count) {
    return error::InvalidField(
        "edge_bounds",
        fmt::format("has {} bytes, {} are needed", edge_bounds.size(), plan_->header.edge_count));
  }
  if (!(tolerance > 0)) return error::InvalidField("tolerance", "must be above 0");
  LATTICED_RETURN_IF_ERROR(ChoosePatterns(edge_bounds, tolerance, surface));
  polynomials_.Update(continued, used_boxes_);
  FindAttached(continued);
  PointBatch batch(polynomials_, surface->positions.data(),
                   surface->normals.empty() ? nullptr : surface->normals.data());
  auto triangle = surface->triangles.begin();
  for (size_t p = 0; p < plan_->patches.size(); ++p) {
    const AdaptivePattern& pattern =
        AdaptivePattern::Get(*PatternKey::FromCode(surface->patterns[p]));
    EvaluatePatch(p, pattern, &batch);
    const uint32_t first = surface->first_points[p];
    for (const auto& [a, b, c] : pattern.triangles) *triangle++ = {first + a, first + b, first + c};
  }
  batch.Flush();
  return absl::OkStatus();
}

}  // namespace latticed::client
