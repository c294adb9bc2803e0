// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/view/device_writer.h"

#include <utility>

#include "core/base/status_macros.h"
#include "core/codec/draco_writer.h"
#include "cuda/meshopt/meshopt_coder.h"

namespace latticed {

bool HasDeviceWriter(Encoding encoding, const CudaContext& context) {
  if (encoding == Encoding::kMeshopt) return true;
  return IsDraco(encoding) && context.encoder()->name() == kDracoWriterName;
}

absl::StatusOr<DeviceStreamWriter*> DeviceWriter::For(Encoding encoding,
                                                      absl::FunctionRef<DracoShape()> shape) {
  if (writer_.has_value() && encoding_ == encoding) return &*writer_;
  std::unique_ptr<StreamCoder> coder;
  if (encoding == Encoding::kMeshopt) {
    coder = std::make_unique<MeshoptCoder>(shape().normal_bits);
  } else {
    LATTICED_ASSIGN_OR_RETURN(coder, DracoCoder::Create(shape(), *context_, lane_->stream().get()));
  }
  LATTICED_ASSIGN_OR_RETURN(writer_, DeviceStreamWriter::Create(std::move(coder), context_, lane_));
  encoding_ = encoding;
  return &*writer_;
}

}  // namespace latticed
