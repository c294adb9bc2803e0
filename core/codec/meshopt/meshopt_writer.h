// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Our writer of meshopt streams (meshopt_format.h). meshoptimizer decodes them to exactly the integers that went in. The
// bytes depend on those integers alone, not on the instructions that the machine has.
//
// Threads  pure
#ifndef LATTICED_CORE_CODEC_MESHOPT_MESHOPT_WRITER_H_
#define LATTICED_CORE_CODEC_MESHOPT_MESHOPT_WRITER_H_

#include <cstdint>
#include <vector>

#include "core/codec/chunk_encoder.h"

namespace latticed {

// Returns the stream of `chunk`, which has a point at least.
[[nodiscard]] std::vector<uint8_t> EncodeMeshopt(const QuantisedVertices& chunk);

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_MESHOPT_MESHOPT_WRITER_H_
