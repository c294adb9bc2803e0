// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares what a stream has brought with the definition in double, which EvaluatePoints answers
// for the same surface points at the same control points: those of the stream's revision, which for
// a past one the scene is given again. Nobody else may edit it meanwhile.
//
//   position  |decoded - definition| <= step / 2 + precision * D      by coordinate
//   normal    angle <= cell + 2e-5 * kappa     of the fused pipeline, kappa <= 100
//
//   precision = 3e-7 for the fused pipeline, 1e-6 for the others
//   D = diagonal of all control points; cell = half a cell's diagonal on the octahedral map, which
//   the map stretches by up to 2; kappa = |cof J|_F |N| / |cof(J) N|, an upper bound of the condition
//
// Smooth normals are cof(J) N / |…| with J of EvaluatePoints and N interpolated from the normals at
// the mesh's corners; kappa is over |N| then, the shorter the less certain.
//
// Patches on the lattice's faces are left out, since the surface may be torn there, and of volumes
// of degree 1 the normals at patches' edges, which may lie where the volume is bent.
//
// Errors   kDataLoss for a point that is elsewhere, kAborted when somebody edits; the server's
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_
#define LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_

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
#include "client/cpp/load/verified_points.h"
#include "core/ffd/carried_normal.h"

namespace latticed::client {

class SurfaceVerifier {
 public:
  // `mesh`: that the scene was made from. `fused`: evaluated by the fused pipeline.
  SurfaceVerifier(Client* client, std::string scene, std::shared_ptr<const MeshFile> mesh,
                  bool fused)
      : client_(client), scene_(std::move(scene)), mesh_(std::move(mesh)), fused_(fused) {}

  // Of the scene's newest revision: looks at a few chunks, at others for another `offset`.
  [[nodiscard]] absl::Status Check(const Surface& surface, size_t offset);
  // Of any, at which the control points were these: looks at `chunks`. The scene has them from here
  // on.
  [[nodiscard]] absl::Status CheckPast(const Surface& surface, std::span<const uint32_t> chunks,
                                       std::span<const Vec3d> control_points);
  const VerifiedPoints& result() const { return result_; }

 private:
  // Points of a surface and where the stream says they are.
  struct Sample {
    v1::EvaluatePointsRequest request;
    DecodedPoints points;
    std::vector<bool> at_patch_edge;
  };
  // What the scene must be evaluated at for a surface to be right.
  struct Truth {
    uint64_t revision = 0;  // of the scene
    double diagonal = 0;    // of its control points
  };
  // Fetches what the other functions know of the scene and the mesh.
  absl::Status Prepare(const Surface& surface);
  absl::Status Compare(const Surface& surface, std::span<const uint32_t> chunks,
                       const Truth& truth);
  absl::Status PutBack(std::span<const Vec3d> control_points);
  absl::StatusOr<Sample> TakeSample(const Surface& surface, std::span<const uint32_t> chunks) const;
  absl::Status AddChunk(const Surface& surface, size_t chunk, Sample* sample) const;
  // `point` counts in the pattern.
  v1::SurfacePoint SurfacePointOf(const Surface& surface, uint64_t patch, size_t point) const;
  // Of the sample's point `i`, by the definition; kappa infinite where nothing can be said.
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
  std::vector<Vec3f> corner_normals_;  // of the mesh, where a view has smooth normals
  std::optional<uint64_t> past_;       // the revision whose control points the scene has
  v1::EditResult put_back_;            // of the edit that gave it these
  const std::string editor_id_ = RandomEditorId();
  VerifiedPoints result_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_
