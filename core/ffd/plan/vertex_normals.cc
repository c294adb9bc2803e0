// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/ffd/plan/vertex_normals.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <tuple>

#include "absl/container/flat_hash_map.h"
#include "core/base/status_macros.h"

namespace latticed {
namespace {

// Degrees by which an angle may exceed the crease angle: rounded positions of a regular shape must not split at random.
constexpr double kAngleTolerance = 0.01;
constexpr size_t kComparedFaces = 3;  // with each face at an edge, at most

// Newell's area vector: exact for planar polygons of any shape, sensible for others. It is computed relative to the
// first corner, so that distance from the origin costs no digits.
Vec3d AreaVector(const PolygonMesh& mesh, size_t face) {
  const uint32_t begin = mesh.face_offsets[face], end = mesh.face_offsets[face + 1];
  const Vec3d origin = mesh.positions[mesh.corner_vertices[begin]];
  Vec3d sum;
  for (uint32_t c = begin + 1; c + 1 < end; ++c) {
    sum += Cross(mesh.positions[mesh.corner_vertices[c]] - origin,
                 mesh.positions[mesh.corner_vertices[c + 1]] - origin);
  }
  return sum;
}

Vec3f UnitFloat(Vec3d n) { return ToFloat(n / Norm(n)); }

// A corner of the mesh, and the face it belongs to.
struct FaceCorner {
  uint32_t corner = 0, face = 0;
};

class CornerNormals {
 public:
  CornerNormals(const PolygonMesh& mesh, std::optional<double> crease_angle, StopCheck stop)
      : mesh_(mesh), keeps_given_(!crease_angle.has_value() && mesh.has_normals()), poll_(stop) {
    const double angle =
        std::min(180., crease_angle.value_or(kDefaultCreaseAngle) + kAngleTolerance);
    // Rounding must not make two opposite faces meet at more than 180 degrees.
    least_cosine_ = std::cos(angle * std::numbers::pi / 180) - 1e-12;
  }

  absl::StatusOr<std::vector<Vec3f>> Compute() {
    LATTICED_RETURN_IF_ERROR(GatherCorners());
    normals_.resize(mesh_.corner_count());
    for (size_t place = 0; place + 1 < place_offsets_.size(); ++place) {
      const std::span corners(corners_.data() + place_offsets_[place],
                              corners_.data() + place_offsets_[place + 1]);
      LATTICED_RETURN_IF_ERROR(poll_.Step(corners.size()));
      GroupAround(corners);
      SetNormals(corners);
    }
    return std::move(normals_);
  }

 private:
  // A place is a position; vertices at equal positions share it. Sorts the corners by place, then by face.
  absl::Status GatherCorners() {
    vertex_places_.resize(mesh_.positions.size());
    absl::flat_hash_map<std::tuple<double, double, double>, uint32_t> places;
    places.reserve(mesh_.positions.size());
    for (size_t v = 0; v < mesh_.positions.size(); ++v) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      const Vec3d p = mesh_.positions[v];  // -0 and 0 are one place
      const auto next = static_cast<uint32_t>(places.size());
      vertex_places_[v] = places.try_emplace({p.x + 0.0, p.y + 0.0, p.z + 0.0}, next).first->second;
    }
    place_offsets_.assign(places.size() + 1, 0);
    for (const uint32_t v : mesh_.corner_vertices) ++place_offsets_[vertex_places_[v]];
    std::exclusive_scan(place_offsets_.begin(), place_offsets_.end(), place_offsets_.begin(), 0u);
    std::vector<uint32_t> ends(place_offsets_.begin(), place_offsets_.end() - 1);
    corners_.resize(mesh_.corner_count());
    areas_.resize(mesh_.face_count());
    for (uint32_t f = 0; f < mesh_.face_count(); ++f) {
      LATTICED_RETURN_IF_ERROR(poll_.Step());
      areas_[f] = AreaVector(mesh_, f);
      for (uint32_t c = mesh_.face_offsets[f]; c < mesh_.face_offsets[f + 1]; ++c) {
        corners_[ends[PlaceOf(c)]++] = {c, f};
      }
    }
    return absl::OkStatus();
  }

