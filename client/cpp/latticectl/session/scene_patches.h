// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Points and triangles of a view with ENCODING_PATCHES, which this program evaluates by itself. Their distance from the
// exact surface is at most --tolerance, rounding of the points included.
//
// Errors   those of the server; kInvalidArgument for a tolerance that the points cannot meet
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SCENE_PATCHES_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SCENE_PATCHES_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/patches/patch_evaluator.h"
#include "client/cpp/library/patches/pattern_layouts.h"

namespace latticed::client {

class ScenePatches {
 public:
  // `tolerance`: world units, above 0.
  ScenePatches(Client& client, std::string scene, double tolerance)
      : client_(client), scene_(std::move(scene)), tolerance_(tolerance) {}

  // Evaluates the newest complete update of the surface. Fetches the plan of a topology that it does not have.
  [[nodiscard]] absl::Status Evaluate(const Surface& surface);

  // These belong to the last Evaluate.
  const PatchSurface& points() const { return points_; }
  double certified_error() const { return certified_error_; }
  // In world units. Taken out of this object.
  [[nodiscard]] DecodedPoints TakePoints();
  // Refer to this object.
  [[nodiscard]] std::vector<PatchLayout> Layouts() { return layouts_.Of(points_.patterns); }

 private:
  absl::Status Prepare(const Surface& surface, const LatticeStructure& structure);

  Client& client_;
  const std::string scene_;
  const double tolerance_;
  std::string topology_id_;
  v1::NormalMode normals_ = v1::NORMAL_MODE_UNSPECIFIED;
  std::optional<PatchEvaluator> evaluator_;
  PatchSurface points_;
  double certified_error_ = 0;
  PatternLayouts layouts_;
};

// kInvalidArgument where a command needs the points of a view with ENCODING_PATCHES, and no tolerance was given.
[[nodiscard]] absl::Status CheckToleranceOfPatches(const v1::ViewOptions& view, bool has_tolerance);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SCENE_PATCHES_H_
