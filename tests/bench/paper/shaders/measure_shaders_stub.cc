// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/measure_shaders.h"

namespace latticed::bench {

absl::StatusOr<ShaderTimes> MeasureShaders(const Scenario& /*scenario*/,
                                           std::span<const NetPoint> /*nets*/,
                                           ShaderDevice /*device*/, int /*runs*/) {
  return absl::UnimplementedError("built without libepoxy");
}

absl::StatusOr<DrawingTimes> MeasureDrawing(const Scenario& /*scenario*/, DeformView& /*view*/,
                                            ShaderDevice /*device*/, int /*runs*/) {
  return absl::UnimplementedError("built without libepoxy");
}

}  // namespace latticed::bench
