// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernel of bezier_net.h: enqueues it and returns its launch error.
#ifndef LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NET_LAUNCH_H_
#define LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NET_LAUNCH_H_

#include <cuda_runtime_api.h>

#include "tests/bench/paper/bezier_net/bezier_net.h"

namespace latticed::bench {

// m is that of job.tables, which the host cannot read.
cudaError_t LaunchBezierNets(const NetJob& job, int m, cudaStream_t stream);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_BEZIER_NET_BEZIER_NET_LAUNCH_H_
