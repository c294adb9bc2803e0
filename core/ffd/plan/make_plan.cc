// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/deform_plan.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/bspline_basis.h"
#include "core/ffd/plan/adjacency_index.h"
#include "core/ffd/plan/knot_split.h"
#include "core/ffd/plan/patch_chain.h"
#include "core/ffd/plan/vertex_normals.h"

namespace latticed {
namespace {

constexpr auto kChunk = static_cast<size_t>(limits::kPatchesPerChunk);

// Spreads the low 10 bits of x to every third bit.
constexpr uint32_t SpreadBits(uint32_t x) {
  x = (x | (x << 16)) & 0x030000FF;
  x = (x | (x << 8)) & 0x0300F00F;
  x = (x | (x << 4)) & 0x030C30C3;
  return (x | (x << 2)) & 0x09249249;
}

uint32_t MortonCode(Vec3d point, Vec3d lower, Vec3d upper) {
  uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = upper[axis] - lower[axis];
    const double unit = extent > 0 ? (point[axis] - lower[axis]) / extent : 0.0;
    const auto cell = static_cast<uint32_t>(std::clamp(unit * 1024.0, 0.0, 1023.0));
    code |= SpreadBits(cell) << axis;
  }
  return code;
}

// The non-empty knot spans of one axis.
std::vector<int> NonEmptySpans(const LatticeStructure& s, size_t axis) {
  std::vector<int> spans;
  for (int k = s.degree[axis]; k < s.size[axis]; ++k) {
    const auto i = static_cast<size_t>(k);
    if (s.knots[axis][i + 1] > s.knots[axis][i]) spans.push_back(k);
  }
  return spans;
}

class Planner {
 public:
  Planner(std::shared_ptr<const PolygonMesh> mesh, const LatticeStructure& structure,
          SplitMesh split, StopCheck stop, VertexWeights weights,
          std::span<const LatticeStructure> turned)
      : split_(std::move(split)), stop_(stop), poll_(stop), plan_(std::make_shared<DeformPlan>()) {
    plan_->mesh = std::move(mesh);
    plan_->structure = structure;
    plan_->mesh_weights = std::move(weights);
    for (const LatticeStructure& one : turned) plan_->turned.push_back({.structure = one});
  }

  absl::StatusOr<std::shared_ptr<const DeformPlan>> Run(std::optional<double> crease_angle) {
    plan_->mesh_bounds = plan_->mesh->ComputeBounds();
    plan_->local_origin = plan_->mesh_bounds.center();
    MakeIdentity();
    LATTICED_ASSIGN_OR_RETURN(plan_->vertex_normals,
                              UnitCornerNormals(*plan_->mesh, crease_angle, stop_));
    MakeBoxes();
    LATTICED_RETURN_IF_ERROR(AssignPieces());
    LATTICED_RETURN_IF_ERROR(SortPatches());
    LATTICED_RETURN_IF_ERROR(MakeEdges());
    LATTICED_RETURN_IF_ERROR(AssignOwners());
    LATTICED_RETURN_IF_ERROR(FindBorrowers());
    LATTICED_RETURN_IF_ERROR(PlaceInTurned());
    return std::move(plan_);
  }

 private:
  const LatticeStructure& structure() const { return plan_->structure; }

  void MakeIdentity() {
    std::vector<Vec3d>& points = plan_->identity_points;
    points = IdentityControlPoints(structure());
    for (TurnedLattice& lattice : plan_->turned) {
      lattice.first_point = points.size();
      const std::vector<Vec3d> own = IdentityControlPoints(lattice.structure);
      points.insert(points.end(), own.begin(), own.end());
    }
  }

  // Finds where vertices and patches are in the turned lattices.
  absl::Status PlaceInTurned() {
    for (size_t g = 0; g < plan_->turned.size(); ++g) {
      TurnedLattice& lattice = plan_->turned[g];
      lattice.parameters = std::move(split_.turned[g]);
      lattice.spans.reserve(plan_->patches.size());
      for (const Patch& patch : plan_->patches) {
        LATTICED_RETURN_IF_ERROR(poll_.Step());
        const std::array corners{lattice.parameters[patch.vertex[0]],
                                 lattice.parameters[patch.vertex[1]],
                                 lattice.parameters[patch.vertex[2]]};
        lattice.spans.push_back(LowerSpans(lattice.structure, corners));
      }
    }
    return absl::OkStatus();
  }

