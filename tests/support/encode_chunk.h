// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Encodes one chunk with a ChunkEncoder.
#ifndef LATTICED_TESTS_SUPPORT_ENCODE_CHUNK_H_
#define LATTICED_TESTS_SUPPORT_ENCODE_CHUNK_H_

#include <array>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/status_macros.h"
#include "core/codec/chunk_connectivity.h"
#include "core/codec/chunk_encoder.h"

namespace latticed::testing {

inline absl::StatusOr<std::vector<uint8_t>> EncodePoints(const ChunkEncoder& encoder,
                                                         const QuantisedVertices& vertices,
                                                         double range) {
  std::vector<uint8_t> stream;
  LATTICED_RETURN_IF_ERROR(encoder.Encode({&vertices, 1}, range, nullptr, {&stream, 1}));
  return stream;
}

inline absl::StatusOr<std::vector<uint8_t>> EncodeMesh(
    const ChunkEncoder& encoder, const QuantisedVertices& vertices, double range,
    const std::vector<std::array<uint32_t, 3>>& triangles) {
  const ChunkConnectivity connectivity(vertices.point_count, triangles);
  std::vector<uint8_t> stream;
  LATTICED_RETURN_IF_ERROR(encoder.Encode({&vertices, 1}, range, &connectivity, {&stream, 1}));
  return stream;
}

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SUPPORT_ENCODE_CHUNK_H_
