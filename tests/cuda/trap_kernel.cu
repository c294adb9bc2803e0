// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/cuda/trap_kernel.h"

namespace latticed::testing {
namespace {

__global__ void TrapKernel() { __trap(); }

}  // namespace

void TrapDevice() {
  TrapKernel<<<1, 1>>>();
  static_cast<void>(cudaDeviceSynchronize());
}

}  // namespace latticed::testing
