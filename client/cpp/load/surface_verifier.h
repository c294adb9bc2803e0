// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares what a stream has brought with the definition in double, which EvaluatePoints answers
// for the same surface points at the same revision. Nobody may edit the scene meanwhile.
//
//   position  |decoded - definition| <= step / 2 + precision * D      by coordinate
//   normal    angle <= cell + 2e-5 * kappa     facet normals of the fused pipeline, kappa <= 100
//
//   precision = 3e-7 for the fused pipeline, 1e-6 for the others
//   D = diagonal of all control points; cell = half a cell's diagonal on the octahedral map, which
//   the map stretches by up to 2; kappa = |cof J|_F |N| / |cof(J) N|, an upper bound of the condition
//
// Patches on the lattice's faces are left out, since the surface may be torn there.
//
// Errors   kDataLoss for a point that is elsewhere, kAborted when somebody edits; the server's
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_
#define LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "client/cpp/latticed_client.h"
#include "client/cpp/load/verified_points.h"

namespace latticed::client {

class SurfaceVerifier {
 public:
  // `fused`: evaluated by the fused pipeline.
  SurfaceVerifier(Client* client, std::string scene, bool fused)
      : client_(client), scene_(std::move(scene)), fused_(fused) {}

  // Looks at a few chunks; others for another `offset`.
  [[nodiscard]] absl::Status Check(const Surface& surface, size_t offset);
  const VerifiedPoints& result() const { return result_; }

 private:
  // Points of a surface and where the stream says they are.
  struct Sample {
    v1::EvaluatePointsRequest request;
    DecodedPoints points;
  };
  absl::StatusOr<Sample> TakeSample(const Surface& surface, size_t offset) const;
  absl::Status AddChunk(const Surface& surface, size_t chunk, Sample* sample) const;
  // `point` counts in the pattern.
  v1::SurfacePoint SurfacePointOf(const Surface& surface, uint64_t patch, size_t point) const;
  absl::Status ComparePositions(const Surface& surface, const Sample& sample,
                                const v1::EvaluatePointsResponse& definition);
  absl::Status CompareNormals(const Surface& surface, const Sample& sample,
                              const v1::EvaluatePointsResponse& definition);

  Client* const client_;
  const std::string scene_;
  const bool fused_;
  v1::TopologyPart provenance_;
  VerifiedPoints result_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_
