// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/vertex_digest.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace latticed {

VertexDigest DigestOf(std::span<const uint8_t> vertices) {
  const XXH128_hash_t hash = XXH3_128bits(vertices.data(), vertices.size());
  return {hash.low64, hash.high64};
}

}  // namespace latticed
