// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Decodes the Draco and meshopt streams that latticed writes (core/codec/draco_writer.h, core/codec/meshopt) to the integers
// that they hold. Any other stream is refused; then a stock decoder may try. Damage that contradicts nothing is not seen.
// Draco's chunks of one call are decoded side by side; from eight on it is fastest.
//
//   x y z 0 s t    uint16 each: grid coordinates, 0, and the octahedral normal (0 0 without normals)
//
// Values equal libdraco's with attribute transforms skipped, or meshoptimizer's, also those of damaged streams.
//
// Threads  one decoder: one at a time. Memory is kept from one call to the next
#ifndef LATTICED_CLIENT_DECODER_CHUNK_DECODER_H_
#define LATTICED_CLIENT_DECODER_CHUNK_DECODER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace latticed::decoder {

inline constexpr size_t kNumbersPerPoint = 6;
// Chunks have one point at least, and this many at most (core/base/limits.h); others are refused.
inline constexpr uint32_t kMostPoints = 65'535;

enum class Codec { kDraco, kMeshopt };

// Chunks of other bits are refused.
struct ChunkForm {
  int position_bits = 12;  // 1 to 16
  int normal_bits = 0;     // up to 12; 0: no normals
  Codec codec = Codec::kDraco;
};

struct ChunkJob {
  std::span<const uint8_t> stream;
  uint32_t points = 0;      // that it must have
  uint16_t* out = nullptr;  // points x kNumbersPerPoint

  // Results. Unless `decoded`, what was written to `out` means nothing; nothing was written beside it.
  bool decoded = false;
  uint16_t least[3] = {}, most[3] = {};  // of x y z
};

class ChunkDecoder {
 public:
  ChunkDecoder();
  ~ChunkDecoder();

  // Returns whether all were decoded.
  bool Decode(const ChunkForm& form, std::span<ChunkJob> jobs);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_CHUNK_DECODER_H_
