// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Kernels that only measure: each enqueues one and returns its launch error.
#ifndef LATTICED_TESTS_BENCH_GPU_GPU_KERNELS_H_
#define LATTICED_TESTS_BENCH_GPU_GPU_KERNELS_H_

#include <cuda_runtime_api.h>

#include <cstddef>

namespace latticed::bench {

// `count` times 16 bytes, written and not read.
cudaError_t LaunchFill(float4* to, size_t count, float value, cudaStream_t stream);

// kMultiplyAddsPerThread in each of `blocks` x kMultiplyAddThreads threads; `out` has as many
// floats.
inline constexpr int kMultiplyAddThreads = 256;
inline constexpr int kMultiplyAddRounds = 2'048;
inline constexpr int kMultiplyAddChains = 16;
inline constexpr double kMultiplyAddsPerThread = double{kMultiplyAddRounds} * kMultiplyAddChains;
cudaError_t LaunchMultiplyAdds(int blocks, float factor, float* out, cudaStream_t stream);

// Holds the stream until *flag, in pinned host memory, is `ticket` or more; 20 ms at most, so that
// a host that waits for the stream meanwhile is not stuck.
cudaError_t LaunchGate(const unsigned* flag, unsigned ticket, cudaStream_t stream);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_GPU_GPU_KERNELS_H_
