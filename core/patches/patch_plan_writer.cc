// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/patches/patch_plan_writer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/status_macros.h"
#include "core/codec/octahedral.h"
#include "core/patches/byte_planes.h"
#include "core/patches/edge_bound.h"
#include "core/patches/zlib_stream.h"

namespace latticed {
namespace {

constexpr std::array<double, 3> kCorner[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

// 0 for a number that is new, else how far it is back.
constexpr uint32_t UseCode(std::pair<uint32_t, bool> numbered, uint32_t so_far) {
  return numbered.second ? 0 : so_far - numbered.first;
}

// Whose lists have the normals: the vertices of the mesh, or those of the plan.
size_t NormalOwners(const DeformPlan& plan, RestNormals normals) {
  return normals == RestNormals::kFacet ? plan.mesh->positions.size() : plan.vertices.size();
}

bool IsOnSeam(const PlanVertex& vertex) { return vertex.seam != kNoIndex; }

// With the arrays of a run, which are copied while they grow.
uint64_t WriterBytes(const DeformPlan& plan, RestNormals normals, uint64_t normal_count) {
  constexpr uint64_t kRunPatchBytes = 450;
  const auto seams =
      static_cast<uint64_t>(std::count_if(plan.vertices.begin(), plan.vertices.end(), IsOnSeam));
  return plan.vertices.size() * sizeof(uint32_t) + seams * sizeof(std::pair<uint32_t, uint32_t>) +
         AdjacencyIndex::ReservedBytes(NormalOwners(plan, normals), normal_count) +
         std::min<uint64_t>(plan.patches.size(), kMaxRunPatches) * kRunPatchBytes;
}

uint16_t SmoothNumber(double component) {
  return static_cast<uint16_t>(std::lround(kRestNormalUnit * std::clamp(component, -1.0, 1.0)));
}

}  // namespace

struct PatchPlanWriter::RunArrays {
  std::vector<uint32_t> corners, normals;
  std::array<std::vector<uint32_t>, 3> places;  // by axis
  std::array<std::vector<uint16_t>, 3> rest;    // by component
  std::vector<uint16_t> weights;
  std::array<std::vector<uint32_t>, 3> slopes;  // by component, the bits of float32

  void AddPlaces(Places place) {
    for (size_t a = 0; a < 3; ++a) places[a].push_back(place[a]);
  }

