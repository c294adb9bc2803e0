// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the surface of a stream with the definition in double precision: EvaluatePoints at the same
// surface points. Nobody may edit the scene meanwhile.
//
//   |decoded - definition| <= step / 2 + 1e-6 * D   per coordinate; D = diagonal of all control points
//
// Patches on the lattice's faces are not compared: the surface may be torn there.
//
// Errors   kDataLoss for a point beyond this bound; kAborted if somebody edited the scene; the server's
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
  double worst = 0;  // the largest deviation, divided by the bound
};

class SurfaceVerifier {
 public:
  SurfaceVerifier(Client* client, std::string scene) : client_(client), scene_(std::move(scene)) {}

  // Checks a few chunks of a surface at the scene's newest revision. `offset` selects which.
  [[nodiscard]] absl::Status Check(const Surface& surface, size_t offset, VerifiedPoints* verified);

 private:
  // Adds points of a chunk to `positions`, and their places in the source mesh to `request`.
  absl::Status Sample(const Surface& surface, size_t chunk, v1::EvaluatePointsRequest* request,
                      std::vector<Vec3d>* positions) const;
  // `point` is an index into the pattern's points.
  v1::SurfacePoint SurfacePointOf(const PatchLayout& layout, uint64_t patch, size_t point) const;

  Client* const client_;
  const std::string scene_;
  v1::TopologyPart provenance_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_SURFACE_VERIFIER_H_
