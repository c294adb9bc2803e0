// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/drawing/time_commands.h"

#include <chrono>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "tests/bench/paper/shaders/gl_context.h"
#include "tests/bench/paper/shaders/gl_objects.h"

namespace latticed::bench {
namespace {

constexpr size_t kFlushBytes = size_t{256} << 20;  // as in gpu_timer.cc
constexpr double kWarmUpMs = 30;
constexpr double kMsPerNs = 1e-6;

}  // namespace

absl::StatusOr<GpuTimes> TimeCommands(int runs, const std::function<void()>& commands) {
  using Clock = std::chrono::steady_clock;
  LATTICED_ASSIGN_OR_RETURN(const auto flushed, GlBuffer::Create(kFlushBytes, nullptr));
  const GlQuery elapsed(GL_TIME_ELAPSED);
  for (const auto start = Clock::now();
       std::chrono::duration<double, std::milli>(Clock::now() - start).count() < kWarmUpMs;) {
    commands();
    glFinish();
  }
  std::vector<double> times;
  for (int run = 0; run < runs; ++run) {
    const auto value = static_cast<GLuint>(run);
    glClearNamedBufferData(flushed.id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &value);
    glFinish();
    times.push_back(static_cast<double>(elapsed.Count(commands)) * kMsPerNs);
  }
  LATTICED_RETURN_IF_ERROR(GlStatus("the timed commands"));
  return MedianAndLeast(std::move(times));
}

}  // namespace latticed::bench