  std::string Bytes() const {
    std::vector<uint32_t> differences;
    for (const std::vector<uint32_t>& axis : places) {
      uint32_t before = 0;
      for (const uint32_t place : axis) {
        differences.push_back(EncodeDifference(before, place));
        before = place;
      }
    }
    std::vector<uint16_t> rest_numbers;
    for (const auto& component : rest) {
      rest_numbers.insert(rest_numbers.end(), component.begin(), component.end());
    }
    std::string bytes;
    bytes.reserve(4 * (corners.size() + normals.size() + differences.size()) +
                  2 * rest_numbers.size());
    AppendBytePlanes<uint32_t>(corners, &bytes);
    AppendBytePlanes<uint32_t>(differences, &bytes);
    AppendBytePlanes<uint32_t>(normals, &bytes);
    AppendBytePlanes<uint16_t>(rest_numbers, &bytes);
    AppendBytePlanes<uint16_t>(weights, &bytes);
    std::vector<uint32_t> all_slopes;
    for (const auto& component : slopes) {
      all_slopes.insert(all_slopes.end(), component.begin(), component.end());
    }
    AppendBytePlanes<uint32_t>(all_slopes, &bytes);
    return bytes;
  }
};

PatchPlanWriter::PatchPlanWriter(std::shared_ptr<const DeformPlan> plan, RestNormals normals)
    : plan_(std::move(plan)),
      normals_(normals),
      planes_(plan_->structure),
      outside_box_(OutsideBox(plan_->outside_bounds)),
      at_rest_(*plan_, plan_->identity_points),
      vertex_numbers_(plan_->vertices.size(), kNoIndex) {
  header_.normals = normals;
  header_.patch_count = plan_->patches.size();
  header_.patches_outside = plan_->outside_patches;
  header_.edge_count = plan_->edges.size();
  header_.origin = plan_->local_origin;
  header_.curvature_unit = CurvatureUnit(plan_->mesh_bounds);
  header_.weighted = plan_->is_weighted();
  if (outside_box_.empty()) return;
  header_.outside_lower = outside_box_.min;
  header_.outside_upper = outside_box_.max;
}

absl::StatusOr<PatchPlanWriter> PatchPlanWriter::Create(std::shared_ptr<const DeformPlan> plan,
                                                        RestNormals normals, StopCheck stop) {
  PatchPlanWriter writer(std::move(plan), normals);
  LATTICED_RETURN_IF_ERROR(writer.Count(stop));
  return writer;
}

uint64_t PatchPlanWriter::MostBytes(const DeformPlan& plan, RestNormals normals) {
  const uint64_t most = plan.patches.size() * RestNormalsPerPatch(normals);
  return WriterBytes(plan, normals, most) + plan.vertices.size() / 8;
}

uint64_t PatchPlanWriter::MemoryBytes() const {
  return WriterBytes(*plan_, normals_, header_.normal_count);
}

void PatchPlanWriter::ResetNormals(size_t count) {
  normal_numbers_ = {};
  normals_so_far_ = 0;
  if (count > 0) normal_numbers_.Reserve(NormalOwners(*plan_, normals_), count);
}

// Numbers all normals once to know how many there are, and forgets them.
absl::Status PatchPlanWriter::Count(StopCheck stop) {
  ResetNormals(plan_->patches.size() * RestNormalsPerPatch(normals_));
  std::vector<bool> used(plan_->vertices.size());
  StopPoll poll(stop);
  for (size_t p = 0; p < plan_->patches.size(); ++p) {
    LATTICED_RETURN_IF_ERROR(poll.Step());
    for (const uint32_t v : plan_->patches[p].vertex) used[v] = true;
    for (size_t c = 0; c < RestNormalsPerPatch(normals_); ++c) {
      static_cast<void>(NumberNormal(p, c, NormalAt(p, c)));
    }
  }
  header_.vertex_count = static_cast<uint64_t>(std::count(used.begin(), used.end(), true));
  header_.normal_count = normals_so_far_;
  ResetNormals(normals_so_far_);
  return absl::OkStatus();
}

PatchPlanWriter::RestNormal PatchPlanWriter::NormalAt(size_t patch, size_t corner) const {
  if (normals_ == RestNormals::kFacet) {
    const auto n = QuantiseNormal(ToFloat(at_rest_.RestFacetNormal(patch)), kRestNormalBits);
    return {{static_cast<uint16_t>(n.s), static_cast<uint16_t>(n.t)}};
  }
  const Vec3d n = at_rest_.RestSmoothNormal(patch, kCorner[corner]);
  return {{SmoothNumber(n.x), SmoothNumber(n.y), SmoothNumber(n.z)}};
}

// Equal normals have one number around a vertex only, where most are. So its distances stay small.
std::pair<uint32_t, bool> PatchPlanWriter::NumberNormal(size_t patch, size_t corner,
                                                        RestNormal normal) {
  const uint32_t vertex = normals_ == RestNormals::kFacet
                              ? plan_->mesh->corner_vertices[plan_->sources[patch].corners[0]]
                              : plan_->patches[patch].vertex[corner];
  const auto numbered = normal_numbers_.TryEmplaceInList(vertex, normal.Key(), normals_so_far_);
  if (numbered.second) ++normals_so_far_;
  return numbered;
}

Places PatchPlanWriter::PlacesOfVertex(const PlanVertex& vertex) const {
  return vertex.box == plan_->outside_box() ? OutsidePlaces(outside_box_, vertex.world)
                                            : planes_.PlacesOf(vertex.parameter);
}

void PatchPlanWriter::AppendPatch(size_t patch, RunArrays* arrays) {
  for (const uint32_t v : plan_->patches[patch].vertex) {
    uint32_t& number = vertex_numbers_[v];
    if (number != kNoIndex) {
      arrays->corners.push_back(vertices_ - number);
      continue;
    }
    number = vertices_++;
    arrays->corners.push_back(0);
    arrays->AddPlaces(PlacesOfVertex(plan_->vertices[v]));
    if (!header_.weighted) continue;
    arrays->weights.push_back(
        static_cast<uint16_t>(std::lround(kWeightUnit * plan_->vertex_weights[v])));
  }
  if (header_.weighted && normals_ != RestNormals::kNone) {
    const Vec3f slope = ToFloat(plan_->PatchWeightGradient(patch));
    const float components[] = {slope.x, slope.y, slope.z};
    for (size_t a = 0; a < 3; ++a) {
      arrays->slopes[a].push_back(std::bit_cast<uint32_t>(components[a]));
    }
  }
  for (size_t c = 0; c < RestNormalsPerPatch(normals_); ++c) {
    const uint32_t so_far = normals_so_far_;
    const RestNormal normal = NormalAt(patch, c);
    const auto numbered = NumberNormal(patch, c, normal);
    arrays->normals.push_back(UseCode(numbered, so_far));
    if (!numbered.second) continue;
    for (size_t i = 0; i < NumbersPerRestNormal(normals_); ++i) {
      arrays->rest[i].push_back(normal.number[i]);
    }
  }
}

absl::StatusOr<std::optional<PatchRun>> PatchPlanWriter::NextRun() {
  const size_t count = plan_->patches.size(), inside = count - plan_->outside_patches;
  if (next_patch_ == count) return std::nullopt;
  const size_t end = std::min(next_patch_ + kMaxRunPatches, next_patch_ < inside ? inside : count);
  PatchRun run{.first_patch = next_patch_, .patches = static_cast<uint32_t>(end - next_patch_)};
  RunArrays arrays;
  for (; next_patch_ < end; ++next_patch_) AppendPatch(next_patch_, &arrays);
  run.new_vertices = static_cast<uint32_t>(arrays.places[0].size());
  run.new_normals = static_cast<uint32_t>(arrays.rest[0].size());
  LATTICED_ASSIGN_OR_RETURN(run.data, Deflate(arrays.Bytes()));
  return run;
}

void PatchPlanWriter::FindSeamVertices() {
  const auto& vertices = plan_->vertices;
  seam_vertices_.reserve(
      static_cast<size_t>(std::count_if(vertices.begin(), vertices.end(), IsOnSeam)));
  for (size_t v = 0; v < vertices.size(); ++v) {
    if (IsOnSeam(vertices[v]))
      seam_vertices_.emplace_back(vertex_numbers_[v], static_cast<uint32_t>(v));
  }
  std::sort(seam_vertices_.begin(), seam_vertices_.end());
}

void PatchPlanWriter::AppendSeamRanges(PatchSeams* part) {
  const size_t end = std::min(plan_->seams.size(), next_seam_ + kMaxSeamMembers);
  for (; next_seam_ < end; ++next_seam_) {
    const Seam& seam = plan_->seams[next_seam_];
    for (size_t a = 0; a < 3; ++a) {
      part->ranges.push_back(seam.rests ? 1 : static_cast<uint32_t>(seam.first[a]));
      part->ranges.push_back(seam.rests ? 0 : static_cast<uint32_t>(seam.last[a]));
    }
  }
}

void PatchPlanWriter::AppendSeamVertices(PatchSeams* part) {
  const size_t end = std::min(seam_vertices_.size(), next_seam_vertex_ + kMaxSeamMembers);
  for (; next_seam_vertex_ < end; ++next_seam_vertex_) {
    const auto [number, v] = seam_vertices_[next_seam_vertex_];
    const PlanVertex& vertex = plan_->vertices[v];
    part->vertices.push_back(number);
    part->vertex_seams.push_back(vertex.seam);
    for (const uint32_t place : OutsidePlaces(outside_box_, vertex.world)) {
      part->outside_places.push_back(place);
    }
  }
}

void PatchPlanWriter::AppendSeamEdges(PatchSeams* part) {
  for (; next_seam_edge_ < plan_->edges.size() && part->edges.size() < kMaxSeamMembers;
       ++next_seam_edge_) {
    const uint32_t seam = plan_->edges[next_seam_edge_].seam;
    if (seam == kNoIndex) continue;
    part->edges.push_back(static_cast<uint32_t>(next_seam_edge_));
    part->edge_seams.push_back(seam);
  }
}

std::optional<PatchSeams> PatchPlanWriter::NextSeams() {
  if (plan_->seams.empty() || seams_done_) return std::nullopt;
  if (next_seam_ == 0) FindSeamVertices();
  PatchSeams part;
  AppendSeamRanges(&part);
  AppendSeamVertices(&part);
  AppendSeamEdges(&part);
  if (!part.ranges.empty() || !part.vertices.empty() || !part.edges.empty()) return part;
  seams_done_ = true;
  for (const Vec3d p : plan_->identity_points)
    part.identity_points.insert(part.identity_points.end(), {p.x, p.y, p.z});
  return part;
}

}  // namespace latticed
