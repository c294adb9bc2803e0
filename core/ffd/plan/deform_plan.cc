// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a DeformPlan says of itself, and which of its seams are attached. make_plan.cc makes it.
#include "core/ffd/plan/deform_plan.h"

#include <algorithm>

#include "core/base/limits.h"

namespace latticed {
namespace {

constexpr auto kOfChunk = static_cast<size_t>(limits::kPatchesPerChunk);

template <typename T>
size_t BytesUsed(const std::vector<T>& v) {
  return v.size() * sizeof(T);
}

}  // namespace

size_t DeformPlan::chunk_count() const { return (patches.size() + kOfChunk - 1) / kOfChunk; }

int DeformPlan::patch_degree() const {
  int degree = structure.patch_degree();
  for (const TurnedLattice& one : turned) degree = std::max(degree, one.structure.patch_degree());
  return degree;
}

std::array<size_t, 2> DeformPlan::ChunkPatches(size_t chunk) const {
  return {chunk * kOfChunk, std::min(patches.size(), (chunk + 1) * kOfChunk)};
}

std::array<double, 3> DeformPlan::CornerWeights(size_t patch) const {
  const auto& v = patches[patch].vertex;
  return {vertex_weights[v[0]], vertex_weights[v[1]], vertex_weights[v[2]]};
}

Vec3d DeformPlan::PatchWeightGradient(size_t patch) const {
  std::array<Vec3d, 3> corners;
  std::array<double, 3> weights;
  for (size_t c = 0; c < 3; ++c) {
    const uint32_t v = mesh->corner_vertices[sources[patch].corners[c]];
    corners[c] = mesh->positions[v];
    weights[c] = (*mesh_weights)[v];
  }
  return WeightGradient(corners, weights);
}

size_t DeformPlan::MemoryBytes() const {
  size_t bytes = BytesUsed(boxes) + BytesUsed(vertices) + BytesUsed(edges) + BytesUsed(patches) +
                 BytesUsed(sources) + BytesUsed(seams) + BytesUsed(vertex_normals) +
                 BytesUsed(identity_points) + BytesUsed(box_patches) + BytesUsed(vertex_weights);
  if (mesh_weights != nullptr) bytes += BytesUsed(*mesh_weights);
  for (const auto& borrowers : box_borrowers) bytes += BytesUsed(borrowers);
  for (const TurnedLattice& one : turned) bytes += BytesUsed(one.parameters) + BytesUsed(one.spans);
  return bytes;
}

bool IsAttached(const DeformPlan& plan, const Seam& seam, std::span<const Vec3d> control_points) {
  if (seam.rests) return true;
  for (int k = seam.first[2]; k <= seam.last[2]; ++k) {
    for (int j = seam.first[1]; j <= seam.last[1]; ++j) {
      for (int i = seam.first[0]; i <= seam.last[0]; ++i) {
        const auto index = static_cast<size_t>(plan.structure.Index(i, j, k));
        if (control_points[index] != plan.identity_points[index]) return false;
      }
    }
  }
  return true;
}

std::vector<bool> AttachedSeams(const DeformPlan& plan, std::span<const Vec3d> control_points) {
  std::vector<bool> attached(plan.seams.size());
  for (size_t s = 0; s < plan.seams.size(); ++s) {
    attached[s] = IsAttached(plan, plan.seams[s], control_points);
  }
  return attached;
}

}  // namespace latticed
