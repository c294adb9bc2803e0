// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Times commands of OpenGL by the device's clock (GL_TIME_ELAPSED). Before each run the L2 cache is
// flushed and the device idle.
//
// Errors   kResourceExhausted, kInternal
// Threads  only the context's thread
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_DRAWING_TIME_COMMANDS_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_DRAWING_TIME_COMMANDS_H_

#include <functional>

#include "absl/status/statusor.h"
#include "tests/bench/gpu/gpu.h"

namespace latticed::bench {

[[nodiscard]] absl::StatusOr<GpuTimes> TimeCommands(int runs,
                                                    const std::function<void()>& commands);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_DRAWING_TIME_COMMANDS_H_
