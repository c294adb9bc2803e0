// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/verify.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "tests/support/definition.h"
#include "tests/support/pipeline_name.h"

namespace latticed::bench {

absl::Status Verify(const Scenario& scenario, Pipeline pipeline, DeformView& view) {
  const ViewSpec& spec = view.spec();
  const size_t stride = std::max<size_t>(1, scenario.all_chunks.size() / 64);
  std::vector<uint32_t> patches;
  std::vector<testing::ViewPoint> points;
  for (size_t chunk = 0; chunk < scenario.all_chunks.size(); chunk += stride) {
    const std::vector<uint8_t> bytes = ReadChunk(scenario, view, static_cast<uint32_t>(chunk));
    std::ranges::copy(testing::DecodePoints(*scenario.plan, spec, scenario.box, bytes),
                      std::back_inserter(points));
    const auto [first, last] = scenario.plan->ChunkPatches(chunk);
    for (size_t p = first; p < last; ++p) patches.push_back(static_cast<uint32_t>(p));
  }
  const testing::Definition definition(*scenario.plan, scenario.control_points[0], spec.segments,
                                       spec.normals, std::move(patches));
  const absl::Status status =
      definition.Check(pipeline, points, testing::RoundingOf(spec, scenario.box));
  if (status.ok()) return status;
  return absl::InternalError(fmt::format("{} {}: {}", scenario.name, PipelineName(pipeline),
                                         std::string(status.message())));
}

}  // namespace latticed::bench
