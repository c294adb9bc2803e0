// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/fused/fused_weights.h"

#include "core/ffd/weights/weight_change.h"

namespace latticed::fused {
namespace {

void SetPoint(CornerLanes& lanes, size_t lane, Vec3d value) {
  const Vec3f f = ToFloat(value);
  lanes.point[0][lane] = f.x;
  lanes.point[1][lane] = f.y;
  lanes.point[2][lane] = f.z;
}

void SetWeighted(WeightedPoint& lanes, size_t lane, Vec3d rest, double weight) {
  SetPoint(lanes.rest, lane, rest);
  lanes.weight[lane] = static_cast<float>(weight);
}

}  // namespace

void FusedWeights::PackPatch(const DeformPlan& plan, const BoxPolynomials& polynomials,
                             size_t group, size_t lane, uint32_t p, Vec3d along, Vec3d across,
                             double shear, Vec3d facet) {
  if (patches.size() <= group) patches.resize(group + 1);
  WeightedPatch& out = patches[group];
  const Patch& patch = plan.patches[p];
  const std::array<double, 3> weight = plan.CornerWeights(p);
  for (size_t c = 0; c < 3; ++c) out.weights.corners[c][lane] = static_cast<float>(weight[c]);
  const Vec3d gradient = plan.PatchWeightGradient(p);
  const Vec3d first = plan.vertices[patch.vertex[0]].world - plan.local_origin;
  const double rise = weight[1] - weight[0],
               climb = WeightChange(Dot(gradient, across), weight[2] - weight[0] - shear * rise);
  SetWeighted(out.center, lane, first + 0.5 * along + 0.5 * across,
              weight[0] + 0.5 * rise + 0.5 * climb);
  SetWeighted(out.along, lane, along, rise);
  SetWeighted(out.across, lane, across, climb);
  SetPoint(out.facet, lane, facet);
  out.weights.steepness[lane] =
      static_cast<float>(WeightSteepness(Norm(gradient), climb, Norm(across)));
  const std::array<Vec3d, 3> by_local = polynomials.WorldByLocal(patch.box);
  Vec3d slope;
  for (size_t l = 0; l < 3; ++l) {
    slope[static_cast<int>(l)] = Dot(gradient, by_local[l]);
  }
  SetPoint(out.weights.by_local, lane, slope);
}

void FusedWeights::PackEdge(const DeformPlan& plan, uint32_t edge, uint32_t feature) {
  const size_t group = feature / kLanes, lane = feature % kLanes;
  if (edges.size() <= group) edges.resize(group + 1);
  const auto& ends = plan.edges[edge].vertex;
  edges[group].from[lane] = static_cast<float>(plan.vertex_weights[ends[0]]);
  edges[group].to[lane] = static_cast<float>(plan.vertex_weights[ends[1]]);
}

void FusedWeights::PackCorner(const DeformPlan& plan, uint32_t vertex, uint32_t feature) {
  const size_t group = feature / kLanes, lane = feature % kLanes;
  if (corners.size() <= group) corners.resize(group + 1);
  corners[group].weight[lane] = static_cast<float>(plan.vertex_weights[vertex]);
}

uint64_t FusedWeights::MemoryBytes() const {
  return patches.size() * sizeof(WeightedPatch) + edges.size() * sizeof(EdgeWeights) +
         corners.size() * sizeof(CornerWeights);
}

}  // namespace latticed::fused
