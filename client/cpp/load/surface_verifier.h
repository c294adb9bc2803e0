// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the surface of a stream with the definition in double: EvaluatePoints at the same
// surface points and the same control points. For a past revision the scene is given that
// revision's control points again. Nobody else may edit the scene meanwhile.
//
//   position  |decoded - definition| <= step / 2 + precision * D      by coordinate
//   normal    angle <= cell + 2e-5 * kappa     of the fused pipeline, kappa <= 100
//
//   precision = 3e-7 for the fused pipeline, 1e-6 for the others
//   D = diagonal of all control points; cell = half a cell's diagonal on the octahedral map, which
//   the map stretches by up to 2; kappa = |cof J|_F |N| / |cof(J) N|, an upper bound of the condition
//
// Smooth normals are cof(J) N / |…| with J of EvaluatePoints and N interpolated from the normals at
// the mesh's corners; kappa is divided by |N| then: a short N is less certain.
//
// Not compared: patches on the lattice's faces, where the surface may be torn; and normals at
// patches' edges in volumes of degree 1, which may be bent there.
//
// Errors   kDataLoss for a point that is elsewhere, kAborted when somebody else edits; the server's
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_
#define LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/cpp/latticectl/files.h"
#include "client/cpp/library/latticed_client.h"
#include "core/ffd/carried_normal.h"

namespace latticed::client {

// How many updates were compared with the definition, at how many points, and how far off the worst
// of these was.
struct VerifiedPoints {
  uint64_t updates = 0, positions = 0, normals = 0;
  double worst_position = 0, worst_normal = 0;  // share of what is allowed

  void Add(const VerifiedPoints& other) {
    updates += other.updates;
    positions += other.positions;
    normals += other.normals;
    worst_position = std::max(worst_position, other.worst_position);
    worst_normal = std::max(worst_normal, other.worst_normal);
  }
};

class SurfaceVerifier {
 public:
  // The scene was made from `mesh`. `fused`: it is evaluated by the fused pipeline.
  SurfaceVerifier(Client* client, std::string scene, std::shared_ptr<const MeshFile> mesh,
                  bool fused)
      : client_(client), scene_(std::move(scene)), mesh_(std::move(mesh)), fused_(fused) {}

  // Checks a few chunks of a surface at the scene's newest revision. `offset` selects which.
  [[nodiscard]] absl::Status Check(const Surface& surface, size_t offset);
  // Checks `chunks` of a surface at any revision, whose control points were these. The scene keeps
  // these control points.
  [[nodiscard]] absl::Status CheckPast(const Surface& surface, std::span<const uint32_t> chunks,
                                       std::span<const Vec3d> control_points);
  const VerifiedPoints& result() const { return result_; }

 private:
  // Points of a surface, and their places by the stream.
  struct Sample {
    v1::EvaluatePointsRequest request;
    DecodedPoints points;
    std::vector<bool> at_patch_edge;
  };
  // The state of the scene that a surface must agree with.
  struct Truth {
    uint64_t revision = 0;  // of the scene
    double diagonal = 0;    // of its control points
  };
  // Fetches the lattice, the topology and the mesh's normals, where they are not there yet.
  absl::Status Prepare(const Surface& surface);
  absl::Status Compare(const Surface& surface, std::span<const uint32_t> chunks,
                       const Truth& truth);
  absl::Status PutBack(std::span<const Vec3d> control_points);
  absl::StatusOr<Sample> TakeSample(const Surface& surface, std::span<const uint32_t> chunks) const;
  absl::Status AddChunk(const Surface& surface, size_t chunk, Sample* sample) const;
  // `point` counts in the pattern.
  v1::SurfacePoint SurfacePointOf(const Surface& surface, uint64_t patch, size_t point) const;
  // The normal of the sample's point `i` by the definition. An infinite kappa: it is undefined.
  CarriedNormal NormalOf(const Surface& surface, const Sample& sample,
                         const v1::EvaluatePointsResponse& definition, size_t i) const;
  absl::Status ComparePositions(const Surface& surface, const Sample& sample,
                                const v1::EvaluatePointsResponse& definition, double diagonal);
  absl::Status CompareNormals(const Surface& surface, const Sample& sample,
                              const v1::EvaluatePointsResponse& definition);

  Client* const client_;
  const std::string scene_;
  const std::shared_ptr<const MeshFile> mesh_;
  const bool fused_;
  v1::TopologyPart provenance_;
  v1::LatticeState lattice_;           // with degree and structure; read once
  std::vector<Vec3f> corner_normals_;  // of the mesh; only for smooth normals
  std::optional<uint64_t> past_;       // the revision whose control points the scene has
  v1::EditResult put_back_;            // of the edit that gave it these
  const std::string editor_id_ = RandomEditorId();
  VerifiedPoints result_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_
