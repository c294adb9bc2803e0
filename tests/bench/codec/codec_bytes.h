// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bytes of a whole update of a scenario: of our writer, of libdraco on the same points in the same
// order, and of our writer on the points row by row.
//
// Errors   kInternal where a stream of ours, in that order, decodes to other integers
// Threads  one at a time
#ifndef LATTICED_TESTS_BENCH_CODEC_CODEC_BYTES_H_
#define LATTICED_TESTS_BENCH_CODEC_CODEC_BYTES_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/codec/chunk_encoder.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

class CodecBytes {
 public:
  // `spec` with normals.
  [[nodiscard]] static absl::StatusOr<CodecBytes> Count(const Scenario& scenario,
                                                        const ViewSpec& spec);

  size_t points = 0, ours = 0, libdraco = 0, row_by_row = 0;
  size_t chunks = 0;
  size_t larger = 0, larger_bytes = 0;  // chunks where ours takes more, and how much more there
  // Chunks where libdraco picks its tagged scheme for an attribute; how many more bytes ours take in
  // those, and in the others, where both use the raw scheme.
  size_t tagged_chunks = 0;
  int64_t more_at_tagged = 0, more_elsewhere = 0;

  // How much more than libdraco's ours is, and how much less than row by row.
  double more_than_libdraco() const;
  double saved_by_serpentine() const;

 private:
  using Stream = std::vector<uint8_t>;

  absl::Status AddGroup(std::span<const std::vector<uint8_t>> chunks, const ViewSpec& spec,
                        double range);
  absl::Status AddChunk(const QuantisedVertices& vertices, const Stream& stream, double range);
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_CODEC_CODEC_BYTES_H_
