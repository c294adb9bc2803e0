// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measured limits of the current device: bandwidths on 1 GiB (256 MiB to and from the host), and
// float32 multiply-adds on registers. Takes less than a second.
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
