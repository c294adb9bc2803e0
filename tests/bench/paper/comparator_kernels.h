// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernels of tensor_product.h and bezier_net.h. Each call enqueues one and returns its launch error.
#ifndef LATTICED_TESTS_BENCH_PAPER_COMPARATOR_KERNELS_H_
#define LATTICED_TESTS_BENCH_PAPER_COMPARATOR_KERNELS_H_

#include <cuda_runtime_api.h>

#include "tests/bench/paper/bezier_net/bezier_net.h"
#include "tests/bench/paper/tensor/tensor_product.h"

namespace latticed::bench {

// `m` equals job.tables->m, which is in device memory.
cudaError_t LaunchBezierNets(const NetJob& job, int m, cudaStream_t stream);

cudaError_t LaunchTensorControl(const TensorJob& job, cudaStream_t stream);
// `most_lines` is the largest number of lines of a group. The job has it in device memory only.
cudaError_t LaunchTensorTessellation(const TensorJob& job, size_t most_lines, cudaStream_t stream);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_COMPARATOR_KERNELS_H_
