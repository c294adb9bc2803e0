// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes for views with a tolerance or of edge bounds, and what a watcher of a view with a tolerance has.
#ifndef LATTICED_TESTS_BACKEND_TOLERANCE_TOLERANCE_SCENES_H_
#define LATTICED_TESTS_BACKEND_TOLERANCE_TOLERANCE_SCENES_H_

#include <string_view>
#include <vector>

#include "tests/backend/conformance.h"

namespace latticed::testing {

inline constexpr uint32_t kToleranceSeed = 2014;

struct ToleranceScene {
  std::string_view name;
  PolygonMesh mesh;
  LatticeOptions options;
};
// Many boxes, faces of the frame, repeated knots, pieces that nothing connects, and cubic degrees.
[[nodiscard]] std::vector<ToleranceScene> ToleranceScenes();

// The vertices of each chunk in wire layout, and the patterns that came with them.
struct Watched {
  std::vector<std::vector<uint8_t>> chunks;
  std::vector<std::vector<uint16_t>> patterns;

  explicit Watched(const DeformPlan& plan)
      : chunks(plan.chunk_count()), patterns(plan.chunk_count()) {}
  // The view has been evaluated.
  void Take(const DeformPlan& plan, DeformView& view, uint32_t chunk);
  void TakeAll(const DeformPlan& plan, DeformView& view);
  std::vector<uint16_t> Codes() const;
  friend bool operator==(const Watched&, const Watched&) = default;
};

// Of a whole evaluation: the pattern of each patch, and its points.
struct WholeSurface {
  std::vector<uint16_t> codes;
  std::vector<ViewPoint> points;
};
// Evaluates all chunks and fills `whole`; a fatal failure if the view does not evaluate.
void EvaluateWhole(const DeformPlan& plan, DeformView& view,
                   const std::vector<Vec3d>& control_points, const QuantisationBox& box,
                   WholeSurface& whole);

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_BACKEND_TOLERANCE_TOLERANCE_SCENES_H_
