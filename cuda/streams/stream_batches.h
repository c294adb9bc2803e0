// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Divides the chunks of an encoding into batches. Each takes working memory of its own.
//
// Errors   those of a batch
// Threads  pure
#ifndef LATTICED_CUDA_STREAMS_STREAM_BATCHES_H_
#define LATTICED_CUDA_STREAMS_STREAM_BATCHES_H_

#include <algorithm>
#include <cstddef>
#include <span>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "core/backend.h"

namespace latticed {

// Chunks of one batch. kMostStreamChunks keep all schedulers busy. Draco takes 0.3 GB of working memory for them at 10
// segments. A batch that does not fit is halved, if it has more than kFewestStreamChunks.
inline constexpr size_t kMostStreamChunks = 4096, kFewestStreamChunks = 64;

// Calls encode(first, count) for the batches of `chunks` chunks.
[[nodiscard]] inline absl::Status EncodeInBatches(
    size_t chunks, absl::FunctionRef<absl::Status(size_t first, size_t count)> encode) {
  size_t most = kMostStreamChunks;
  for (size_t done = 0; done < chunks;) {
    const size_t count = std::min(most, chunks - done);
    const absl::Status status = encode(done, count);
    if (absl::IsResourceExhausted(status) && count > kFewestStreamChunks) {
      most = count / 2;
      continue;
    }
    if (!status.ok()) return status;
    done += count;
  }
  return absl::OkStatus();
}

// `early` for a batch that begins at chunk `batch`.
[[nodiscard]] inline auto From(size_t batch, TakeEarly early) {
  return [batch, early](size_t first, std::span<SharedBytes> results,
                        std::span<const VertexDigest> digests) {
    early(batch + first, results, digests);
  };
}

}  // namespace latticed

#endif  // LATTICED_CUDA_STREAMS_STREAM_BATCHES_H_
