// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/backend/tolerance/tolerance_scenes.h"

namespace latticed::testing {

std::vector<ToleranceScene> ToleranceScenes() {
  return {
      {"many boxes", TorusMesh(14, 10), {.degree = {1, 1, 1}, .extra = {6, 6, 6}}},
      {"partly outside", TorusMesh(7, 5), {.degree = {2, 1, 3}, .scale = 0.7}},
      {"repeated knots",
       TorusMesh(6, 5),
       {.degree = {3, 2, 1}, .extra = {3, 3, 3}, .knots = KnotKind::kRepeated}},
      {"aligned, half outside",
       CubeMesh(4),
       {.degree = {1, 2, 1}, .extra = {1, 1, 1}, .scale = 1.0, .shift = {0.5, 0, 0}}},
      {"unconnected, slivers",
       TriangleSoup(40, kToleranceSeed),
       {.degree = {1, 1, 2}, .extra = {4, 4, 4}}},
      {"cubic", TorusMesh(9, 7), {.degree = {3, 3, 3}, .extra = {1, 1, 1}}},
  };
}

void Watched::Take(const DeformPlan& plan, DeformView& view, uint32_t chunk) {
  const auto codes = view.Patterns().OfChunk(chunk);
  patterns[chunk].assign(codes.begin(), codes.end());
  chunks[chunk].resize(ChunkPoints(view, plan, chunk) * BytesPerPoint(view.spec()));
  EXPECT_OK(view.Read(chunk, chunks[chunk]));
}

void Watched::TakeAll(const DeformPlan& plan, DeformView& view) {
  for (uint32_t c = 0; c < chunks.size(); ++c) Take(plan, view, c);
}

std::vector<uint16_t> Watched::Codes() const {
  std::vector<uint16_t> all;
  for (const auto& some : patterns) all.insert(all.end(), some.begin(), some.end());
  return all;
}

void EvaluateWhole(const DeformPlan& plan, DeformView& view,
                   const std::vector<Vec3d>& control_points, const QuantisationBox& box,
                   WholeSurface& whole) {
  ASSERT_OK(view.Evaluate(control_points, box, AllChunks(plan)));
  Watched watched(plan);
  watched.TakeAll(plan, view);
  whole = {watched.Codes(), Decode(plan, view.spec(), box, watched.chunks)};
}

}  // namespace latticed::testing
