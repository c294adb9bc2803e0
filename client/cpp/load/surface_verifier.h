// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the surface of a stream with the definition in double: EvaluatePoints at the same surface
// points. Nobody else may edit the scene meanwhile.
//
//   |decoded - definition| <= step / 2 + 1e-6 * D   by coordinate; D = diagonal of all control points
//
// Not compared: patches on the lattice's faces, where the surface may be torn.
//
// Errors   kDataLoss for a point that is elsewhere, kAborted when somebody else edits; the server's
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_
#define LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/cpp/library/latticed_client.h"

namespace latticed::client {

struct VerifiedPoints {
  uint64_t surfaces = 0, points = 0;
  double worst = 0;  // share of what is allowed
};

class SurfaceVerifier {
 public:
  SurfaceVerifier(Client* client, std::string scene) : client_(client), scene_(std::move(scene)) {}

  // Checks a few chunks of a surface at the scene's newest revision. `offset` selects which.
  [[nodiscard]] absl::Status Check(const Surface& surface, size_t offset, VerifiedPoints* verified);

 private:
  // Adds points of a chunk, and their places in the source mesh.
  absl::Status Sample(const Surface& surface, size_t chunk, v1::EvaluatePointsRequest* request,
                      std::vector<Vec3d>* positions) const;
  // `point` counts in the pattern.
  v1::SurfacePoint SurfacePointOf(const Surface& surface, uint64_t patch, size_t point) const;

  Client* const client_;
  const std::string scene_;
  v1::TopologyPart provenance_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_
