// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_TESTS_SUPPORT_PIPELINE_NAME_H_
#define LATTICED_TESTS_SUPPORT_PIPELINE_NAME_H_

#include <array>
#include <string_view>

#include "core/backend.h"

namespace latticed {

// For the names of tests and benchmarks.
inline std::string_view PipelineName(Pipeline pipeline) {
  constexpr std::array<std::string_view, 4> kNames = {"fused", "gemm", "gemm12", "control-net"};
  return kNames[static_cast<size_t>(pipeline)];
}

}  // namespace latticed

#endif  // LATTICED_TESTS_SUPPORT_PIPELINE_NAME_H_
