// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/view/device_view_encoder.h"

#include <algorithm>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "cuda/streams/stream_batches.h"

namespace latticed {

DracoShape DeviceViewEncoder::ShapeFor(Encoding encoding) const {
  DracoShape shape{.position_bits = spec_.position_bits,
                   .normal_bits = spec_.normals == NormalMode::kNone ? 0 : spec_.normal_bits};
  if (encoding == Encoding::kDracoMesh) {
    const auto last = static_cast<uint32_t>(plan_.chunk_count()) - 1;
    shape.connectivity = {&host_.Connectivity(0), &host_.Connectivity(last)};
    shape.mesh_points = ChunkPoints(plan_, 0, spec_.segments);
  }
  return shape;
}

absl::Status DeviceViewEncoder::EncodeBatch(const Source& source, std::span<const uint32_t> chunks,
                                            std::span<VertexDigest> digests,
                                            std::span<SharedBytes> results, TakeEarly early) {
  // Asked once: to ask for each chunk would take a twentieth of all time to the bytes.
  const auto last = static_cast<uint32_t>(plan_.chunk_count()) - 1;
  const size_t usual_points = ChunkPoints(plan_, 0, spec_.segments),
               last_points = ChunkPoints(plan_, last, spec_.segments);
  DeviceSpan<const uint8_t> vertices = source.vertices;
  DeviceBuffer<uint8_t> wire;
  const bool is_wire_order = source.kernel.OwnOrderBytes() == 0;
  if (!is_wire_order) {
    // Before all that the host still lists, so that the device goes on meanwhile.
    const size_t points =
        (chunks.size() - 1) * usual_points + (chunks.back() == last ? last_points : usual_points);
    LATTICED_ASSIGN_OR_RETURN(
        wire, DeviceBuffer<uint8_t>::Create(context_->memory(), source.writer.purpose(),
                                            points * BytesPerPoint(spec_), lane_->stream().get()));
    LATTICED_RETURN_IF_ERROR(source.kernel.ToWireOrder(source.vertices, chunks, wire.span()));
    vertices = wire.span();
  }
  std::vector<DeviceStreamWriter::Chunk> places;
  places.reserve(chunks.size());
  size_t first = 0;
  for (const uint32_t chunk : chunks) {
    if (is_wire_order) first = chunk * usual_points;
    const size_t points = chunk == last ? last_points : usual_points;
    places.push_back({.first_point = first, .points = static_cast<uint32_t>(points)});
    first += points;
  }
  return source.writer.Encode(vertices, places, source.range, digests, results, early);
}

absl::Status DeviceViewEncoder::Encode(CudaVertexKernel& kernel, DeviceSpan<const uint8_t> vertices,
                                       std::span<const uint32_t> chunks, Encoding encoding,
                                       double range, std::span<VertexDigest> digests,
                                       std::span<SharedBytes> results, TakeEarly early) {
  LATTICED_ASSIGN_OR_RETURN(DeviceStreamWriter* const writer,
                            writer_.For(encoding, [&] { return ShapeFor(encoding); }));
  if (!std::ranges::is_sorted(chunks)) {
    return error::InvalidField("chunks", "those of one device must be in ascending order");
  }
  const Source source{*writer, kernel, vertices, range};
  return EncodeInBatches(chunks.size(), [&](size_t first, size_t count) {
    return EncodeBatch(source, chunks.subspan(first, count),
                       digests.empty() ? digests : digests.subspan(first, count),
                       results.subspan(first, count), From(first, early));
  });
}

}  // namespace latticed
