// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/view/device_view_encoder.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"

namespace latticed {

absl::Status DeviceViewEncoder::MakeWriter(Encoding encoding) {
  const auto last = static_cast<uint32_t>(plan_.chunk_count()) - 1;
  DracoShape shape{.points = ChunkPoints(plan_, 0, spec_.segments),
                   .last_points = ChunkPoints(plan_, last, spec_.segments),
                   .position_bits = spec_.position_bits,
                   .normal_bits = spec_.normals == NormalMode::kNone ? 0 : spec_.normal_bits};
  if (encoding == Encoding::kDracoMesh) {
    shape.connectivity = {&host_.Connectivity(0), &host_.Connectivity(last)};
  }
  LATTICED_ASSIGN_OR_RETURN(writer_, DeviceDracoWriter::Create(shape, context_, lane_));
  writer_encoding_ = encoding;
  return absl::OkStatus();
}

absl::Status DeviceViewEncoder::EncodeBatch(const Source& source, std::span<const uint32_t> chunks,
                                            std::span<VertexDigest> digests,
                                            std::span<SharedBytes> results) {
  const auto last = static_cast<uint32_t>(plan_.chunk_count()) - 1;
  if (source.kernel.OwnOrderBytes() == 0) {
    return writer_->Encode({source.vertices, last}, chunks, source.range, digests, results);
  }
  size_t bytes = 0;
  for (const uint32_t chunk : chunks) bytes += layout_.ChunkBytes(chunk);
  LATTICED_ASSIGN_OR_RETURN(
      const auto wire,
      DeviceBuffer<uint8_t>::Create(context_->memory(), "draco", bytes, lane_->stream().get()));
  LATTICED_RETURN_IF_ERROR(source.kernel.ToWireOrder(source.vertices, chunks, wire.span()));
  std::vector<uint32_t> numbers(chunks.size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  const auto count = static_cast<uint32_t>(chunks.size());
  return writer_->Encode({wire.span(), chunks.back() == last ? count - 1 : count}, numbers,
                         source.range, digests, results);
}

absl::Status DeviceViewEncoder::EncodeBatches(const Source& source,
                                              std::span<const uint32_t> chunks,
                                              std::span<VertexDigest> digests,
                                              std::span<SharedBytes> results) {
  size_t most = kMostChunks;
  for (size_t done = 0; done < chunks.size();) {
    const size_t count = std::min(most, chunks.size() - done);
    const absl::Status status = EncodeBatch(
        source, chunks.subspan(done, count),
        digests.empty() ? digests : digests.subspan(done, count), results.subspan(done, count));
    if (absl::IsResourceExhausted(status) && count > kFewestChunks) {
      most = count / 2;
      continue;
    }
    if (!status.ok()) return status;
    done += count;
  }
  return absl::OkStatus();
}

absl::Status DeviceViewEncoder::Encode(CudaVertexKernel& kernel, DeviceSpan<const uint8_t> vertices,
                                       std::span<const uint32_t> chunks, Encoding encoding,
                                       double range, std::span<VertexDigest> digests,
                                       std::span<SharedBytes> results) {
  if (!writer_.has_value() || writer_encoding_ != encoding) {
    LATTICED_RETURN_IF_ERROR(MakeWriter(encoding));
  }
  if (!std::ranges::is_sorted(chunks)) {
    return error::InvalidField("chunks", "those of one device must be in ascending order");
  }
  return EncodeBatches({kernel, vertices, range}, chunks, digests, results);
}

}  // namespace latticed
