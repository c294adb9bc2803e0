// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The groups of benchmarks. Each registers its own with Google Benchmark. report/targets.cc looks
// benchmarks up by name:
//   evaluate/<scenario>/<pipeline>/degree<d>/<output>/<normals>/<s>segments/<threads>t
//   gpu/<model>/<pipeline>/<nu>x<nv>x<nw>/<output>/<normals>/<s>segments
//   where <model> on several devices ends with -on-<devices>
#ifndef LATTICED_TESTS_BENCH_BENCHES_H_
#define LATTICED_TESTS_BENCH_BENCHES_H_

#include <functional>
#include <string>

#include <benchmark/benchmark.h>

#include "absl/status/status.h"
#include "tests/bench/gpu/gpu.h"

namespace latticed::bench {

void RegisterEvaluateBenches();   // control points to vertices
void RegisterFloorBenches();      // streaming stores; product (25) alone
void RegisterPlanBenches();       // from mesh and lattice to plan
void RegisterWeightsBenches();    // with vertex weights, and without, by turns
void RegisterOutsideBenches();    // a lattice that goes on outside its frame, and one that does not
void RegisterSumBenches();        // several lattices on one mesh, and one
void RegisterTurnedBenches();     // two lattices turned against each other, and one
void RegisterFoldsBenches();      // from control points to a report of folds
void RegisterMeasureBenches();    // volume, centroid, area, the kept volume
void RegisterCodecBenches();      // from vertices to Draco bytes, and their number
void RegisterDecodeBenches();     // from Draco bytes to integers
void RegisterMeshoptBenches();    // from vertices to meshopt bytes, and back
void RegisterPatchesBenches();    // what a client does with an edit: patches against Draco
void RegisterPointsBenches();     // points of the world: deformed, and derivatives
void RegisterCpuEncodeBenches();  // from an edit to Draco bytes
void RegisterDeliveryBenches();   // chunks to a client's memory, through gRPC
void RegisterEngineBenches();     // from an edit to a complete update, in process
void RegisterFairnessBenches();   // latency of a small scene beside a huge one

// From control points to vertices on the GPU. Without a GPU it prints one line on stderr. `large`
// adds 10^7 patches, which take half a minute and 20 GB.
void RegisterGpuBenches(bool large);
// RegisterGpuBenches calls these three.
void RegisterGpuEditBenches();
void RegisterGpuToleranceBenches();
void RegisterGpuEncodeBenches();
// One scene on one, two and four devices. Reports counts that the machine lacks on stderr.
void RegisterGpuDevicesBenches(bool large);

// Five repetitions; reports the median of real time, in milliseconds.
void RegisterTimed(const std::string& name, std::function<void(benchmark::State&)> body);

// Adds counter ns_point: the time of an iteration, in ns, divided by its `points`.
void CountPoints(benchmark::State& state, size_t points);

// Calls the body once. The body times its own runs and then calls SetTime or Skip.
void RegisterOnce(const std::string& name, std::function<void(benchmark::State&)> body);
void SetTime(benchmark::State& state, GpuTimes times);
// kUnimplemented is reported as "not built" and is no failure. Any other error is a failure.
void Skip(benchmark::State& state, const absl::Status& status);
// Reports what this machine lacks as "not here", which is no failure either.
void SkipNotHere(benchmark::State& state, const absl::Status& why);
inline constexpr char kNotBuilt[] = "not built";
inline constexpr char kNotHere[] = "not here";
inline constexpr char kLeast[] = "least_ms";  // counter that summary.cc shows as the least time

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_BENCHES_H_
