// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the current device can do at most, measured: bandwidths on 1 GiB (256 MiB to and from the
// host), float32 multiply-adds on registers. Less than a second.
//
// Errors   end the program
// Threads  one
#ifndef LATTICED_TESTS_BENCH_GPU_GPU_FLOORS_H_
#define LATTICED_TESTS_BENCH_GPU_GPU_FLOORS_H_

#include "tests/bench/gpu/gpu_timer.h"

namespace latticed::bench {

[[nodiscard]] GpuFloors MeasureGpuFloors(GpuTimer& timer, cudaStream_t stream);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_GPU_GPU_FLOORS_H_
