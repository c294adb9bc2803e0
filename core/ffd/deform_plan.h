// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The plan: everything about (mesh, lattice structure) that control points cannot change. Made once
// on the host in double, shared by all backends, views and revisions.
//
//   boxes     the non-empty cells of the knot grid, u fastest, then one pseudo box for what lies
//             outside the frame, under the identity map
//   vertices  corners of patches, one per position: all patches around a vertex name the same one
//   edges     edges of patches, end points in canonical order (lexicographic by world position)
//   patches   sub-triangles, sorted by box, then along a Morton curve; source winding kept, rotated
//             so that the edge from corner 0 to corner 1 is the longest in the world
//   chunks    runs of limits::kPatchesPerChunk patches; the last may be shorter
//
// Ownership makes the surface watertight. A vertex or edge belongs to the box that contains it; in a
// knot plane, to the *lower* box. It is evaluated there, whichever patch asks. A vertex or edge that
// patches inside and outside the frame share is on a seam. A seam is attached while no control point
// with a non-zero basis value on it has moved from its identity position (compared bit by bit): both
// sides then take the outside's point.
//
// Threads  immutable after MakePlan
#ifndef LATTICED_CORE_FFD_DEFORM_PLAN_H_
#define LATTICED_CORE_FFD_DEFORM_PLAN_H_

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/bounds.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

inline constexpr uint32_t kNoIndex = std::numeric_limits<uint32_t>::max();

struct KnotBox {
  // Knot spans: the box is [knots[span], knots[span + 1]] per axis. Unused outside.
  std::array<int, 3> span{};
  // Parameter bounds; world bounds of the outside pieces for the outside box.
  Vec3d lower, upper;
};

// Control points with a non-zero basis value on a seam: a product of index ranges [first, last].
struct Seam {
  uint32_t box = 0;
  std::array<int, 3> first{}, last{};
};

struct PlanVertex {
  Vec3d world;       // rest position
  Vec3d parameter;   // exactly the knot where the vertex is on a knot plane
  uint32_t box = 0;  // owner: lower box; the outside box if the vertex is outside the domain
  uint32_t seam = kNoIndex;  // index into seams when both inside and outside patches use it
};

struct PlanEdge {
  std::array<uint32_t, 2> vertex{};  // canonical order
  uint32_t box = 0;
  uint32_t seam = kNoIndex;
};

struct Patch {
  uint32_t box = 0;
  std::array<uint32_t, 3> vertex{};
  std::array<uint32_t, 3> edge{};       // edge[e] joins corner e and corner (e + 1) % 3
  std::array<bool, 3> edge_reversed{};  // canonical order runs from corner (e + 1) % 3 to corner e
};

// Where a patch comes from: enough to interpolate any corner attribute of the source.
struct PatchSource {
  uint32_t face = 0;
  std::array<uint32_t, 3> corners{};  // of the source triangle, indices into mesh corners
  std::array<std::array<double, 3>, 3> barycentrics{};  // of patch corner c in the source triangle
};

struct DeformPlan {
  std::shared_ptr<const PolygonMesh> mesh;
  LatticeStructure structure;
  std::vector<KnotBox> boxes;
  std::vector<PlanVertex> vertices;
  std::vector<PlanEdge> edges;
  std::vector<Patch> patches;
  std::vector<PatchSource> sources;  // one per patch
  std::vector<Seam> seams;
  std::vector<Vec3f> vertex_normals;   // per mesh corner, unit; given or area-weighted
  std::vector<Vec3d> identity_points;  // IdentityControlPoints(structure)
  Bounds mesh_bounds;
  Bounds outside_bounds;  // world bounds of the outside pieces; empty if none
  // Device arithmetic is relative to this point, a centre of the lattice.
  Vec3d local_origin;
  uint64_t outside_patches = 0;
  uint64_t seam_patches = 0;  // patches with an edge or corner on a seam

  uint32_t outside_box() const { return static_cast<uint32_t>(boxes.size()) - 1; }
  size_t chunk_count() const;
  // [first, last) patches of a chunk.
  std::array<size_t, 2> ChunkPatches(size_t chunk) const;
  // Patches in `box` are box_patches[box] .. box_patches[box + 1] - 1.
  std::vector<uint32_t> box_patches;
  // Patches of other boxes that have a vertex or edge owned by `box`, sorted, by box.
  std::vector<std::vector<uint32_t>> box_borrowers;
  size_t MemoryBytes() const;
};

// kInvalidArgument for an invalid structure; kResourceExhausted past limits::kMaxPatches; what
// `stop` says, which is asked every few thousand faces or patches.
[[nodiscard]] absl::StatusOr<std::shared_ptr<const DeformPlan>> MakePlan(
    std::shared_ptr<const PolygonMesh> mesh, const LatticeStructure& structure,
    StopCheck stop = NeverStop);

// Whether one seam is attached, and whether each is.
[[nodiscard]] bool IsAttached(const DeformPlan& plan, const Seam& seam,
                              std::span<const Vec3d> control_points);
[[nodiscard]] std::vector<bool> AttachedSeams(const DeformPlan& plan,
                                              std::span<const Vec3d> control_points);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_DEFORM_PLAN_H_
