// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The groups of benchmarks; each registers its own with Google Benchmark. Names are paths, read
// again by summary.cc:  evaluate/<scenario>/<pipeline>/degree<d>/<output>/<normals>/<threads>t
//                       gpu/<model>/<pipeline>/<nu>x<nv>x<nw>/<output>/<normals>/<s>segments
//                       where <model> on several devices ends with -on-<devices>
#ifndef LATTICED_TESTS_BENCH_BENCHES_H_
#define LATTICED_TESTS_BENCH_BENCHES_H_

#include <functional>
#include <string>

#include <benchmark/benchmark.h>

#include "absl/status/status.h"
#include "tests/bench/gpu/gpu.h"

namespace latticed::bench {

void RegisterEvaluateBenches();   // control points to vertices
void RegisterFloorBenches();      // streaming stores, the blocked product alone
void RegisterPlanBenches();       // mesh and lattice to plan
void RegisterCodecBenches();      // vertices to Draco bytes, and how many of them
void RegisterCpuEncodeBenches();  // edits to Draco bytes
void RegisterDeliveryBenches();   // chunks to a client's memory, through gRPC
void RegisterEngineBenches();     // edits to whole updates, stages in turn and overlapped
void RegisterFairnessBenches();   // a small scene's updates beside a huge one's

// Control points to vertices on the GPU; one line on stderr where there is none. `large`: 10^7
// patches too, half a minute and 20 GB.
void RegisterGpuBenches(bool large);
// These three are called by the former.
void RegisterGpuEditBenches();
void RegisterGpuEncodeBenches();
// One scene on one device, two and four; words on stderr for those that the machine has not.
void RegisterGpuDevicesBenches(bool large);

// Five repetitions, medians, real time in milliseconds.
void RegisterTimed(const std::string& name, std::function<void(benchmark::State&)> body);

// The body is called once and times its runs itself: it calls SetTime or Skip.
void RegisterOnce(const std::string& name, std::function<void(benchmark::State&)> body);
void SetTime(benchmark::State& state, GpuTimes times);
// kUnimplemented is told as "not built" and is no failure; anything else is.
void Skip(benchmark::State& state, const absl::Status& status);
// What this machine lacks is no failure either.
void SkipNotHere(benchmark::State& state, const absl::Status& why);
inline constexpr char kNotBuilt[] = "not built";
inline constexpr char kNotHere[] = "not here";
inline constexpr char kLeast[] = "least_ms";  // counter that summary.cc shows as the least time

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_BENCHES_H_
