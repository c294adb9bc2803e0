// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/chunks.h"

#include "core/base/status_macros.h"

namespace latticed::client {

absl::StatusOr<DecodedPoints> DecodeChunks(std::span<const EncodedChunk> chunks,
                                           const v1::ViewOptions& view) {
  size_t count = 0;
  for (const EncodedChunk& chunk : chunks) count += chunk.point_count;
  DecodedPoints points;
  points.positions.resize(count);
  if (view.normals() != v1::NORMAL_MODE_NONE) points.normals.resize(count);
  LATTICED_RETURN_IF_ERROR(VertexDecoder().Decode(chunks, view, points.positions, points.normals));
  return points;
}

}  // namespace latticed::client
