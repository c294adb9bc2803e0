// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/adaptive/cuda_adaptive_view.h"

#include <algorithm>
#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "core/codec/draco_writer.h"
#include "cuda/device/cuda_status.h"
#include "cuda/streams/stream_batches.h"

namespace latticed {
namespace {

// Of a batch of copies. A chunk has at most 0.9 MB.
constexpr size_t kCopiedBytes = size_t{8} << 20;
// Of a batch on the host: enough for all threads of the writer.
constexpr size_t kHostBatch = 256;

}  // namespace

CudaAdaptiveView::CudaAdaptiveView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                                   std::shared_ptr<CudaContext> context,
                                   std::shared_ptr<CudaLane> lane,
                                   std::unique_ptr<CudaAdaptiveEvaluator> evaluator)
    : CheckedView(std::move(plan), spec),
      context_(std::move(context)),
      lane_(std::move(lane)),
      writer_(context_, lane_),
      evaluator_(std::move(evaluator)),
      encoder_(this->plan(), spec, context_->encoder(), context_->arena(),
               [this](uint32_t chunk) { return Patterns().OfChunk(chunk); }) {}

CudaAdaptiveView::~CudaAdaptiveView() {
  // The destructor may free the target's tables, which kernels on the stream still read.
  const DeviceGuard guard(context_->device());
  static_cast<void>(lane_->stream().Synchronize("the view's end"));
}

uint64_t CudaAdaptiveView::HostBytesFor(const DeformPlan& plan) {
  return CudaAdaptiveEvaluator::HostBytesFor(plan) + kCopiedBytes +
         DeviceStreamWriter::PinnedBytesFor(plan.chunk_count());
}

size_t CudaAdaptiveView::EncodeBatch(const CudaContext& context) {
  return context.encoder()->name() == kDracoWriterName ? kMostStreamChunks : kHostBatch;
}

absl::Status CudaAdaptiveView::EvaluateChunks(std::span<const Vec3d> control_points,
                                              const QuantisationBox& box,
                                              std::span<const uint32_t> chunks) {
  const DeviceGuard guard(context_->device());
  return evaluator_->Evaluate(control_points, box, chunks);
}

absl::StatusOr<std::vector<Vec3d>> CudaAdaptiveView::BoxReach() {
  const DeviceGuard guard(context_->device());
  return evaluator_->BoxReach();
}

absl::Status CudaAdaptiveView::SetReach(std::span<const Vec3d> reach) {
  const DeviceGuard guard(context_->device());
  return evaluator_->SetReach(reach);
}

absl::Status CudaAdaptiveView::ShareEdges(std::span<const uint32_t> edges) {
  const DeviceGuard guard(context_->device());
  return evaluator_->ShareEdges(edges);
}

absl::Status CudaAdaptiveView::Bound(std::span<const Vec3d> control_points,
                                     const QuantisationBox& box, std::span<const uint32_t> chunks) {
  const DeviceGuard guard(context_->device());
  return evaluator_->Bound(control_points, box, chunks);
}

absl::StatusOr<std::span<const float>> CudaAdaptiveView::SharedBounds() {
  const DeviceGuard guard(context_->device());
  return evaluator_->SharedBounds();
}

absl::Status CudaAdaptiveView::Choose(double curvature_tolerance,
                                      std::span<const float> shared_bounds) {
  const DeviceGuard guard(context_->device());
  return evaluator_->Choose(curvature_tolerance, shared_bounds);
}

absl::StatusOr<uint64_t> CudaAdaptiveView::CountPoints() {
  const DeviceGuard guard(context_->device());
  return evaluator_->CountPoints();
}

absl::Status CudaAdaptiveView::Finish() {
  const DeviceGuard guard(context_->device());
  LATTICED_RETURN_IF_ERROR(evaluator_->Finish());
  SetBox(evaluator_->box());
  return absl::OkStatus();
}

absl::Status CudaAdaptiveView::CopyBatch(std::span<const uint32_t> chunks, size_t bytes,
                                         std::vector<std::span<const uint8_t>>& places) {
  if (staged_.size() < bytes) {
    LATTICED_ASSIGN_OR_RETURN(staged_, context_->pinned().Borrow(bytes));
  }
  places.clear();
  size_t at = 0, run = 0;  // of this chunk, and of the first of its run of neighbours
  for (size_t i = 0; i < chunks.size(); ++i) {
    const size_t size = evaluator_->Vertices(chunks[i], chunks[i] + 1).size;
    places.emplace_back(staged_.data() + at, size);
    at += size;
    if (i + 1 < chunks.size() && chunks[i + 1] == chunks[i] + 1) continue;
    const auto first = static_cast<uint32_t>(chunks[i] + 1 - (i + 1 - run));
    const DeviceSpan<const uint8_t> from = evaluator_->Vertices(first, chunks[i] + 1);
    LATTICED_RETURN_IF_ERROR(
        CudaStatus(cudaMemcpyAsync(staged_.data() + (at - from.size), from.data, from.size,
                                   cudaMemcpyDeviceToHost, lane_->stream().get()),
                   "the copy of vertices"));
    run = i + 1;
  }
  return lane_->stream().Synchronize("the copy of vertices");
}

