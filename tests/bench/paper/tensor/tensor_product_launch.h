// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The two kernels of the tensor-product comparator: each enqueues one and returns its launch error.
#ifndef LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_PRODUCT_LAUNCH_H_
#define LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_PRODUCT_LAUNCH_H_

#include <cuda_runtime_api.h>

#include "tests/bench/paper/tensor/tensor_product.h"

namespace latticed::bench {

cudaError_t LaunchTensorControl(const TensorJob& job, cudaStream_t stream);
// most_lines: of a group, which the host cannot read in the job.
cudaError_t LaunchTensorTessellation(const TensorJob& job, size_t most_lines, cudaStream_t stream);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_TENSOR_TENSOR_PRODUCT_LAUNCH_H_
