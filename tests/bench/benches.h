// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The groups of benchmarks; each registers its own with Google Benchmark. Names are paths, read
// again by summary.cc:  evaluate/<scenario>/<pipeline>/degree<d>/<output>/<normals>/<threads>t
#ifndef LATTICED_TESTS_BENCH_BENCHES_H_
#define LATTICED_TESTS_BENCH_BENCHES_H_

#include <functional>
#include <string>

#include <benchmark/benchmark.h>

namespace latticed::bench {

void RegisterEvaluateBenches();   // control points to vertices
void RegisterFloorBenches();      // streaming stores, the blocked product alone
void RegisterPlanBenches();       // mesh and lattice to plan
void RegisterCodecBenches();      // vertices to Draco bytes
void RegisterDeliveryBenches();   // chunks to a client's memory, through gRPC
void RegisterEngineBenches();     // edits to whole updates, stages in turn and overlapped
void RegisterPrecisionBenches();  // errors against the definition, as counters

// Five repetitions, medians, real time in milliseconds.
void RegisterTimed(const std::string& name, std::function<void(benchmark::State&)> body);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_BENCHES_H_
