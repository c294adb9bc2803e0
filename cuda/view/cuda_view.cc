// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/view/cuda_view.h"

#include <algorithm>
#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "core/codec/draco_writer.h"
#include "core/view/view_layout.h"
#include "cuda/streams/stream_batches.h"

namespace latticed {
namespace {

// Chunks of a batch on the host: enough for all threads of the writer.
constexpr size_t kHostChunks = 256;
// Up to these limits, chunks are encoded on the host. The device takes 0.2 ms even for one chunk. A host
// thread takes 0.02 ms for each chunk, but waking more than sixteen threads takes as long as the device.
constexpr size_t kHostChunksAThread = 3, kMostHostThreads = 16;

size_t VertexBytes(const DeformPlan& plan, const ViewSpec& spec, size_t own_order_bytes) {
  return own_order_bytes > 0 ? own_order_bytes : MakeVertexLayout(plan, spec).total_bytes();
}

}  // namespace

uint64_t CudaView::DeviceBytesFor(const DeformPlan& plan, const ViewSpec& spec,
                                  size_t own_order_bytes, bool has_chunk_needs) {
  return CudaFrame::DeviceBytesFor(plan, has_chunk_needs) +
         VertexBytes(plan, spec, own_order_bytes);
}

uint64_t CudaView::HostBytesFor(const DeformPlan& plan, const ViewSpec& spec) {
  if (plan.chunk_count() == 0) return 0;
  const uint64_t staged = std::min(plan.chunk_count(), kHostChunks) *
                          ChunkPoints(plan, 0, spec.segments) * BytesPerPoint(spec);
  return 2 * PinnedMemory::BlockBytes(staged) +
         CudaFrame::PinnedBytesFor(plan, /*has_chunk_needs=*/true) +
         StagedUpload::PinnedBytesFor(plan.chunk_count() * sizeof(uint32_t)) +  // in wire order
         DeviceStreamWriter::PinnedBytesFor(plan.chunk_count()) + ViewEncoder::MostBytes(spec);
}

size_t CudaView::EncodeBatch(const CudaContext& context) {
  const bool on_device = context.encoder()->name() == kDracoWriterName;
  return on_device ? kMostStreamChunks : kHostChunks;
}

absl::StatusOr<std::unique_ptr<DeformView>> CudaView::Create(
    std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
    std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
    std::unique_ptr<CudaVertexKernel> kernel, DeviceReservation& from) {
  LATTICED_ASSIGN_OR_RETURN(auto frame,
                            CudaFrame::Create(plan, kernel->chunk_needs(), *context, lane, from));
  LATTICED_ASSIGN_OR_RETURN(auto vertices,
                            DeviceBuffer<uint8_t>::Create(
                                from, "vertices", VertexBytes(*plan, spec, kernel->OwnOrderBytes()),
                                lane->stream().get()));
  return std::unique_ptr<DeformView>(new CudaView(std::move(plan), spec, std::move(context),
                                                  std::move(lane), std::move(kernel),
                                                  std::move(frame), std::move(vertices)));
}

CudaView::CudaView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                   std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
                   std::unique_ptr<CudaVertexKernel> kernel, CudaFrame frame,
                   DeviceBuffer<uint8_t> vertices)
    : CheckedView(std::move(plan), spec),
      context_(std::move(context)),
      lane_(std::move(lane)),
      layout_(MakeVertexLayout(this->plan(), spec)),
      encoder_(this->plan(), spec, context_->encoder(), context_->arena()),
      kernel_(std::move(kernel)),
      frame_(std::move(frame)),
      vertices_(std::move(vertices)),
      staging_(layout_, context_, lane_),
      device_encoder_(this->plan(), spec, context_, lane_, encoder_) {}

CudaView::~CudaView() {
  // The destructor may free the target's tables, which kernels on the stream still read.
  const DeviceGuard guard(context_->device());
  static_cast<void>(lane_->stream().Synchronize("the view's end"));
}

absl::Status CudaView::EvaluateChunks(std::span<const Vec3d> control_points,
                                      const QuantisationBox& box,
                                      std::span<const uint32_t> chunks) {
  const DeviceGuard guard(context_->device());
  absl::Status status = CatchBadAlloc("the evaluation", [&]() -> absl::Status {
    LATTICED_RETURN_IF_ERROR(frame_.Stage(control_points, chunks));
    return kernel_->Evaluate(frame_, box, chunks, vertices_.span());
  });
  status.Update(frame_.Sent());
  return status;
}

absl::Status CudaView::ReadChunk(uint32_t chunk, std::span<uint8_t> out) {
  const DeviceGuard guard(context_->device());
  return staging_.Fetch(*kernel_, vertices_.span(), {&chunk, 1},
                        [&](size_t, std::span<const std::span<const uint8_t>> bytes) {
                          std::ranges::copy(bytes[0], out.begin());
                          return absl::OkStatus();
                        });
}

absl::Status CudaView::EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                                    std::span<VertexDigest> digests, std::span<SharedBytes> results,
                                    TakeEarly early) {
  const DeviceGuard guard(context_->device());
  const size_t threads = std::min(context_->arena().threads(), kMostHostThreads);
  const bool few = chunks.size() <= kHostChunksAThread * threads;
  absl::Status status = CatchBadAlloc("the encoding", [&] {
    return HasDeviceWriter(encoding, *context_) && !few
               ? device_encoder_.Encode(*kernel_, vertices_.span(), chunks, encoding, box().range,
                                        digests, results, early)
               : EncodeOnHost(chunks, encoding, digests, results);
  });
  // A copy may still write to memory that the failed encoding frees.
  if (!status.ok()) static_cast<void>(lane_->stream().Synchronize("the encoding"));
  return status;
}

absl::Status CudaView::EncodeOnHost(std::span<const uint32_t> chunks, Encoding encoding,
                                    std::span<VertexDigest> digests,
                                    std::span<SharedBytes> results) {
  const auto encode = [&](size_t first, std::span<const std::span<const uint8_t>> bytes) {
    const auto bytes_of = [&](size_t i, std::vector<uint8_t>&) { return bytes[i]; };
    const auto known = digests.empty() ? digests : digests.subspan(first, bytes.size());
    return encoder_.Encode(chunks.subspan(first, bytes.size()), encoding, box().range, bytes_of,
                           known, results.subspan(first, bytes.size()));
  };
  return staging_.Fetch(*kernel_, vertices_.span(), chunks, encode);
}

MemoryUse CudaView::memory() const {
  MemoryUse use = kernel_->memory();
  use["device_vertices"] += vertices_.size_bytes();
  use["device_staging"] +=
      staging_.DeviceBytes() + frame_.DeviceBytes() + device_encoder_.DeviceBytes();
  use["staging"] += staging_.PinnedBytes() + frame_.PinnedBytes() + encoder_.MemoryBytes() +
                    device_encoder_.PinnedBytes();
  return use;
}

}  // namespace latticed
