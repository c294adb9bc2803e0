// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes the streams of a view's chunks on its device, in batches. Brings vertices to wire
// order first, if the kernel keeps another order. Twin of core/view/view_encoder.h.
//
// Errors   those of device_writer.h
// Threads  one at a time; works on the lane and waits for it before it returns
#ifndef LATTICED_CUDA_VIEW_DEVICE_VIEW_ENCODER_H_
#define LATTICED_CUDA_VIEW_DEVICE_VIEW_ENCODER_H_

#include <memory>
#include <span>
#include <utility>

#include "core/view/view_encoder.h"
#include "cuda/view/cuda_vertex_kernel.h"
#include "cuda/view/device_writer.h"

namespace latticed {

class DeviceViewEncoder {
 public:
  // Keeps references to `plan` and to `host`, which supplies the connectivity of meshes.
  DeviceViewEncoder(const DeformPlan& plan, const ViewSpec& spec,
                    std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
                    ViewEncoder& host)
      : plan_(plan),
        spec_(spec),
        context_(std::move(context)),
        lane_(std::move(lane)),
        host_(host),
        writer_(context_, lane_) {}

  // As DeformView::Encode, for `vertices` of `kernel`. `range`: that of the quantisation box.
  [[nodiscard]] absl::Status Encode(CudaVertexKernel& kernel, DeviceSpan<const uint8_t> vertices,
                                    std::span<const uint32_t> chunks, Encoding encoding,
                                    double range, std::span<VertexDigest> digests,
                                    std::span<SharedBytes> results, TakeEarly early);

  size_t DeviceBytes() const { return writer_.DeviceBytes(); }
  size_t PinnedBytes() const { return writer_.PinnedBytes(); }

 private:
  // The arguments of one call.
  struct Source {
    DeviceStreamWriter& writer;
    CudaVertexKernel& kernel;
    DeviceSpan<const uint8_t> vertices;
    double range;
  };
  DracoShape ShapeFor(Encoding encoding) const;
  [[nodiscard]] absl::Status EncodeBatch(const Source& source, std::span<const uint32_t> chunks,
                                         std::span<VertexDigest> digests,
                                         std::span<SharedBytes> results, TakeEarly early);

  const DeformPlan& plan_;
  const ViewSpec spec_;
  std::shared_ptr<CudaContext> context_;
  std::shared_ptr<CudaLane> lane_;
  ViewEncoder& host_;
  DeviceWriter writer_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_VIEW_DEVICE_VIEW_ENCODER_H_
