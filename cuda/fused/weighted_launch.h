// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The kernel of meshes with weights, as the .cc files see it. It takes the place of FusedCall.
//
// Errors   cudaError_t of the launch; those of kernel_call.h
// Threads  no call waits; all pointers must stay valid until the stream has run the kernel
#ifndef LATTICED_CUDA_FUSED_WEIGHTED_LAUNCH_H_
#define LATTICED_CUDA_FUSED_WEIGHTED_LAUNCH_H_

#include "cuda/fused/fused_kernels.h"
#include "cuda/plan/weight_tables.h"

namespace latticed::kernels {

// The blocks are not read.
struct WeightedLaunch {
  FusedLaunch fused;
  WeightTables weights;
};
// Runs after the polynomials of all boxes that own points of the chunks. There is at least one chunk. Returns
// a call of no kernel for degrees that no plan has.
KernelCall WeightedCall(const WeightedLaunch& launch);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_WEIGHTED_LAUNCH_H_
