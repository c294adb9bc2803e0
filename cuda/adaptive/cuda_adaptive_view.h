// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view with a tolerance on the device. Its chunks have different numbers of points, which change with edits. Twin of
// core/cpu/adaptive/adaptive_view.h.
//
// Evaluate waits for levels and patterns, which say how large the chunks are. Read and Encode wait for this view's lane.
// Clouds are encoded on the device if HasDeviceWriter (device_writer.h). All else is encoded on the host: each chunk of a
// mesh has triangles of its own, whose code only the host makes.
//
// Errors   those of core/view/checked_view.h; kResourceExhausted for device or pinned memory, also of Evaluate, since the
//          number of points is known only then; kUnavailable when the device is lost
// Threads  one thread at a time; Encode uses the context's arena and returns when done
#ifndef LATTICED_CUDA_ADAPTIVE_CUDA_ADAPTIVE_VIEW_H_
#define LATTICED_CUDA_ADAPTIVE_CUDA_ADAPTIVE_VIEW_H_

#include <memory>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/view/checked_view.h"
#include "core/view/spanned/tolerance_slice.h"
#include "core/view/view_encoder.h"
#include "cuda/adaptive/cuda_adaptive_evaluator.h"
#include "cuda/view/device_writer.h"

namespace latticed {

class CudaAdaptiveView : public CheckedView, public ToleranceSlice {
 public:
  // `evaluator` works on `lane`.
  CudaAdaptiveView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                   std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
                   std::unique_ptr<CudaAdaptiveEvaluator> evaluator);
  ~CudaAdaptiveView() override;

  // host_bytes and encode_batch of ViewTraits.
  static uint64_t HostBytesFor(const DeformPlan& plan);
  static size_t EncodeBatch(const CudaContext& context);

  std::span<const uint32_t> also_changed() const override { return evaluator_->also_changed(); }
  PatternCodes Patterns() const override { return evaluator_->Patterns(); }
  double certified_error() const override { return evaluator_->certified_error(); }
  double curvature_tolerance() const override { return evaluator_->curvature_tolerance(); }
  MemoryUse memory() const override;
  ToleranceSlice* tolerance_slice() override { return this; }

  absl::StatusOr<std::vector<Vec3d>> BoxReach() override;
  absl::Status SetReach(std::span<const Vec3d> reach) override;
  absl::Status ShareEdges(std::span<const uint32_t> edges) override;
  absl::Status Bound(std::span<const Vec3d> control_points, const QuantisationBox& box,
                     std::span<const uint32_t> chunks) override;
  absl::StatusOr<std::span<const float>> SharedBounds() override;
  absl::Status Choose(double curvature_tolerance, std::span<const float> shared_bounds) override;
  absl::StatusOr<uint64_t> CountPoints() override;
  absl::Status Finish() override;

  // For measurements: the lane that Evaluate enqueues on. It marks the stages.
  CudaLane& lane() const { return *lane_; }

 private:
  // Gets the vertices of the named chunks first … first + bytes.size() - 1, which are valid during the call.
  using UseBatch = absl::FunctionRef<absl::Status(size_t first,
                                                  std::span<const std::span<const uint8_t>> bytes)>;

  absl::Status EvaluateChunks(std::span<const Vec3d> control_points, const QuantisationBox& box,
                              std::span<const uint32_t> chunks) override;
  absl::Status ReadChunk(uint32_t chunk, std::span<uint8_t> out) override;
  absl::Status EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results,
                            TakeEarly early) override;
  absl::Status EncodeOnDevice(std::span<const uint32_t> chunks, Encoding encoding,
                              std::span<VertexDigest> digests, std::span<SharedBytes> results,
                              TakeEarly early);
  absl::Status EncodeOnHost(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results);
  // Copies chunks to the host in batches, and waits for each.
  absl::Status Fetch(std::span<const uint32_t> chunks, UseBatch use);
  absl::Status CopyBatch(std::span<const uint32_t> chunks, size_t bytes,
                         std::vector<std::span<const uint8_t>>& places);

  // The context comes first: members are destroyed in reverse order, and all others use it.
  const std::shared_ptr<CudaContext> context_;
  const std::shared_ptr<CudaLane> lane_;
  DeviceWriter writer_;
  const std::unique_ptr<CudaAdaptiveEvaluator> evaluator_;
  ViewEncoder encoder_;
  PinnedBuffer staged_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_ADAPTIVE_CUDA_ADAPTIVE_VIEW_H_
