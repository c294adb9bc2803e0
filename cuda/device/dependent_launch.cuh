// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Programmatic dependent launch: a kernel begins while the kernel before it on the stream still runs, and
// waits for that kernel's results only where it needs them. Below compute capability 9.0 the kernels run
// one after the other.
#ifndef LATTICED_CUDA_DEVICE_DEPENDENT_LAUNCH_CUH_
#define LATTICED_CUDA_DEVICE_DEPENDENT_LAUNCH_CUH_

#include <cuda_runtime.h>
#include <nv/target>

namespace latticed::kernels {

// Called in the first kernel, by all its blocks, after WaitForKernelBefore. The second kernel may then begin
// and read what earlier kernels wrote, because these are done. What the first kernel writes it may read
// only after its own WaitForKernelBefore.
__device__ __forceinline__ void LetNextKernelBegin() {
  NV_IF_TARGET(NV_PROVIDES_SM_90, (asm volatile("griddepcontrol.launch_dependents;");))
}

// Called in the second kernel: returns when all that the first kernel wrote can be read.
__device__ __forceinline__ void WaitForKernelBefore() {
  NV_IF_TARGET(NV_PROVIDES_SM_90, (asm volatile("griddepcontrol.wait;" ::: "memory");))
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DEVICE_DEPENDENT_LAUNCH_CUH_
