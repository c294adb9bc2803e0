// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The plan: everything about a mesh and a lattice structure that does not depend on control points. It is made once, on
// the host, in double. All backends, views and revisions share it.
//
//   boxes     the non-empty cells of the knot grid, u fastest, then the outside box: it stands for all that lies
//             outside the frame, and has the identity map
//   vertices  corners of patches; all patches around a vertex name the same one
//   edges     edges of patches, end points in canonical order (lexicographic by world position); numbered in the order
//             of first use: by patches in order, in a patch by its edges 0, 1, 2
//   patches   sub-triangles, sorted by box, then along a Morton curve; those of one chunk and box are then put in a
//             chain (patch_chain.h). They keep the winding of the source. In the world, the edge from corner 0
//             to corner 1 has no obtuse angle, or is the longest
//   chunks    runs of limits::kPatchesPerChunk patches; the last may be shorter
//
// Ownership makes the surface watertight. The box that contains a vertex or edge owns it; in a knot plane that is the
// *lower* box. The vertex or edge is evaluated there, whichever patch asks. A vertex or edge that patches inside and
// outside the frame share is on a seam. A seam is attached while no control point with a non-zero basis value on it has
// moved from its identity position (compared without tolerance): both sides then take the outside's point. A vertex of weight
// 0 rests, and so does an edge between two: their seams are always attached.
//
// Threads  immutable after MakePlan
#ifndef LATTICED_CORE_FFD_PLAN_DEFORM_PLAN_H_
#define LATTICED_CORE_FFD_PLAN_DEFORM_PLAN_H_

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/bounds.h"
#include "core/base/stop_check.h"
#include "core/base/vec.h"
#include "core/ffd/lattice.h"
#include "core/ffd/turned/turned_lattice.h"
#include "core/ffd/weights/vertex_weights.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

inline constexpr uint32_t kNoIndex = std::numeric_limits<uint32_t>::max();

struct KnotBox {
  // Knot spans: the box is [knots[span], knots[span + 1]] per axis. The outside box does not use them.
  std::array<int, 3> span{};
  // Bounds in parameter space; in the outside box, the world bounds of the outside pieces.
  Vec3d lower, upper;
};

// The control points with a non-zero basis value on a seam, as an index range [first, last] per axis.
struct Seam {
  uint32_t box = 0;
  std::array<int, 3> first{}, last{};
  bool rests = false;  // what is on it has the weight 0, and no control point moves it
};

struct PlanVertex {
  Vec3d world;               // rest position
  Vec3d parameter;           // exactly the knot where the vertex is on a knot plane
  uint32_t box = 0;          // owner: the lower box; the outside box if only outside patches use it
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

// The source triangle of a patch, and what is needed to interpolate any attribute of its corners.
struct PatchSource {
  uint32_t face = 0;
  std::array<uint32_t, 3> corners{};  // of the source triangle, indices into mesh corners
  std::array<std::array<double, 3>, 3> barycentrics{};  // of patch corner c in the source triangle
};

struct DeformPlan {
  std::shared_ptr<const PolygonMesh> mesh;
  LatticeStructure structure;
  // Lattices whose frames are turned against that of `structure`. Boxes, edges and seams are those of `structure` alone.
  std::vector<TurnedLattice> turned;
  std::vector<KnotBox> boxes;
  std::vector<PlanVertex> vertices;
  std::vector<PlanEdge> edges;
  std::vector<Patch> patches;
  std::vector<PatchSource> sources;  // one per patch
  std::vector<Seam> seams;
  std::vector<Vec3f> vertex_normals;  // per mesh corner, unit (vertex_normals.h)
  // IdentityControlPoints of `structure`, then of the turned lattices, as all control points of a plan.
  std::vector<Vec3d> identity_points;
  // By position of the mesh, and by vertex. Null and empty where the scene has no weights.
  VertexWeights mesh_weights;
  std::vector<double> vertex_weights;
  Bounds mesh_bounds;
  Bounds outside_bounds;  // world bounds of the outside pieces; empty if none
  // Backends compute relative to this point, the centre of the mesh's bounds.
  Vec3d local_origin;
  uint64_t outside_patches = 0;
  uint64_t seam_patches = 0;  // patches with an edge or corner on a seam that does not rest

  uint32_t outside_box() const { return static_cast<uint32_t>(boxes.size()) - 1; }
  size_t chunk_count() const;
  size_t control_point_count() const { return identity_points.size(); }
  // Of the lattices together.
  int patch_degree() const;
  // Of a patch of the deformed surface: weights add one.
  int surface_degree() const { return patch_degree() + (is_weighted() ? 1 : 0); }
  bool is_weighted() const { return !vertex_weights.empty(); }
  // The weights of a patch's corners. The plan must be weighted.
  std::array<double, 3> CornerWeights(size_t patch) const;
  // The gradient of the weight in a patch, from its source triangle. The plan must be weighted.
  Vec3d PatchWeightGradient(size_t patch) const;
  // The patches [first, last) of a chunk.
  std::array<size_t, 2> ChunkPatches(size_t chunk) const;
  // Patches in `box` are box_patches[box] .. box_patches[box + 1] - 1.
  std::vector<uint32_t> box_patches;
  // By owner: the patches of other knot boxes that have a vertex or edge owned by this box, ascending.
  std::vector<std::vector<uint32_t>> box_borrowers;
  size_t MemoryBytes() const;
};

// crease_angle: see vertex_normals.h; weights: see weights/vertex_weights.h; turned: structures of turned lattices.
// Errors: kInvalidArgument for an invalid structure, one that goes on outside (outside/outside_map.h makes the one to be
// given here), invalid weights, or where no face has three different positions;
// kResourceExhausted past limits::kMaxPatches; what `stop` returns. It is called every few thousand faces or patches.
[[nodiscard]] absl::StatusOr<std::shared_ptr<const DeformPlan>> MakePlan(
    std::shared_ptr<const PolygonMesh> mesh, const LatticeStructure& structure,
    std::optional<double> crease_angle = {}, StopCheck stop = NeverStop,
    VertexWeights weights = nullptr, std::span<const LatticeStructure> turned = {});

// Whether `seam` is attached; AttachedSeams answers for every seam of the plan.
[[nodiscard]] bool IsAttached(const DeformPlan& plan, const Seam& seam,
                              std::span<const Vec3d> control_points);
[[nodiscard]] std::vector<bool> AttachedSeams(const DeformPlan& plan,
                                              std::span<const Vec3d> control_points);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_PLAN_DEFORM_PLAN_H_