  // Puts into `groups_`, for each corner around a place, a corner that stands for all of its group.
  void GroupAround(std::span<const FaceCorner> corners) {
    groups_.resize(corners.size());
    std::iota(groups_.begin(), groups_.end(), 0u);
    spokes_.clear();
    for (uint32_t k = 0; k < corners.size(); ++k) {
      const auto [corner, face] = corners[k];
      if (k > 0 && corners[k - 1].face == face) Unite(k - 1, k);  // a face that repeats a position
      const uint32_t begin = mesh_.face_offsets[face], end = mesh_.face_offsets[face + 1];
      for (const uint32_t neighbour :
           {corner > begin ? corner - 1 : end - 1, corner + 1 < end ? corner + 1 : begin}) {
        if (PlaceOf(neighbour) != PlaceOf(corner)) spokes_.push_back({PlaceOf(neighbour), k});
      }
    }
    std::sort(spokes_.begin(), spokes_.end());
    for (size_t a = 0; a < spokes_.size(); ++a) {
      for (size_t b = a + 1; b < spokes_.size() && b <= a + kComparedFaces; ++b) {
        const auto [place, i] = spokes_[a];
        const auto [other_place, j] = spokes_[b];
        if (place != other_place) break;
        if (IsSmooth(areas_[corners[i].face], areas_[corners[j].face])) Unite(i, j);
      }
    }
  }

  void SetNormals(std::span<const FaceCorner> corners) {
    sums_.assign(corners.size(), {});
    for (uint32_t k = 0; k < corners.size(); ++k) sums_[GroupOf(k)] += areas_[corners[k].face];
    for (uint32_t k = 0; k < corners.size(); ++k) {
      const auto [corner, face] = corners[k];
      const Vec3d given = GivenNormal(corner), sum = sums_[GroupOf(k)];
      if (Norm(given) > 0) {
        normals_[corner] = UnitFloat(given);
      } else if (Norm(sum) > 0) {
        normals_[corner] = UnitFloat(sum);
      } else if (Norm(areas_[face]) > 0) {
        normals_[corner] = UnitFloat(areas_[face]);
      } else {
        normals_[corner] = {0, 0, 1};
      }
    }
  }

  Vec3d GivenNormal(uint32_t corner) const {
    if (!keeps_given_ || mesh_.corner_normals[corner] == PolygonMesh::kNoAttribute) return {};
    return ToDouble(mesh_.normals[mesh_.corner_normals[corner]]);
  }

  uint32_t PlaceOf(uint32_t corner) const { return vertex_places_[mesh_.corner_vertices[corner]]; }

  bool IsSmooth(Vec3d a, Vec3d b) const {
    const double lengths = Norm(a) * Norm(b);
    return lengths > 0 && Dot(a, b) >= least_cosine_ * lengths;
  }

  uint32_t GroupOf(uint32_t k) {
    while (groups_[k] != k) k = groups_[k] = groups_[groups_[k]];
    return k;
  }

  void Unite(uint32_t a, uint32_t b) { groups_[GroupOf(b)] = GroupOf(a); }

  const PolygonMesh& mesh_;
  const bool keeps_given_;
  StopPoll poll_;
  double least_cosine_ = 0;
  std::vector<uint32_t> vertex_places_;
  std::vector<uint32_t> place_offsets_;  // places + 1
  std::vector<FaceCorner> corners_;      // those of place p begin at place_offsets_[p]
  std::vector<Vec3d> areas_;             // per face
  std::vector<Vec3f> normals_;
  // Around one place: a forest of corners, the ends of their edges with the corner's number, sums by group.
  std::vector<uint32_t> groups_;
  std::vector<std::pair<uint32_t, uint32_t>> spokes_;
  std::vector<Vec3d> sums_;
};

}  // namespace

absl::StatusOr<std::vector<Vec3f>> UnitCornerNormals(const PolygonMesh& mesh,
                                                     std::optional<double> crease_angle,
                                                     StopCheck stop) {
  return CornerNormals(mesh, crease_angle, stop).Compute();
}

}  // namespace latticed
