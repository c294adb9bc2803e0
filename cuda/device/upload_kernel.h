// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A few KB from pinned memory by a kernel's own loads over the bus: 12 KB take 5 microseconds by
// events, and 7 to 10 by the copy engine (H200).
//
// Threads  does not wait; the memory must stay until the stream has passed
#ifndef LATTICED_CUDA_DEVICE_UPLOAD_KERNEL_H_
#define LATTICED_CUDA_DEVICE_UPLOAD_KERNEL_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "cuda/device/kernel_call.h"

namespace latticed::kernels {

// Copies `bytes`, more than none, rounded up to kUploadUnit, which both sides have room for and are
// aligned to. `pinned` is host memory that the device can read.
inline constexpr size_t kUploadUnit = 16;
KernelCall UploadCall(const void* pinned, size_t bytes, void* to);

// Copies some pages of the first `paged_bytes`, each to its own place, and everything after them up
// to `bytes`. Pages begin at multiples of kUploadPage; kMostUploadPages at most are named.
inline constexpr size_t kUploadPage = 768, kMostUploadPages = 256;
struct PagedUpload {
  std::span<const uint16_t> pages;
  size_t paged_bytes;  // a multiple of kUploadUnit
  size_t bytes;
};
KernelCall UploadCall(const void* pinned, const PagedUpload& upload, void* to);

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_DEVICE_UPLOAD_KERNEL_H_
