// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/plan_slice.h"

#include <algorithm>
#include <utility>

namespace latticed {
namespace {

// Numbers those entries of a table that are used, in the table's order.
class Renumbering {
 public:
  explicit Renumbering(size_t entries) : number_(entries, kNoIndex) {}

  void Use(uint32_t entry) { number_[entry] = 0; }
  // After this, Of may be called for entries in use.
  void Number() {
    for (uint32_t& number : number_) {
      if (number != kNoIndex) number = count_++;
    }
  }
  uint32_t Of(uint32_t entry) const { return number_[entry]; }

  template <typename T>
  std::vector<T> Take(const std::vector<T>& table) const {
    std::vector<T> taken;
    taken.reserve(count_);
    for (size_t i = 0; i < table.size(); ++i) {
      if (number_[i] != kNoIndex) taken.push_back(table[i]);
    }
    return taken;
  }

 private:
  std::vector<uint32_t> number_;
  uint32_t count_ = 0;
};

class Slicer {
 public:
  Slicer(const DeformPlan& plan, size_t first_patch, size_t last_patch)
      : plan_(plan),
        first_(static_cast<std::ptrdiff_t>(first_patch)),
        last_(static_cast<std::ptrdiff_t>(last_patch)),
        slice_(std::make_shared<DeformPlan>()) {}

  std::shared_ptr<const DeformPlan> Run() {
    CopyWhole();
    SlicePatches();
    SliceCorners();
    return std::move(slice_);
  }

 private:
  void CopyWhole() {
    slice_->structure = plan_.structure;
    slice_->boxes = plan_.boxes;
    slice_->seams = plan_.seams;
    slice_->identity_points = plan_.identity_points;
    slice_->mesh_bounds = plan_.mesh_bounds;
    slice_->outside_bounds = plan_.outside_bounds;
    slice_->local_origin = plan_.local_origin;
    slice_->outside_patches = plan_.outside_patches;
    slice_->seam_patches = plan_.seam_patches;
    const auto first = static_cast<uint32_t>(first_), last = static_cast<uint32_t>(last_);
    for (const uint32_t patch : plan_.box_patches) {
      slice_->box_patches.push_back(std::clamp(patch, first, last) - first);
    }
  }

  void SlicePatches() {
    slice_->patches.assign(plan_.patches.begin() + first_, plan_.patches.begin() + last_);
    Renumbering vertices(plan_.vertices.size());
    for (const Patch& patch : slice_->patches) {
      for (const uint32_t vertex : patch.vertex) vertices.Use(vertex);
    }
    vertices.Number();
    slice_->vertices = vertices.Take(plan_.vertices);
    slice_->vertex_weights = vertices.Take(plan_.vertex_weights);
    std::vector<uint32_t> edge_numbers(plan_.edges.size(), kNoIndex);
    for (Patch& patch : slice_->patches) {
      for (uint32_t& vertex : patch.vertex) vertex = vertices.Of(vertex);
      for (uint32_t& edge : patch.edge) {
        uint32_t& number = edge_numbers[edge];
        if (number == kNoIndex) {
          number = static_cast<uint32_t>(slice_->edges.size());
          slice_->edges.push_back(plan_.edges[edge]);
        }
        edge = number;
      }
    }
    for (PlanEdge& edge : slice_->edges) {
      for (uint32_t& vertex : edge.vertex) vertex = vertices.Of(vertex);
    }
  }

  void SliceCorners() {
    slice_->sources.assign(plan_.sources.begin() + first_, plan_.sources.begin() + last_);
    Renumbering corners(plan_.mesh->corner_count()), positions(plan_.mesh->positions.size());
    for (const PatchSource& source : slice_->sources) {
      for (const uint32_t corner : source.corners) {
        corners.Use(corner);
        positions.Use(plan_.mesh->corner_vertices[corner]);
      }
    }
    corners.Number();
    positions.Number();
    for (PatchSource& source : slice_->sources) {
      for (uint32_t& corner : source.corners) corner = corners.Of(corner);
    }
    slice_->vertex_normals = corners.Take(plan_.vertex_normals);
    auto mesh = std::make_shared<PolygonMesh>();
    mesh->positions = positions.Take(plan_.mesh->positions);
    if (plan_.mesh_weights != nullptr) {
      slice_->mesh_weights =
          std::make_shared<const std::vector<float>>(positions.Take(*plan_.mesh_weights));
    }
    mesh->corner_vertices = corners.Take(plan_.mesh->corner_vertices);
    for (uint32_t& vertex : mesh->corner_vertices) vertex = positions.Of(vertex);
    slice_->mesh = std::move(mesh);
  }

  const DeformPlan& plan_;
  const std::ptrdiff_t first_, last_;  // patches
  std::shared_ptr<DeformPlan> slice_;
};

}  // namespace

std::shared_ptr<const DeformPlan> SlicePlan(const DeformPlan& plan, size_t first_chunk,
                                            size_t last_chunk) {
  return Slicer(plan, plan.ChunkPatches(first_chunk)[0], plan.ChunkPatches(last_chunk - 1)[1])
      .Run();
}

}  // namespace latticed
