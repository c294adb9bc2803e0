// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/knot_split.h"

#include <algorithm>
#include <bit>
#include <span>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/plan/adjacency_index.h"
#include "core/ffd/plan/convex_triangulation.h"
#include "core/mesh/triangulate.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// A corner of a polygon that is being cut.
struct PolygonVertex {
  uint32_t id = 0;
  std::array<double, 3> barycentric{};
};
using Polygon = std::vector<PolygonVertex>;

using VertexKey = std::array<uint64_t, 4>;

// Equal positions of equal weights have equal keys: + 0.0 turns -0 into +0.
VertexKey KeyOf(Vec3d p, double weight) {
  return {std::bit_cast<uint64_t>(p.x + 0.0), std::bit_cast<uint64_t>(p.y + 0.0),
          std::bit_cast<uint64_t>(p.z + 0.0), std::bit_cast<uint64_t>(weight + 0.0)};
}

std::vector<double> DistinctKnots(const LatticeStructure& s, int axis) {
  const auto a = static_cast<size_t>(axis);
  std::vector<double> planes(s.knots[a].begin() + s.degree[a], s.knots[a].begin() + s.size[a] + 1);
  planes.erase(std::unique(planes.begin(), planes.end()), planes.end());
  return planes;
}

// The parameter space of a lattice, and its knot planes.
class SplitPlanes {
 public:
  explicit SplitPlanes(const LatticeStructure& structure) : map_(structure) {
    for (int axis = 0; axis < 3; ++axis) {
      planes_[static_cast<size_t>(axis)] = DistinctKnots(structure, axis);
      snap_[axis] = kPlaneSnap * (structure.domain_end(axis) - structure.domain_begin(axis));
    }
  }

  const std::vector<double>& along(int axis) const { return planes_[static_cast<size_t>(axis)]; }
  Vec3d Place(Vec3d world) const { return Snap(map_.ToParameter(world)); }
  Vec3d Snap(Vec3d parameter) const {
    for (int axis = 0; axis < 3; ++axis) {
      const auto& planes = along(axis);
      const auto above = std::lower_bound(planes.begin(), planes.end(), parameter[axis]);
      if (above != planes.end() && *above - parameter[axis] <= snap_[axis]) {
        parameter[axis] = *above;
      } else if (above != planes.begin() && parameter[axis] - *(above - 1) <= snap_[axis]) {
        parameter[axis] = *(above - 1);
      }
    }
    return parameter;
  }

 private:
  const FrameMap map_;
  std::array<std::vector<double>, 3> planes_;
  Vec3d snap_;
};

class Splitter {
 public:
  Splitter(const PolygonMesh& mesh, const LatticeStructure& structure, StopCheck stop,
           std::span<const float> weights, std::span<const LatticeStructure> turned)
      : mesh_(mesh), weights_(weights), stop_(stop), poll_(stop) {
    lattices_.emplace_back(structure);
    for (const LatticeStructure& one : turned) lattices_.emplace_back(one);
    result_.turned.resize(turned.size());
  }

  absl::StatusOr<SplitMesh> Run() {
    LATTICED_RETURN_IF_ERROR(AddMeshVertices());
    std::vector<Vec3d> polygon;
    std::vector<std::array<uint32_t, 3>> triangles;
    for (size_t face = 0; face < mesh_.face_count(); ++face) {
      const uint32_t begin = mesh_.face_offsets[face], end = mesh_.face_offsets[face + 1];
      LATTICED_RETURN_IF_ERROR(poll_.Step(end - begin));
      if (end - begin == 3) {
        triangles.assign(1, {0, 1, 2});
      } else {
        polygon.clear();
        for (uint32_t c = begin; c < end; ++c) {
          polygon.push_back(mesh_.positions[mesh_.corner_vertices[c]]);
        }
        LATTICED_RETURN_IF_ERROR(Triangulate(face, polygon, &triangles));
      }
      const size_t pieces_before = result_.pieces.size();
      for (const auto& [a, b, c] : triangles) {
        SplitTriangle(static_cast<uint32_t>(face), {begin + a, begin + b, begin + c});
      }
      LATTICED_RETURN_IF_ERROR(poll_.Step(result_.pieces.size() - pieces_before));
      if (result_.pieces.size() > limits::kMaxPatches) {
        return error::WithDetails(
            absl::ResourceExhaustedError(fmt::format(
                "the plan has more than the {} patches that are allowed", limits::kMaxPatches)),
            {.reason = "LIMIT_EXCEEDED",
             .metadata = {{"limit", fmt::to_string(limits::kMaxPatches)}}});
      }
    }
    return std::move(result_);
  }

