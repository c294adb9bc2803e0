// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A kernel launch as data. It is launched by itself, or becomes part of a graph (launch_graph.h).
//
// Errors   cudaError_t of the launch; cudaErrorInvalidValue where the call has no kernel
// Threads  plain data; Launch enqueues and does not wait
#ifndef LATTICED_CUDA_DEVICE_KERNEL_CALL_H_
#define LATTICED_CUDA_DEVICE_KERNEL_CALL_H_

#include <cuda_runtime_api.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <type_traits>

namespace latticed::kernels {

// kAfter: the kernel starts when its predecessor is complete. kDependent: it may start earlier, and
// calls WaitForKernelBefore (dependent_launch.cuh) before it touches what the predecessor writes.
enum class Order { kAfter, kDependent };

class KernelCall {
 public:
  KernelCall() = default;  // has no kernel
  // `kernel` has one argument, of which the call keeps a copy.
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

  // The number of blocks of this call that a multiprocessor of the current device holds at once.
  cudaError_t CountBlocksAtOnce(int& blocks) const;
  // Raises the kernel's limit of shared memory where the call exceeds the default one. Must precede
  // a launch or the use in a graph.
  cudaError_t AllowSharedMemory() const;
  cudaError_t Launch(cudaStream_t stream);
  // Puts this call in place of the one that `node` was made from. Both have the same kernel.
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
