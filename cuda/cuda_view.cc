// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/cuda_view.h"

#include <algorithm>
#include <new>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/codec/draco_writer.h"
#include "core/view/view_layout.h"

namespace latticed {
namespace {

// Enough for every stream to have a scheduler's attention, and 0.2 GB of working memory at 10
// segments; fewer, down to a few, where that is not to be had.
constexpr size_t kMostDeviceChunks = 4096, kFewestDeviceChunks = 64;
// Of the host's writer: batches for all of its threads.
constexpr size_t kHostChunks = 256;
// On the device the last state of a chunk is reached after a fifth of a millisecond, however few
// there are. A thread of the host takes less for one.
constexpr size_t kHostChunksAThread = 1;

}  // namespace

absl::StatusOr<std::unique_ptr<CudaView>> CudaView::Create(
    std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
    std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
    std::unique_ptr<CudaVertexKernel> kernel) {
  auto frame = CudaFrame::Create(plan, *context, lane);
  if (!frame.ok()) return frame.status();
  const size_t own_bytes = kernel->OwnOrderBytes();
  auto vertices = DeviceBuffer<uint8_t>::Create(
      context->memory(), "vertices",
      own_bytes > 0 ? own_bytes : MakeVertexLayout(*plan, spec).total_bytes(),
      lane->stream().get());
  if (!vertices.ok()) return vertices.status();
  return std::unique_ptr<CudaView>(new CudaView(std::move(plan), spec, std::move(context),
                                                std::move(lane), std::move(kernel),
                                                *std::move(frame), *std::move(vertices)));
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
      staging_(layout_, context_, lane_) {}

CudaView::~CudaView() {
  // The target's tables may go with this view: not while kernels read them.
  const DeviceGuard guard(context_->device());
  static_cast<void>(lane_->stream().Synchronize("the view's end"));
}

absl::Status CudaView::Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                                std::span<const uint32_t> chunks) {
  if (auto s = contract_.CheckEvaluate(control_points, box, chunks); !s.ok()) return s;
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
  if (auto status = contract_.CheckRead(chunk, out.size()); !status.ok()) return status;
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
  if (auto status = contract_.CheckEncode(chunks, encoding); !status.ok()) return status;
  const DeviceGuard guard(context_->device());
  try {
    std::vector<SharedBytes> results(chunks.size());
    const bool few = chunks.size() <= kHostChunksAThread * context_->arena().threads();
    const absl::Status status = WritesOnDevice(encoding) && !few
                                    ? EncodeOnDevice(chunks, encoding, digests, results)
                                    : EncodeOnHost(chunks, encoding, digests, results);
    if (!status.ok()) return status;
    return results;
  } catch (const std::bad_alloc&) {
    static_cast<void>(lane_->stream().Synchronize("the encoding"));
    return error::AllocationFailed("the encoding");
  }
}

bool CudaView::WritesOnDevice(Encoding encoding) const {
  const bool draco = encoding == Encoding::kDracoPoints || encoding == Encoding::kDracoMesh;
  return draco && context_->encoder()->name() == kDracoWriterName;
}

size_t CudaView::encode_batch() const {
  return WritesOnDevice(Encoding::kDracoPoints) ? kMostDeviceChunks : kHostChunks;
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

absl::Status CudaView::MakeWriter(Encoding encoding) {
  const size_t last = plan_->chunk_count() - 1;
  const ViewSpec& spec = contract_.spec();
  DracoShape shape{.points = ChunkPoints(*plan_, 0, spec.segments),
                   .last_points = ChunkPoints(*plan_, last, spec.segments),
                   .position_bits = spec.position_bits,
                   .normal_bits = spec.normals == NormalMode::kNone ? 0 : spec.normal_bits};
  if (encoding == Encoding::kDracoMesh) {
    shape.connectivity = {&encoder_.Connectivity(0),
                          &encoder_.Connectivity(static_cast<uint32_t>(last))};
  }
  auto writer = DeviceDracoWriter::Create(shape, context_, lane_);
  if (!writer.ok()) return writer.status();
  writer_ = *std::move(writer);
  writer_encoding_ = encoding;
  return absl::OkStatus();
}

absl::Status CudaView::EncodeBatch(std::span<const uint32_t> chunks,
                                   std::span<VertexDigest> digests,
                                   std::span<SharedBytes> results) {
  const auto last = static_cast<uint32_t>(plan_->chunk_count()) - 1;
  const double range = contract_.box().range;
  if (kernel_->OwnOrderBytes() == 0) {
    return writer_->Encode({vertices_.span(), last}, chunks, range, digests, results);
  }
  size_t bytes = 0;
  for (const uint32_t chunk : chunks) bytes += layout_.ChunkBytes(chunk);
  auto wire =
      DeviceBuffer<uint8_t>::Create(context_->memory(), "draco", bytes, lane_->stream().get());
  if (!wire.ok()) return wire.status();
  if (auto s = kernel_->ToWireOrder(vertices_.span(), chunks, wire->span()); !s.ok()) return s;
  std::vector<uint32_t> numbers(chunks.size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  const auto count = static_cast<uint32_t>(chunks.size());
  return writer_->Encode({wire->span(), chunks.back() == last ? count - 1 : count}, numbers, range,
                         digests, results);
}

absl::Status CudaView::EncodeOnDevice(std::span<const uint32_t> chunks, Encoding encoding,
                                      std::span<VertexDigest> digests,
                                      std::span<SharedBytes> results) {
  if (!writer_.has_value() || writer_encoding_ != encoding) {
    if (auto s = MakeWriter(encoding); !s.ok()) return s;
  }
  size_t most = kMostDeviceChunks;
  for (size_t done = 0; done < chunks.size();) {
    const size_t count = std::min(most, chunks.size() - done);
    const absl::Status status = EncodeBatch(
        chunks.subspan(done, count), digests.empty() ? digests : digests.subspan(done, count),
        results.subspan(done, count));
    if (absl::IsResourceExhausted(status) && count > kFewestDeviceChunks) {
      most = count / 2;
      continue;
    }
    if (!status.ok()) return status;
    done += count;
  }
  return absl::OkStatus();
}

MemoryUse CudaView::memory() const {
  MemoryUse use = kernel_->memory();
  use["device_vertices"] += vertices_.size_bytes();
  use["device_staging"] += staging_.DeviceBytes() + frame_.DeviceBytes();
  use["staging"] += staging_.PinnedBytes() + frame_.PinnedBytes() + encoder_.MemoryBytes();
  if (writer_.has_value()) {
    use["device_staging"] += writer_->DeviceBytes();
    use["staging"] += writer_->PinnedBytes();
  }
  return use;
}

}  // namespace latticed
