// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scenarios of benchmarks: a mesh under a jittered lattice, its plan, and two sets of control
// points. Benchmarks alternate between the sets, so every frame has work to do.
//
// Units    the torus has radii 1 and 0.4; jitter is a fraction of a knot box
// Threads  scenarios are immutable. MakeView keeps one backend per number of threads
#ifndef LATTICED_TESTS_BENCH_SCENARIO_H_
#define LATTICED_TESTS_BENCH_SCENARIO_H_

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/backend.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/plan/quantisation_box.h"

namespace latticed::bench {

struct Scenario {
  std::string name;
  std::shared_ptr<const DeformPlan> plan;
  std::array<std::vector<Vec3d>, 2> control_points;
  QuantisationBox box;               // holds both sets
  std::vector<uint32_t> all_chunks;  // 0 … chunk_count - 1
  size_t points(int segments) const;
};

// A torus of `around` x `across` quads.
[[nodiscard]] std::shared_ptr<const PolygonMesh> MakeTorus(int around, int across);

// Vertex weights from 0 to 1 that change smoothly.
[[nodiscard]] VertexWeights WavesOfWeights(const PolygonMesh& mesh);

// Fits a lattice of `size` and `degree`; control points move by up to 0.3 knot boxes. Errors end
// the program, because a benchmark without its scenario means nothing.
[[nodiscard]] Scenario MakeScenario(std::string name, std::shared_ptr<const PolygonMesh> mesh,
                                    std::array<int, 3> size, std::array<int, 3> degree);

// Under two lattices of 5 x 5 x 5 knot boxes and degree 2, the second one turned by half a radian about z, both beyond the mesh.
[[nodiscard]] Scenario MakeTurnedScenario(std::string name,
                                          std::shared_ptr<const PolygonMesh> mesh);

// The same for an existing plan; the control points of turned lattices move too.
[[nodiscard]] Scenario MakeScenario(std::string name, std::shared_ptr<const DeformPlan> plan);

// About as many patches as the paper's smallest and largest models (17,119 and 113,663, to within
// 1 %), on 5 x 5 x 5 knot boxes. Made once.
[[nodiscard]] const Scenario& SmallScenario(int degree);
[[nodiscard]] const Scenario& LargeScenario();

// A view of the scenario on the CPU backend, all chunks evaluated once with control_points[0].
[[nodiscard]] std::unique_ptr<DeformView> MakeView(const Scenario& scenario, Pipeline pipeline,
                                                   const ViewSpec& spec, int threads);

// Returns the chunk's bytes in wire layout.
[[nodiscard]] std::vector<uint8_t> ReadChunk(const Scenario& scenario, DeformView& view,
                                             uint32_t chunk);

// Ends the program with `status` if it is not OK.
void CheckOk(const absl::Status& status);

// Returns the value of `made`. Ends the program if it is an error.
template <class T>
[[nodiscard]] T Checked(absl::StatusOr<T> made) {
  CheckOk(made.status());
  return *std::move(made);
}

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_SCENARIO_H_
