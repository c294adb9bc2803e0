// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From the bounds of chunks on the host to the bytes that travel. Bounds are few bytes a chunk, so all that changed become
// one block, in the order of the chunks: one allocation, and one slice of what is sent where chunks are consecutive.
//
// Errors   std::bad_alloc
// Threads  pure function
#ifndef LATTICED_CORE_VIEW_BOUNDS_ENCODE_BOUNDS_H_
#define LATTICED_CORE_VIEW_BOUNDS_ENCODE_BOUNDS_H_

#include <span>

#include "absl/functional/function_ref.h"
#include "core/backend.h"

namespace latticed {

// results[i] and digests[i] belong to chunks[i], as DeformView::Encode says. bytes_of: the bounds of a chunk.
void EncodeBounds(std::span<const uint32_t> chunks,
                  absl::FunctionRef<std::span<const uint8_t>(uint32_t chunk)> bytes_of,
                  std::span<VertexDigest> digests, std::span<SharedBytes> results);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_BOUNDS_ENCODE_BOUNDS_H_
