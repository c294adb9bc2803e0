// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/turns.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

namespace latticed::bench {
namespace {

double TurnTime(const Turn& turn, size_t frame) {
  const auto begin = std::chrono::steady_clock::now();
  turn.run(frame);
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
      .count();
}

}  // namespace

void TakeTurns(benchmark::State& state, const Turn& one, const Turn& other) {
  double least_one = std::numeric_limits<double>::infinity(), least_other = least_one;
  size_t frame = 0;
  for (auto _ : state) {
    ++frame;
    least_one = std::min(least_one, TurnTime(one, frame));
    least_other = std::min(least_other, TurnTime(other, frame));
  }
  state.counters[one.name + "_ms"] = least_one;
  state.counters[other.name + "_ms"] = least_other;
  state.counters["ratio"] = least_one / least_other;
}

void RegisterTurns(const std::string& name, std::function<void(benchmark::State&)> body) {
  benchmark::RegisterBenchmark(name.c_str(), std::move(body))
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->MinTime(1);
}

}  // namespace latticed::bench
