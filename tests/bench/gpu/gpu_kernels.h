// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Kernels that only measure: each enqueues one and returns its launch error.
#ifndef LATTICED_TESTS_BENCH_GPU_GPU_KERNELS_H_
#define LATTICED_TESTS_BENCH_GPU_GPU_KERNELS_H_

#include <cuda_runtime_api.h>

#include <cstddef>

namespace latticed::bench {

// Writes `count` times 16 bytes and reads nothing.
cudaError_t LaunchFill(float4* to, size_t count, float value, cudaStream_t stream);

// Runs kMultiplyAddsPerThread in each of `blocks` x kMultiplyAddThreads threads. `out` holds one
// float per thread.
inline constexpr int kMultiplyAddThreads = 256;
inline constexpr int kMultiplyAddRounds = 2'048;
inline constexpr int kMultiplyAddChains = 16;
inline constexpr double kMultiplyAddsPerThread = double{kMultiplyAddRounds} * kMultiplyAddChains;
cudaError_t LaunchMultiplyAdds(int blocks, float factor, float* out, cudaStream_t stream);

// Holds the stream until *flag, in pinned host memory, is at least `ticket`. It gives up after
// 20 ms, so a host that waits for the stream meanwhile does not hang.
cudaError_t LaunchGate(const unsigned* flag, unsigned ticket, cudaStream_t stream);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_GPU_GPU_KERNELS_H_
