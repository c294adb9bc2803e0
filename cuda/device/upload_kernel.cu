// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/upload_kernel.h"

#include <algorithm>

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

constexpr uint32_t kPageUnits = kUploadPage / kUploadUnit;
static_assert(kUploadPage % kUploadUnit == 0);

// Numbers are units of kUploadUnit bytes. The list of pages is an argument, so that the copy need
// not wait for it.
struct PagedArguments {
  const uint4* pinned;
  uint4* to;
  uint32_t page_count, paged, all;
  uint16_t pages[kMostUploadPages];
};

__global__ void __launch_bounds__(kBlockThreads)
    UploadPagesKernel(const __grid_constant__ PagedArguments arguments) {
  LetNextKernelBegin();
  const auto i = static_cast<uint32_t>(Item());
  const uint32_t in_pages = arguments.page_count * kPageUnits;
  uint32_t unit = arguments.paged + i - in_pages;
  uint32_t end = arguments.all;
  if (i < in_pages) {
    unit = arguments.pages[i / kPageUnits] * kPageUnits + i % kPageUnits;
    end = arguments.paged;  // the last page may be cut off
  }
  if (unit < end) arguments.to[unit] = arguments.pinned[unit];
}

}  // namespace

KernelCall UploadCall(const void* pinned, const PagedUpload& upload, void* to) {
  if (upload.pages.size() > kMostUploadPages) return {};
  PagedArguments arguments{
      .pinned = static_cast<const uint4*>(pinned),
      .to = static_cast<uint4*>(to),
      .page_count = static_cast<uint32_t>(upload.pages.size()),
      .paged = static_cast<uint32_t>(upload.paged_bytes / kUploadUnit),
      .all = static_cast<uint32_t>((upload.bytes + kUploadUnit - 1) / kUploadUnit),
      .pages = {}};
  std::copy(upload.pages.begin(), upload.pages.end(), arguments.pages);
  const size_t count = size_t{arguments.page_count} * kPageUnits + arguments.all - arguments.paged;
  return {UploadPagesKernel, Order::kAfter, Blocks(count), kBlockThreads, 0, arguments};
}

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