  void MakeBoxes() {
    std::array<std::vector<int>, 3> spans;
    for (size_t a = 0; a < 3; ++a) {
      spans[a] = NonEmptySpans(structure(), a);
      box_of_span_[a].assign(static_cast<size_t>(structure().size[a]), 0);
      for (size_t i = 0; i < spans[a].size(); ++i) {
        box_of_span_[a][static_cast<size_t>(spans[a][i])] = static_cast<uint32_t>(i);
      }
      box_count_[a] = static_cast<uint32_t>(spans[a].size());
    }
    for (int k : spans[2]) {
      for (int j : spans[1]) {
        for (int i : spans[0]) {
          KnotBox box{{i, j, k}, {}, {}};
          for (int a = 0; a < 3; ++a) {
            const auto axis = static_cast<size_t>(a);
            const auto span = static_cast<size_t>(box.span[axis]);
            box.lower[a] = structure().knots[axis][span];
            box.upper[a] = structure().knots[axis][span + 1];
          }
          plan_->boxes.push_back(box);
        }
      }
    }
    plan_->boxes.emplace_back();  // outside
  }

  bool InDomain(Vec3d p) const {
    for (int a = 0; a < 3; ++a) {
      if (p[a] < structure().domain_begin(a) || p[a] > structure().domain_end(a)) return false;
    }
    return true;
  }

  // The box whose closed cell holds a point; in a knot plane, the lower one.
  uint32_t LowerBox(Vec3d parameter) const {
    std::array<uint32_t, 3> cell;
    for (int a = 0; a < 3; ++a) {
      const auto axis = static_cast<size_t>(a);
      const int span = FindLowerSpan(structure().knots[axis].data(), structure().degree[axis],
                                     structure().size[axis], parameter[a]);
      cell[axis] = box_of_span_[axis][static_cast<size_t>(span)];
    }
    return cell[0] + box_count_[0] * (cell[1] + box_count_[1] * cell[2]);
  }

  // A piece lies in one slab per axis, so its largest coordinates are in its box. In a knot plane it belongs to the
  // lower box.
  absl::Status AssignPieces() {
    piece_box_.reserve(split_.pieces.size());
    for (const SplitPiece& piece : split_.pieces) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      Vec3d high = split_.vertices[piece.vertex[0]].parameter;
      bool inside = true;
      for (const uint32_t v : piece.vertex) {
        inside = inside && InDomain(split_.vertices[v].parameter);
        high = Max(high, split_.vertices[v].parameter);
      }
      piece_box_.push_back(inside ? LowerBox(high) : plan_->outside_box());
      if (inside) continue;
      for (const uint32_t v : piece.vertex) plan_->outside_bounds.Extend(split_.vertices[v].world);
    }
    KnotBox& outside = plan_->boxes.back();
    outside.lower = plan_->outside_bounds.empty() ? Vec3d{} : plan_->outside_bounds.min;
    outside.upper = plan_->outside_bounds.empty() ? Vec3d{} : plan_->outside_bounds.max;
    return absl::OkStatus();
  }

