// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Our writer of Draco streams. Stock decoders read them to exactly the integers that went in, and
// the bytes are a function of those integers alone, whatever instructions the machine has.
#ifndef LATTICED_CORE_CODEC_DRACO_WRITER_H_
#define LATTICED_CORE_CODEC_DRACO_WRITER_H_

#include "core/codec/chunk_encoder.h"

namespace latticed {

class DracoWriter final : public ChunkEncoder {
 public:
  std::string_view name() const override { return "latticed"; }
  absl::StatusOr<std::vector<uint8_t>> EncodePoints(const QuantisedVertices& vertices,
                                                    double range) const override;
  absl::StatusOr<std::vector<uint8_t>> EncodeMesh(
      const QuantisedVertices& vertices, double range,
      std::span<const std::array<uint32_t, 3>> triangles) const override;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_WRITER_H_
