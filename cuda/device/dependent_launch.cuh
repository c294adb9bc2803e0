// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A kernel that begins while the one before it on the stream still runs, and waits for that one's
// results where it needs them: from compute capability 9.0 on, elsewhere one after the other.
#ifndef LATTICED_CUDA_DEVICE_DEPENDENT_LAUNCH_CUH_
#define LATTICED_CUDA_DEVICE_DEPENDENT_LAUNCH_CUH_

#include <cuda_runtime.h>
#include <nv/target>

namespace latticed::kernels {

// In the first kernel, by all its blocks, after its own wait: the next one may begin, and read what
// the kernels before this one wrote, for these are done. What this one writes only after its wait.
__device__ __forceinline__ void LetNextKernelBegin() {
  NV_IF_TARGET(NV_PROVIDES_SM_90, (asm volatile("griddepcontrol.launch_dependents;");))
}

// In the second kernel: all that the first one wrote is there.
__device__ __forceinline__ void WaitForKernelBefore() {
  NV_IF_TARGET(NV_PROVIDES_SM_90, (asm volatile("griddepcontrol.wait;" ::: "memory");))
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DEVICE_DEPENDENT_LAUNCH_CUH_