  absl::Status SortPatches() {
    const size_t count = split_.pieces.size();
    // Sorts pairs of (box and Morton code, piece), so that a comparison reads no other memory.
    std::vector<std::pair<uint64_t, uint32_t>> order(count);
    PatchChain chain(split_, plan_->mesh_bounds);
    for (size_t p = 0; p < count; ++p) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      chain.AddPiece();
      const auto& v = split_.pieces[p].vertex;
      const bool outside = piece_box_[p] == plan_->outside_box();
      Vec3d centroid;
      for (const uint32_t id : v) {
        centroid += (outside ? split_.vertices[id].world : split_.vertices[id].parameter) / 3.0;
      }
      const KnotBox& box = plan_->boxes[piece_box_[p]];
      order[p] = {(uint64_t{piece_box_[p]} << 32) | MortonCode(centroid, box.lower, box.upper),
                  static_cast<uint32_t>(p)};
    }
    std::sort(order.begin(), order.end());
    plan_->patches.reserve(count);
    plan_->sources.reserve(count);
    plan_->box_patches.assign(plan_->boxes.size() + 1, 0);
    LATTICED_RETURN_IF_ERROR(AddPatches(order, chain));
    std::partial_sum(plan_->box_patches.begin(), plan_->box_patches.end(),
                     plan_->box_patches.begin());
    plan_->outside_patches = count - plan_->box_patches[plan_->outside_box()];
    return absl::OkStatus();
  }

  // Adds the patches of each chunk and box in a chain. Chunks and boxes keep the patches that `order` gives them.
  absl::Status AddPatches(std::span<const std::pair<uint64_t, uint32_t>> order, PatchChain& chain) {
    std::vector<uint32_t> pieces;
    std::vector<ChainedPiece> chained;
    for (size_t p = 0; p < order.size(); ++p) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      if (p % kChunk == 0) chain.BeginChunk();
      pieces.push_back(order[p].second);
      const uint32_t box = piece_box_[order[p].second];
      const size_t next = p + 1;
      if (next < order.size() && next % kChunk != 0 && piece_box_[order[next].second] == box)
        continue;
      chained.clear();
      chain.Append(pieces, chained);
      for (const auto& [piece, corner] : chained) AddPatch(split_.pieces[piece], box, corner);
      pieces.clear();
    }
    return absl::OkStatus();
  }

  void AddPatch(const SplitPiece& piece, uint32_t box, uint32_t first) {
    const SourceTriangle& triangle = split_.triangles[piece.triangle];
    Patch patch{.box = box};
    PatchSource source{.face = triangle.face, .corners = triangle.corners};
    for (size_t c = 0; c < 3; ++c) {
      patch.vertex[c] = piece.vertex[(first + c) % 3];
      source.barycentrics[c] = piece.barycentrics[(first + c) % 3];
    }
    plan_->patches.push_back(patch);
    plan_->sources.push_back(source);
    ++plan_->box_patches[box + 1];
  }

  absl::Status MakeEdges() {
    AdjacencyIndex ids;
    ids.Reserve(split_.vertices.size(), plan_->patches.size() * 3 / 2 + 16);
    plan_->edges.reserve(plan_->patches.size() * 3 / 2 + 16);
    for (Patch& patch : plan_->patches) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      for (size_t e = 0; e < 3; ++e) {
        uint32_t a = patch.vertex[e], b = patch.vertex[(e + 1) % 3];
        patch.edge_reversed[e] =
            std::pair(split_.vertices[b].world, b) < std::pair(split_.vertices[a].world, a);
        if (patch.edge_reversed[e]) std::swap(a, b);
        const auto [id, added] = ids.TryEmplace(a, b, static_cast<uint32_t>(plan_->edges.size()));
        if (added) plan_->edges.push_back({.vertex = {a, b}});
        patch.edge[e] = id;
      }
    }
    return absl::OkStatus();
  }

  absl::Status AssignOwners() {
    constexpr uint8_t kInside = 1, kOutside = 2, kBoth = 3;
    std::vector<uint8_t> vertex_use(split_.vertices.size()), edge_use(plan_->edges.size());
    for (const Patch& patch : plan_->patches) {
      const uint8_t use = patch.box == plan_->outside_box() ? kOutside : kInside;
      for (size_t i = 0; i < 3; ++i) {
        vertex_use[patch.vertex[i]] |= use;
        edge_use[patch.edge[i]] |= use;
      }
    }
    plan_->vertices.reserve(split_.vertices.size());
    for (size_t v = 0; v < split_.vertices.size(); ++v) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      const Vec3d p = split_.vertices[v].parameter;
      PlanVertex vertex{.world = split_.vertices[v].world, .parameter = p};
      vertex.box = (vertex_use[v] & kInside) ? LowerBox(p) : plan_->outside_box();
      if (vertex_use[v] == kBoth) vertex.seam = FindSeam(vertex.box, p, p, Rests(v));
      plan_->vertices.push_back(vertex);
      if (plan_->mesh_weights != nullptr)
        plan_->vertex_weights.push_back(split_.vertices[v].weight);
    }
    for (size_t e = 0; e < plan_->edges.size(); ++e) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      PlanEdge& edge = plan_->edges[e];
      const Vec3d a = split_.vertices[edge.vertex[0]].parameter;
      const Vec3d b = split_.vertices[edge.vertex[1]].parameter;
      edge.box = (edge_use[e] & kInside) ? LowerBox(Max(a, b)) : plan_->outside_box();
      const bool rests = Rests(edge.vertex[0]) && Rests(edge.vertex[1]);
      if (edge_use[e] == kBoth) edge.seam = FindSeam(edge.box, a, b, rests);
    }
    for (const Patch& patch : plan_->patches) plan_->seam_patches += TouchesSeam(patch) ? 1u : 0u;
    return absl::OkStatus();
  }

  bool Rests(size_t vertex) const {
    return plan_->mesh_weights != nullptr && split_.vertices[vertex].weight == 0;
  }

  bool TouchesSeam(const Patch& patch) const {
    const auto may_tear = [&](uint32_t seam) {
      return seam != kNoIndex && !plan_->seams[seam].rests;
    };
    for (size_t i = 0; i < 3; ++i) {
      if (may_tear(plan_->vertices[patch.vertex[i]].seam)) return true;
      if (may_tear(plan_->edges[patch.edge[i]].seam)) return true;
    }
    return false;
  }

  // Returns the seam that has the control points with a non-zero basis value on the segment a–b of `box`.
  uint32_t FindSeam(uint32_t box, Vec3d a, Vec3d b, bool rests) {
    Seam seam{.box = box, .rests = rests};
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<size_t>(axis);
      const int degree = structure().degree[i], span = plan_->boxes[box].span[i];
      seam.first[i] = span - degree;
      seam.last[i] = span;
      if (a[axis] != b[axis]) continue;
      std::array<double, limits::kMaxDegree + 1> basis;
      EvaluateBasis(structure().knots[i].data(), degree, span, a[axis], basis.data());
      while (basis[static_cast<size_t>(seam.first[i] - span + degree)] == 0) ++seam.first[i];
      while (basis[static_cast<size_t>(seam.last[i] - span + degree)] == 0) --seam.last[i];
    }
    const auto [it, added] = seam_ids_.try_emplace(std::tuple(box, seam.first, seam.last, rests),
                                                   static_cast<uint32_t>(plan_->seams.size()));
    if (added) plan_->seams.push_back(seam);
    return it->second;
  }

  absl::Status FindBorrowers() {
    plan_->box_borrowers.resize(plan_->boxes.size());
    for (size_t p = 0; p < plan_->patches.size(); ++p) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      const Patch& patch = plan_->patches[p];
      if (patch.box == plan_->outside_box()) continue;  // outside patches own all their points
      for (size_t i = 0; i < 3; ++i) {
        for (const uint32_t owner :
             {plan_->vertices[patch.vertex[i]].box, plan_->edges[patch.edge[i]].box}) {
          if (owner == patch.box) continue;
          std::vector<uint32_t>& borrowers = plan_->box_borrowers[owner];
          if (borrowers.empty() || borrowers.back() != p) {
            borrowers.push_back(static_cast<uint32_t>(p));
          }
        }
      }
    }
    return absl::OkStatus();
  }

  SplitMesh split_;
  const StopCheck stop_;
  StopPoll poll_;
  std::shared_ptr<DeformPlan> plan_;
  std::array<std::vector<uint32_t>, 3> box_of_span_;
  std::array<uint32_t, 3> box_count_{};
  std::vector<uint32_t> piece_box_;
  std::map<std::tuple<uint32_t, std::array<int, 3>, std::array<int, 3>, bool>, uint32_t> seam_ids_;
};

