// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the times of two things that take turns, so that a drift of the machine touches both.
#ifndef LATTICED_TESTS_BENCH_TURNS_H_
#define LATTICED_TESTS_BENCH_TURNS_H_

#include <functional>
#include <string>

#include <benchmark/benchmark.h>

namespace latticed::bench {

struct Turn {
  std::string name;
  std::function<void(size_t frame)> run;
};

// An iteration runs both. Counters: <name>_ms, the least time of each, and ratio, that of `one` by that of `other`.
void TakeTurns(benchmark::State& state, const Turn& one, const Turn& other);

// Registers a body that takes turns, for at least a second: the least time needs many turns on a busy machine.
void RegisterTurns(const std::string& name, std::function<void(benchmark::State&)> body);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_TURNS_H_
