// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A kernel launch as data. It is launched at once, or becomes part of a graph
// (launch_graph.h).
//
// Errors   cudaError_t of the launch; cudaErrorInvalidValue for a call of no kernel
// Threads  plain data; Launch enqueues
#ifndef LATTICED_CUDA_DEVICE_KERNEL_CALL_H_
#define LATTICED_CUDA_DEVICE_KERNEL_CALL_H_

#include <cuda_runtime_api.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <type_traits>

namespace latticed::kernels {

// Whether a kernel waits for all of the one before, or may begin meanwhile: then it calls
// WaitForKernelBefore (dependent_launch.cuh) before it touches what that one writes.
enum class Order { kAfter, kDependent };

class KernelCall {
 public:
  KernelCall() = default;  // of no kernel
  // A kernel of one argument, which is copied.
  template <class Argument>
  KernelCall(void (*kernel)(Argument), Order order, unsigned blocks, unsigned threads,
             size_t shared_bytes, const Argument& argument)
      : kernel_(reinterpret_cast<const void*>(kernel)),
        order_(order),
        blocks_(blocks),
        threads_(threads),
        shared_bytes_(shared_bytes) {
    static_assert(std::is_trivially_copyable_v<Argument> && sizeof(Argument) <= kMostBytes &&
                  alignof(Argument) <= alignof(std::max_align_t));
    std::memcpy(argument_.data(), &argument, sizeof(argument));
  }

  const void* kernel() const { return kernel_; }

  // The number of its blocks that a multiprocessor of the current device holds at once.
  cudaError_t CountBlocksAtOnce(int& blocks) const;
  // Allows the kernel the shared memory that it asks for, where that is more than any may have.
  // To be called before it is launched or made part of a graph.
  cudaError_t AllowSharedMemory() const;
  cudaError_t Launch(cudaStream_t stream);
  // Replaces the call that `node` of the graph was made from. Both have the same kernel.
  cudaError_t Replace(cudaGraphExec_t graph, cudaGraphNode_t node);

 private:
  static constexpr size_t kMostBytes = 1024;

  const void* kernel_ = nullptr;
  Order order_ = Order::kAfter;
  unsigned blocks_ = 0, threads_ = 0;
  size_t shared_bytes_ = 0;
  alignas(std::max_align_t) std::array<std::byte, kMostBytes> argument_{};
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DEVICE_KERNEL_CALL_H_
