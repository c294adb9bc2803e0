// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Copies a few KB from pinned memory by loads of a kernel. For 12 KB this takes 5 microseconds, and
// a copy engine 7 to 10 (H200, by events).
//
// Threads  calls enqueue and do not wait; the memory must stay until the stream has passed them
#ifndef LATTICED_CUDA_DEVICE_UPLOAD_KERNEL_H_
#define LATTICED_CUDA_DEVICE_UPLOAD_KERNEL_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "cuda/device/kernel_call.h"

namespace latticed::kernels {

// Copies `bytes` > 0, rounded up to kUploadUnit. Both buffers hold the rounded size and are aligned
// to kUploadUnit. `pinned` is host memory that the device can read.
inline constexpr size_t kUploadUnit = 16;
KernelCall UploadCall(const void* pinned, size_t bytes, void* to);

// Copies the named pages of the first `paged_bytes`, each to the same offset, and everything from
// there up to `bytes`. Page k begins at k * kUploadPage. At most kMostUploadPages are named.
inline constexpr size_t kUploadPage = 768, kMostUploadPages = 256;
struct PagedUpload {
  std::span<const uint16_t> pages;
  size_t paged_bytes;  // a multiple of kUploadUnit
  size_t bytes;
};
KernelCall UploadCall(const void* pinned, const PagedUpload& upload, void* to);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DEVICE_UPLOAD_KERNEL_H_