absl::Status CudaAdaptiveView::Fetch(std::span<const uint32_t> chunks, UseBatch use) {
  std::vector<std::span<const uint8_t>> places;
  for (size_t first = 0, last = 0; first < chunks.size(); first = last) {
    size_t bytes = 0;
    do {
      bytes += evaluator_->Vertices(chunks[last], chunks[last] + 1).size;
      ++last;
    } while (last < chunks.size() &&
             bytes + evaluator_->Vertices(chunks[last], chunks[last] + 1).size <= kCopiedBytes);
    const absl::Status copied = CopyBatch(chunks.subspan(first, last - first), bytes, places);
    if (!copied.ok()) {
      // A copy may still write to memory that goes to the next user.
      static_cast<void>(lane_->stream().Synchronize("the copy of vertices"));
      return copied;
    }
    LATTICED_RETURN_IF_ERROR(use(first, places));
  }
  return absl::OkStatus();
}

absl::Status CudaAdaptiveView::ReadChunk(uint32_t chunk, std::span<uint8_t> out) {
  const DeviceGuard guard(context_->device());
  return Fetch({&chunk, 1}, [&](size_t, std::span<const std::span<const uint8_t>> bytes) {
    std::ranges::copy(bytes[0], out.begin());
    return absl::OkStatus();
  });
}

absl::Status CudaAdaptiveView::EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                                            std::span<VertexDigest> digests,
                                            std::span<SharedBytes> results, TakeEarly early) {
  const DeviceGuard guard(context_->device());
  const bool on_device = encoding != Encoding::kDracoMesh && HasDeviceWriter(encoding, *context_);
  absl::Status status = CatchBadAlloc("the encoding", [&] {
    return on_device ? EncodeOnDevice(chunks, encoding, digests, results, early)
                     : EncodeOnHost(chunks, encoding, digests, results);
  });
  // A copy may still write to memory that the failed encoding frees.
  if (!status.ok()) static_cast<void>(lane_->stream().Synchronize("the encoding"));
  return status;
}

absl::Status CudaAdaptiveView::EncodeOnDevice(std::span<const uint32_t> chunks, Encoding encoding,
                                              std::span<VertexDigest> digests,
                                              std::span<SharedBytes> results, TakeEarly early) {
  const auto shape = [&] {
    return DracoShape{.position_bits = spec().position_bits,
                      .normal_bits = spec().normals == NormalMode::kNone ? 0 : spec().normal_bits,
                      .is_sparse = true};
  };
  LATTICED_ASSIGN_OR_RETURN(DeviceStreamWriter* const writer, writer_.For(encoding, shape));
  const auto vertices = evaluator_->Vertices(0, static_cast<uint32_t>(plan().chunk_count()));
  return EncodeInBatches(chunks.size(), [&](size_t first, size_t count) {
    std::vector<DeviceStreamWriter::Chunk> places(count);
    for (size_t i = 0; i < count; ++i) {
      const uint32_t chunk = chunks[first + i];
      const uint64_t point = evaluator_->FirstPoint(chunk);
      places[i] = {point, static_cast<uint32_t>(evaluator_->FirstPoint(chunk + 1) - point)};
    }
    return writer->Encode(vertices, places, box().range,
                          digests.empty() ? digests : digests.subspan(first, count),
                          results.subspan(first, count), From(first, early));
  });
}

absl::Status CudaAdaptiveView::EncodeOnHost(std::span<const uint32_t> chunks, Encoding encoding,
                                            std::span<VertexDigest> digests,
                                            std::span<SharedBytes> results) {
  return Fetch(chunks, [&](size_t first, std::span<const std::span<const uint8_t>> bytes) {
    const auto bytes_of = [&](size_t i, std::vector<uint8_t>&) { return bytes[i]; };
    const auto known = digests.empty() ? digests : digests.subspan(first, bytes.size());
    return encoder_.Encode(chunks.subspan(first, bytes.size()), encoding, box().range, bytes_of,
                           known, results.subspan(first, bytes.size()));
  });
}

MemoryUse CudaAdaptiveView::memory() const {
  MemoryUse use = evaluator_->memory();
  use["staging"] += staged_.size() + encoder_.MemoryBytes() + writer_.PinnedBytes();
  use["device_staging"] += writer_.DeviceBytes();
  return use;
}

}  // namespace latticed
