// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Our writer of Draco streams. Stock decoders read them to exactly the integers that went in, and
// the bytes are a function of those integers alone, whatever instructions the machine has.
#ifndef LATTICED_CORE_CODEC_DRACO_WRITER_H_
#define LATTICED_CORE_CODEC_DRACO_WRITER_H_

#include "core/codec/chunk_encoder.h"

namespace latticed {

// A backend whose vertices lie on a device may write the same bytes there (cuda/draco_kernels.h).
inline constexpr std::string_view kDracoWriterName = "latticed";

class DracoWriter final : public ChunkEncoder {
 public:
  std::string_view name() const override { return kDracoWriterName; }
  size_t batch() const override;
  absl::Status Encode(std::span<const QuantisedVertices> chunks, double range,
                      const ChunkConnectivity* connectivity,
                      std::span<std::vector<uint8_t>> streams) const override;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_WRITER_H_
