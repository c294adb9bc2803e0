// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/fused/fused_layout.h"

#include <algorithm>
#include <cmath>

namespace latticed::fused {
namespace {

void SetLane(std::array<Lanes, 3>& field, size_t lane, Vec3d value) {
  const Vec3f f = ToFloat(value);
  field[0][lane] = f.x;
  field[1][lane] = f.y;
  field[2][lane] = f.z;
}

// A height below this fraction of the first edge is a rounding error. The perpendicular then keeps its direction and
// gets this length, so that no coefficient of its polynomials is denormal.
constexpr double kSmallestHeight = 0x1p-40;
// A facet normal is perpendicular to the patch's edges, but for this. Otherwise it is one of rounding errors: the source
// triangle has no area.
constexpr double kMostTilt = 1e-7;

// Takes the next lane of the box's feature group, or the first of a new group. All later lanes repeat its values.
template <typename LanesType, typename Pack>
uint32_t AddFeature(FeatureSet<LanesType>& set,
                    std::map<uint32_t, std::pair<uint32_t, uint32_t>>& open, uint32_t box,
                    const Pack& pack) {
  auto [it, added] = open.try_emplace(box, 0u, static_cast<uint32_t>(kLanes));
  auto& [group, used] = it->second;
  if (used == kLanes) {
    group = static_cast<uint32_t>(set.groups.size());
    used = 0;
    set.groups.emplace_back();
    set.boxes.push_back(box);
  }
  for (size_t lane = used; lane < kLanes; ++lane) pack(set.groups[group], lane);
  return group * static_cast<uint32_t>(kLanes) + used++;
}

}  // namespace

FusedLayout::FusedLayout(std::shared_ptr<const DeformPlan> plan, const BoxPolynomials& polynomials)
    : plan_(std::move(plan)), polynomials_(polynomials) {
  group_of_patch.resize(plan_->patches.size());
  for (uint32_t box = 0; box < plan_->boxes.size(); ++box) PackGroups(box);
  edge_features_.clear();
  corner_features_.clear();
  open_edges_.clear();
  open_corners_.clear();
}

void FusedLayout::PackGroups(uint32_t box) {
  const uint32_t end = plan_->box_patches[box + 1];
  for (uint32_t first = plan_->box_patches[box]; first < end; first += kLanes) {
    Group group{.box = box, .first_patch = first};
    group.lanes = std::min<uint32_t>(kLanes, end - first);
    group.first_fix = static_cast<uint32_t>(fixes.size());
    patches.emplace_back();
    smooth.emplace_back();
    for (uint32_t lane = 0; lane < kLanes; ++lane) {
      PackLane(groups.size(), lane, first + std::min(lane, group.lanes - 1));
      if (lane >= group.lanes) continue;
      group_of_patch[first + lane] = static_cast<uint32_t>(groups.size());
      AddFixes(first + lane, static_cast<uint8_t>(lane));
    }
    group.last_fix = static_cast<uint32_t>(fixes.size());
    groups.push_back(group);
  }
}

void FusedLayout::PackLane(size_t group, size_t lane, uint32_t p) {
  const Patch& patch = plan_->patches[p];
  PatchLanes& out = patches[group];
  std::array<Vec3d, 3> world, local;
  for (size_t c = 0; c < 3; ++c) {
    const PlanVertex& vertex = plan_->vertices[patch.vertex[c]];
    world[c] = vertex.world;
    local[c] = polynomials_.Local(patch.box, vertex);
    SetLane(out.corners[c].point, lane, local[c]);
  }

  // The patch's frame in the world: the first edge, and its perpendicular in the plane of the *source* triangle.
  // That plane is accurate however thin the patch is.
  const auto& corners = plan_->sources[p].corners;
  const auto source = [&](size_t c) {
    return plan_->mesh->positions[plan_->mesh->corner_vertices[corners[c]]];
  };
  Vec3d along = world[1] - world[0];
  const Vec3d side = world[2] - world[0];
  const double length = Norm(along);
  Vec3d facet = Cross(source(1) - source(0), source(2) - source(0));
  if (!(Norm(facet) > 0)) facet = Cross(along, side);
  if (Norm(facet) > 0) facet = facet / Norm(facet);
  if (!(std::abs(Dot(along, facet)) <= kMostTilt * length)) facet = {};
  Vec3d across;
  double height = 0;
  if (Norm(facet) > 0 && length > 0) {
    // Rounding moves the ends of a very short edge out of the facet's plane. This projects it back onto the plane.
    along -= Dot(along, facet) * facet;
    const Vec3d unit = Cross(facet, along / length);
    height = std::max(Dot(side, unit), kSmallestHeight * length);
    across = height * unit;
  }
  const double shear = length > 0 ? Dot(side, along) / (length * length) : 0.0;
  if (height == 0) across = side - shear * along;
  const Vec3d local_along = polynomials_.LocalDirection(patch.box, along);
  const Vec3d local_across = polynomials_.LocalDirection(patch.box, across);
  // x = t = 0 is half-way along and half-way up: corner 0 is at x = -1/2, t = -1/2.
  SetLane(out.center, lane, local[0] + 0.5 * local_along + 0.5 * local_across);
  SetLane(out.along, lane, local_along);
  SetLane(out.across, lane, local_across);
  // A patch without height has no facet normal. Its zero conormal makes the kernel take the definition's normals.
  const Vec3d normal = height > 0 ? facet : Vec3d{};
  SetLane(out.conormal, lane, polynomials_.LocalConormal(patch.box, normal));
  out.shear[lane] = static_cast<float>(shear);
  out.along_length[lane] = static_cast<float>(length);
  out.inverse_height[lane] = height > 0 ? static_cast<float>(1 / height) : 0.0f;
  PackSmooth(group, lane, p, facet, along, across);
  if (plan_->is_weighted()) {
    weights.PackPatch(*plan_, polynomials_, group, lane, p, along, across, shear, facet);
  }
}

void FusedLayout::PackSmooth(size_t group, size_t lane, uint32_t p, Vec3d facet, Vec3d along,
                             Vec3d across) {
  SmoothLanes& out = smooth[group];
  const PatchSource& source = plan_->sources[p];
  SetLane(out.facet, lane, polynomials_.LocalDirection(plan_->patches[p].box, facet));
  const double length = Norm(along), height = Norm(across);
  if (!(height > 0)) return;  // no area: every normal comes from the definition
  const Vec3d unit_along = along / length, unit_across = across / height;
  for (size_t c = 0; c < 3; ++c) {
    Vec3d n;
    for (size_t k = 0; k < 3; ++k) {
      n += source.barycentrics[c][k] * ToDouble(plan_->vertex_normals[source.corners[k]]);
    }
    const Vec3d conormal = polynomials_.LocalConormal(plan_->patches[p].box, n);
    for (size_t a = 0; a < 3; ++a) {
      out.conormal[a][c][lane] = static_cast<float>(conormal[static_cast<int>(a)]);
    }
    out.normal[0][c][lane] = static_cast<float>(Dot(n, facet) / length);
    out.normal[1][c][lane] = static_cast<float>(Dot(n, unit_along));
    out.normal[2][c][lane] = static_cast<float>(Dot(n, unit_across) / length);
  }
}

void FusedLayout::AddFixes(uint32_t p, uint8_t lane) {
  const Patch& patch = plan_->patches[p];
  const uint32_t outside = plan_->outside_box();
  if (patch.box == outside) return;  // outside patches take all points from their own box
  for (uint8_t slot = 0; slot < 3; ++slot) {
    const PlanVertex& vertex = plan_->vertices[patch.vertex[slot]];
    if (vertex.box != patch.box || vertex.seam != kNoIndex) {
      Fix fix{.lane = lane, .slot = slot, .seam = vertex.seam};
      if (vertex.box != patch.box) fix.detached = CornerFeature(patch.vertex[slot], vertex.box);
      if (vertex.seam != kNoIndex) fix.attached = CornerFeature(patch.vertex[slot], outside);
      fixes.push_back(fix);
    }
    const PlanEdge& edge = plan_->edges[patch.edge[slot]];
    if (edge.box != patch.box || edge.seam != kNoIndex) {
      Fix fix{.lane = lane,
              .slot = slot,
              .is_edge = true,
              .reversed = patch.edge_reversed[slot],
              .seam = edge.seam};
      if (edge.box != patch.box) fix.detached = EdgeFeature(patch.edge[slot], edge.box);
      if (edge.seam != kNoIndex) fix.attached = EdgeFeature(patch.edge[slot], outside);
      fixes.push_back(fix);
    }
  }
}

uint32_t FusedLayout::EdgeFeature(uint32_t edge, uint32_t box) {
  const auto [it, added] = edge_features_.try_emplace({edge, box}, 0u);
  if (!added) return it->second;
  const auto& ends = plan_->edges[edge].vertex;
  const Vec3d from = polynomials_.Local(box, plan_->vertices[ends[0]]);
  const Vec3d to = polynomials_.Local(box, plan_->vertices[ends[1]]);
  it->second = AddFeature(edges, open_edges_, box, [&](EdgeLanes& lanes, size_t lane) {
    SetLane(lanes.from.point, lane, from);
    SetLane(lanes.to.point, lane, to);
  });
  if (plan_->is_weighted()) weights.PackEdge(*plan_, edge, it->second);
  return it->second;
}

uint32_t FusedLayout::CornerFeature(uint32_t vertex, uint32_t box) {
  const auto [it, added] = corner_features_.try_emplace({vertex, box}, 0u);
  if (!added) return it->second;
  const Vec3d point = polynomials_.Local(box, plan_->vertices[vertex]);
  it->second = AddFeature(corners, open_corners_, box, [&](CornerLanes& lanes, size_t lane) {
    SetLane(lanes.point, lane, point);
  });
  if (plan_->is_weighted()) weights.PackCorner(*plan_, vertex, it->second);
  return it->second;
}

uint64_t FusedLayout::MemoryBytes() const {
  return groups.size() * (sizeof(Group) + sizeof(PatchLanes) + sizeof(SmoothLanes)) +
         fixes.size() * sizeof(Fix) + edges.groups.size() * sizeof(EdgeLanes) +
         corners.groups.size() * sizeof(CornerLanes) + group_of_patch.size() * sizeof(uint32_t) +
         weights.MemoryBytes();
}

}  // namespace latticed::fused