 private:
  absl::Status Triangulate(size_t face, const std::vector<Vec3d>& polygon,
                           std::vector<std::array<uint32_t, 3>>* triangles) const {
    absl::Status status = TriangulatePolygon(polygon, triangles, stop_);
    if (!absl::IsInvalidArgument(status)) return status;
    return error::InvalidField("mesh", fmt::format("face {} has {} corners, and {}", face,
                                                   polygon.size(), std::string(status.message())));
  }

  absl::Status AddMeshVertices() {
    absl::flat_hash_map<VertexKey, uint32_t> ids;
    ids.reserve(mesh_.positions.size());
    vertex_of_position_.reserve(mesh_.positions.size());
    for (size_t v = 0; v < mesh_.positions.size(); ++v) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      const Vec3d world = mesh_.positions[v];
      const double weight = weights_.empty() ? 1.0 : weights_[v];
      const auto [it, added] =
          ids.try_emplace(KeyOf(world, weight), static_cast<uint32_t>(result_.vertices.size()));
      if (added) AddVertex(world, weight, [&](size_t k) { return lattices_[k].Place(world); });
      vertex_of_position_.push_back(it->second);
    }
    return absl::OkStatus();
  }

  // place(k): where the vertex is in lattice k.
  template <typename Place>
  void AddVertex(Vec3d world, double weight, const Place& place) {
    for (size_t k = 1; k < lattices_.size(); ++k) result_.turned[k - 1].push_back(place(k));
    result_.vertices.push_back({world, place(0), weight});
  }

  void SplitTriangle(uint32_t face, std::array<uint32_t, 3> corners) {
    Polygon polygon;
    for (size_t c = 0; c < 3; ++c) {
      PolygonVertex vertex{vertex_of_position_[mesh_.corner_vertices[corners[c]]], {}};
      vertex.barycentric[c] = 1.0;
      polygon.push_back(vertex);
    }
    // With two corners at one position the triangle has no area, and two of its sides coincide: it is left out.
    if (polygon[0].id == polygon[1].id || polygon[1].id == polygon[2].id ||
        polygon[2].id == polygon[0].id) {
      return;
    }
    result_.triangles.push_back({face, corners});
    CutFromAxis(std::move(polygon), 0);
  }

  // Cuts at all planes of `axis`, ascending, then at those of the later axes. Axes 3 k to 3 k + 2 are those of lattice k.
  void CutFromAxis(Polygon polygon, int axis) {
    if (axis == 3 * static_cast<int>(lattices_.size())) return Emit(polygon);
    double low = Coordinate(polygon[0], axis), high = low;
    for (const PolygonVertex& v : polygon) {
      low = std::min(low, Coordinate(v, axis));
      high = std::max(high, Coordinate(v, axis));
    }
    const auto& planes = PlanesOf(axis);
    for (auto plane = std::upper_bound(planes.begin(), planes.end(), low);
         plane != planes.end() && *plane < high; ++plane) {
      Polygon below, above;
      Cut(polygon, axis, static_cast<uint32_t>(plane - planes.begin()), &below, &above);
      CutFromAxis(std::move(below), axis + 1);
      polygon = std::move(above);
    }
    CutFromAxis(std::move(polygon), axis + 1);
  }

  void Cut(const Polygon& polygon, int axis, uint32_t plane, Polygon* below, Polygon* above) {
    const double knot = PlanesOf(axis)[plane];
    for (size_t i = 0; i < polygon.size(); ++i) {
      const PolygonVertex& from = polygon[i];
      const PolygonVertex& to = polygon[i + 1 == polygon.size() ? 0 : i + 1];
      const double a = Coordinate(from, axis), b = Coordinate(to, axis);
      if (a <= knot) below->push_back(from);
      if (a >= knot) above->push_back(from);
      if ((a < knot && knot < b) || (b < knot && knot < a)) {
        const PolygonVertex cut = CutEdge(from, to, axis, plane);
        below->push_back(cut);
        above->push_back(cut);
      }
    }
  }

  PolygonVertex CutEdge(const PolygonVertex& from, const PolygonVertex& to, int axis,
                        uint32_t plane) {
    const bool forward = IsBefore(from.id, to.id);
    const PolygonVertex& a = forward ? from : to;
    const PolygonVertex& b = forward ? to : from;
    const SplitVertex va = result_.vertices[a.id], vb = result_.vertices[b.id];
    const double from_a = Coordinate(a, axis), knot = PlanesOf(axis)[plane];
    const double t = (knot - from_a) / (Coordinate(b, axis) - from_a);
    PolygonVertex cut;
    for (size_t c = 0; c < 3; ++c) {
      cut.barycentric[c] = a.barycentric[c] + t * (b.barycentric[c] - a.barycentric[c]);
    }
    static_assert(3 * limits::kMaxLattices < 32, "an axis takes 5 bits of a key");
    const uint64_t key = (uint64_t{b.id} << 32) | (plane << 5) | static_cast<uint32_t>(axis);
    const auto [id, added] =
        cuts_.TryEmplace(a.id, key, static_cast<uint32_t>(result_.vertices.size()));
    if (added) {
      const double weight = std::clamp(va.weight + t * (vb.weight - va.weight), 0.0, 1.0);
      AddVertex(va.world + t * (vb.world - va.world), weight, [&](size_t k) {
        const Vec3d at_a = Parameter(a.id, k);
        Vec3d parameter = at_a + t * (Parameter(b.id, k) - at_a);
        if (k == LatticeOf(axis)) parameter[axis % 3] = knot;
        return lattices_[k].Snap(parameter);
      });
    }
    cut.id = id;
    return cut;
  }

  void Emit(const Polygon& polygon) {
    std::vector<Vec3d>& points = emit_points_;
    points.clear();
    for (const PolygonVertex& v : polygon) points.push_back(result_.vertices[v.id].world);
    TriangulateConvex(points, [&](size_t a, size_t b, size_t c) {
      const PolygonVertex &va = polygon[a], &vb = polygon[b], &vc = polygon[c];
      result_.pieces.push_back({{va.id, vb.id, vc.id},
                                {va.barycentric, vb.barycentric, vc.barycentric},
                                static_cast<uint32_t>(result_.triangles.size()) - 1});
    });
  }

  static size_t LatticeOf(int axis) { return static_cast<size_t>(axis) / 3; }
  const std::vector<double>& PlanesOf(int axis) const {
    return lattices_[LatticeOf(axis)].along(axis % 3);
  }
  Vec3d Parameter(uint32_t vertex, size_t lattice) const {
    return lattice == 0 ? result_.vertices[vertex].parameter : result_.turned[lattice - 1][vertex];
  }
  double Coordinate(const PolygonVertex& v, int axis) const {
    return Parameter(v.id, LatticeOf(axis))[axis % 3];
  }
  // Canonical order of an edge's end points. Distinct cut points can round to one position; then their ids decide,
  // which both sides share as well.
  bool IsBefore(uint32_t a, uint32_t b) const {
    return std::pair(result_.vertices[a].world, a) < std::pair(result_.vertices[b].world, b);
  }

  const PolygonMesh& mesh_;
  const std::span<const float> weights_;
  std::vector<SplitPlanes> lattices_;  // the first one, then the turned ones
  std::vector<uint32_t> vertex_of_position_;
  AdjacencyIndex cuts_;  // vertex: the first end; key: the other end and the plane
  std::vector<Vec3d> emit_points_;
  const StopCheck stop_;
  StopPoll poll_;
  SplitMesh result_;
};

}  // namespace

absl::StatusOr<SplitMesh> SplitAtKnots(const PolygonMesh& mesh, const LatticeStructure& structure,
                                       StopCheck stop, std::span<const float> weights,
                                       std::span<const LatticeStructure> turned) {
  return Splitter(mesh, structure, stop, weights, turned).Run();
}

}  // namespace latticed