absl::Status CheckPlanned(const LatticeStructure& structure) {
  LATTICED_RETURN_IF_ERROR(Validate(structure));
  if (structure.outside == Outside{}) return absl::OkStatus();
  return error::InvalidField("lattice.outside", "a plan is made for OutsideMap::continued()");
}

}  // namespace

absl::StatusOr<std::shared_ptr<const DeformPlan>> MakePlan(
    std::shared_ptr<const PolygonMesh> mesh, const LatticeStructure& structure,
    std::optional<double> crease_angle, StopCheck stop, VertexWeights weights,
    std::span<const LatticeStructure> turned) {
  LATTICED_RETURN_IF_ERROR(CheckPlanned(structure));
  for (const LatticeStructure& one : turned) LATTICED_RETURN_IF_ERROR(CheckPlanned(one));
  if (weights != nullptr) LATTICED_RETURN_IF_ERROR(CheckVertexWeights(*mesh, *weights));
  const std::span<const float> of_positions =
      weights == nullptr ? std::span<const float>() : *weights;
  LATTICED_ASSIGN_OR_RETURN(auto split, SplitAtKnots(*mesh, structure, stop, of_positions, turned));
  if (split.pieces.empty()) {
    return error::InvalidField("mesh", "no face has three corners at different positions");
  }
  return Planner(std::move(mesh), structure, std::move(split), stop, std::move(weights), turned)
      .Run(crease_angle);
}

}  // namespace latticed
