// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/upload_kernel.h"

#include "cuda/device/dependent_launch.cuh"
#include "cuda/device/launch.cuh"

namespace latticed::kernels {
namespace {

struct Arguments {
  const uint4* pinned;
  size_t count;
  uint4* to;
};

__global__ void __launch_bounds__(kBlockThreads)
    UploadKernel(const __grid_constant__ Arguments arguments) {
  LetNextKernelBegin();
  const size_t i = Item();
  if (i < arguments.count) arguments.to[i] = arguments.pinned[i];
}

}  // namespace

KernelCall UploadCall(const void* pinned, size_t bytes, void* to) {
  static_assert(sizeof(uint4) == kUploadUnit);
  const size_t count = (bytes + kUploadUnit - 1) / kUploadUnit;
  return {UploadKernel,
          Order::kAfter,
          Blocks(count),
          kBlockThreads,
          0,
          Arguments{static_cast<const uint4*>(pinned), count, static_cast<uint4*>(to)}};
}

}  // namespace latticed::kernels
