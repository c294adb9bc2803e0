// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The writer of a view's streams on its device, made for one encoding after the other.
//
// Errors   those of the coder and of device_stream_writer.h
// Threads  one at a time
#ifndef LATTICED_CUDA_VIEW_DEVICE_WRITER_H_
#define LATTICED_CUDA_VIEW_DEVICE_WRITER_H_

#include <memory>
#include <optional>

#include "absl/functional/function_ref.h"
#include "core/backend.h"
#include "cuda/draco/draco_coder.h"
#include "cuda/streams/device_stream_writer.h"

namespace latticed {

// Whether the device writes the same bytes as the host: of Draco, if the context's encoder is our own writer.
[[nodiscard]] bool HasDeviceWriter(Encoding encoding, const CudaContext& context);

class DeviceWriter {
 public:
  DeviceWriter(std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane)
      : context_(std::move(context)), lane_(std::move(lane)) {}

  // The writer for `encoding`. Calls shape() if it makes one.
  [[nodiscard]] absl::StatusOr<DeviceStreamWriter*> For(Encoding encoding,
                                                        absl::FunctionRef<DracoShape()> shape);

  size_t DeviceBytes() const { return writer_.has_value() ? writer_->DeviceBytes() : 0; }
  size_t PinnedBytes() const { return writer_.has_value() ? writer_->PinnedBytes() : 0; }

 private:
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
  std::optional<DeviceStreamWriter> writer_;  // for encoding_
  Encoding encoding_ = Encoding::kDracoPoints;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_VIEW_DEVICE_WRITER_H_
