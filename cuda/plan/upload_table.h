// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A table of a plan, brought to the device and counted as the plan's.
//
// Errors   those of device_buffer.h
// Threads  enqueues on the context's stream
#ifndef LATTICED_CUDA_PLAN_UPLOAD_TABLE_H_
#define LATTICED_CUDA_PLAN_UPLOAD_TABLE_H_

#include <span>
#include <type_traits>
#include <utility>

#include "absl/status/status.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/device_buffer.h"

namespace latticed {

template <typename T>
[[nodiscard]] absl::Status UploadTable(CudaContext& context,
                                       std::span<const std::type_identity_t<T>> from,
                                       DeviceBuffer<T>& to) {
  auto buffer = DeviceBuffer<T>::Upload(context.memory(), "plan", from, context.stream().get());
  if (!buffer.ok()) return buffer.status();
  to = *std::move(buffer);
  return absl::OkStatus();
}

}  // namespace latticed

#endif  // LATTICED_CUDA_PLAN_UPLOAD_TABLE_H_
