// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/view/cuda_view.h"

#include <algorithm>
#include <new>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/codec/draco_writer.h"
#include "core/view/view_layout.h"

namespace latticed {
namespace {

// Of the host's writer: batches for all of its threads.
constexpr size_t kHostChunks = 256;
// On the device the last state of a chunk is reached after a fifth of a millisecond, however few
// there are. A thread of the host takes a tenth of that for each; but to wake more than sixteen of
// them takes as long.
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
  constexpr uint64_t kRounding = 2;  // pinned blocks are powers of two
  constexpr uint64_t kFramePointBytes = 64, kExchangedChunkBytes = 128;
  if (plan.chunk_count() == 0) return 0;
  const uint64_t staged = std::min(plan.chunk_count(), kHostChunks) *
                          ChunkPoints(plan, 0, spec.segments) * BytesPerPoint(spec);
  const auto points = static_cast<uint64_t>(plan.structure.control_point_count());
  return kRounding *
             (2 * staged + kFramePointBytes * points + kExchangedChunkBytes * plan.chunk_count()) +
         ViewEncoder::MostBytes(spec);
}

size_t CudaView::EncodeBatch(const CudaContext& context) {
  const bool on_device = context.encoder()->name() == kDracoWriterName;
  return on_device ? DeviceViewEncoder::kMostChunks : kHostChunks;
}

absl::StatusOr<std::unique_ptr<CudaView>> CudaView::Create(std::shared_ptr<const DeformPlan> plan,
                                                           const ViewSpec& spec,
                                                           std::shared_ptr<CudaContext> context,
                                                           std::shared_ptr<CudaLane> lane,
                                                           std::unique_ptr<CudaVertexKernel> kernel,
                                                           DeviceReservation& from) {
  LATTICED_ASSIGN_OR_RETURN(auto frame,
                            CudaFrame::Create(plan, kernel->chunk_needs(), *context, lane, from));
  LATTICED_ASSIGN_OR_RETURN(auto vertices,
                            DeviceBuffer<uint8_t>::Create(
                                from, "vertices", VertexBytes(*plan, spec, kernel->OwnOrderBytes()),
                                lane->stream().get()));
  return std::unique_ptr<CudaView>(new CudaView(std::move(plan), spec, std::move(context),
                                                std::move(lane), std::move(kernel),
                                                std::move(frame), std::move(vertices)));
}

CudaView::CudaView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
                   std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
                   std::unique_ptr<CudaVertexKernel> kernel, CudaFrame frame,
                   DeviceBuffer<uint8_t> vertices)
    : plan_(std::move(plan)),
      context_(std::move(context)),
      lane_(std::move(lane)),
      layout_(MakeVertexLayout(*plan_, spec)),
      contract_(*plan_, spec),
      encoder_(*plan_, spec, context_->encoder(), context_->arena()),
      kernel_(std::move(kernel)),
      frame_(std::move(frame)),
      vertices_(std::move(vertices)),
      staging_(layout_, context_, lane_),
      device_encoder_(*plan_, spec, layout_, context_, lane_, encoder_) {}

CudaView::~CudaView() {
  // The target's tables may go with this view: not while kernels read them.
  const DeviceGuard guard(context_->device());
  static_cast<void>(lane_->stream().Synchronize("the view's end"));
}

absl::Status CudaView::Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                                std::span<const uint32_t> chunks) {
  LATTICED_RETURN_IF_ERROR(contract_.CheckEvaluate(control_points, box, chunks));
  const DeviceGuard guard(context_->device());
  try {
    absl::Status status = frame_.Stage(control_points, chunks);
    if (status.ok()) status = kernel_->Evaluate(frame_, box, chunks, vertices_.span());
    status.Update(frame_.Sent());
    if (!status.ok()) {
      contract_.Lost();
      return status;
    }
  } catch (const std::bad_alloc&) {
    contract_.Lost();
    static_cast<void>(frame_.Sent());
    return error::AllocationFailed("the evaluation");
  }
  contract_.Evaluated(box);
  return absl::OkStatus();
}

absl::Status CudaView::Read(uint32_t chunk, std::span<uint8_t> out) {
  LATTICED_RETURN_IF_ERROR(contract_.CheckRead(chunk, out.size()));
  const DeviceGuard guard(context_->device());
  return staging_.Fetch(*kernel_, vertices_.span(), {&chunk, 1},
                        [&](size_t, std::span<const std::span<const uint8_t>> bytes) {
                          std::copy(bytes[0].begin(), bytes[0].end(), out.begin());
                          return absl::OkStatus();
                        });
}

absl::StatusOr<std::vector<SharedBytes>> CudaView::Encode(std::span<const uint32_t> chunks,
                                                          Encoding encoding,
                                                          std::span<VertexDigest> digests) {
  LATTICED_RETURN_IF_ERROR(contract_.CheckEncode(chunks, encoding));
  const DeviceGuard guard(context_->device());
  try {
    std::vector<SharedBytes> results(chunks.size());
    const size_t threads = std::min(context_->arena().threads(), kMostHostThreads);
    const bool few = chunks.size() <= kHostChunksAThread * threads;
    LATTICED_RETURN_IF_ERROR(WritesOnDevice(encoding) && !few
                                 ? device_encoder_.Encode(*kernel_, vertices_.span(), chunks,
                                                          encoding, contract_.box().range, digests,
                                                          results)
                                 : EncodeOnHost(chunks, encoding, digests, results));
    return results;
  } catch (const std::bad_alloc&) {
    static_cast<void>(lane_->stream().Synchronize("the encoding"));
    return error::AllocationFailed("the encoding");
  }
}

bool CudaView::WritesOnDevice(Encoding encoding) const {
  return IsDraco(encoding) && context_->encoder()->name() == kDracoWriterName;
}

absl::Status CudaView::EncodeOnHost(std::span<const uint32_t> chunks, Encoding encoding,
                                    std::span<VertexDigest> digests,
                                    std::span<SharedBytes> results) {
  const auto encode = [&](size_t first, std::span<const std::span<const uint8_t>> bytes) {
    const auto bytes_of = [&](size_t i, std::vector<uint8_t>&) { return bytes[i]; };
    const auto known = digests.empty() ? digests : digests.subspan(first, bytes.size());
    return encoder_.Encode(chunks.subspan(first, bytes.size()), encoding, contract_.box().range,
                           bytes_of, known, results.subspan(first, bytes.size()));
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
