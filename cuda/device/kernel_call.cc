// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/kernel_call.h"

namespace latticed::kernels {
namespace {

// The dynamic shared memory that a kernel may use without asking.
constexpr size_t kPlainSharedBytes = size_t{48} << 10;
// The compute capability that introduced programmatic dependent launches.
constexpr int kDependentMajor = 9;

cudaError_t DeviceKnowsDependentLaunches(bool& knows) {
  int device = 0, major = 0;
  if (const auto e = cudaGetDevice(&device); e != cudaSuccess) return e;
  const auto e = cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device);
  knows = major >= kDependentMajor;
  return e;
}

}  // namespace

cudaError_t KernelCall::CountBlocksAtOnce(int& blocks) const {
  if (const auto e = AllowSharedMemory(); e != cudaSuccess) return e;
  return cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, kernel_, static_cast<int>(threads_),
                                                       shared_bytes_);
}

cudaError_t KernelCall::AllowSharedMemory() const {
  if (kernel_ == nullptr) return cudaErrorInvalidValue;
  if (shared_bytes_ <= kPlainSharedBytes) return cudaSuccess;
  return cudaFuncSetAttribute(kernel_, cudaFuncAttributeMaxDynamicSharedMemorySize,
                              static_cast<int>(shared_bytes_));
}

cudaError_t KernelCall::Launch(cudaStream_t stream) {
  if (const auto e = AllowSharedMemory(); e != cudaSuccess) return e;
  bool dependent = false;
  if (order_ == Order::kDependent) {
    if (const auto e = DeviceKnowsDependentLaunches(dependent); e != cudaSuccess) return e;
  }
  cudaLaunchAttribute overlap{};
  overlap.id = cudaLaunchAttributeProgrammaticStreamSerialization;
  overlap.val.programmaticStreamSerializationAllowed = 1;
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(blocks_);
  config.blockDim = dim3(threads_);
  config.dynamicSmemBytes = shared_bytes_;
  config.stream = stream;
  config.attrs = &overlap;
  config.numAttrs = dependent ? 1 : 0;
  void* arguments[1] = {argument_.data()};
  return cudaLaunchKernelExC(&config, kernel_, arguments);
}

cudaError_t KernelCall::Replace(cudaGraphExec_t graph, cudaGraphNode_t node) {
  if (const auto e = AllowSharedMemory(); e != cudaSuccess) return e;
  void* arguments[1] = {argument_.data()};
  cudaKernelNodeParams params{};
  params.func = const_cast<void*>(kernel_);
  params.gridDim = dim3(blocks_);
  params.blockDim = dim3(threads_);
  params.sharedMemBytes = static_cast<unsigned>(shared_bytes_);
  params.kernelParams = arguments;
  return cudaGraphExecKernelNodeSetParams(graph, node, &params);
}

}  // namespace latticed::kernels
