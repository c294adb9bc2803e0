// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From the vertices of chunks on the host to the bytes that travel, on the threads of an arena.
//
// Errors   those of the ChunkEncoder
// Threads  one thread at a time; uses those of the arena and returns when done
#ifndef LATTICED_CORE_VIEW_VIEW_ENCODER_H_
#define LATTICED_CORE_VIEW_VIEW_ENCODER_H_

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/backend.h"
#include "core/codec/chunk_connectivity.h"
#include "core/codec/chunk_encoder.h"
#include "core/view/cpu_arena.h"

namespace latticed {

// The digest of a chunk's vertices on the host: XXH3 of their bytes in wire layout, but for the lowest bit.
//
// A dirty chunk need not be encoded if its integers are those from which its bytes were made. Keeping the integers for
// comparison would double the memory of vertices. A digest is 16 bytes per chunk, and takes 0.3 ns per point of 8 bytes
// on one core; encoding takes 13 ns. Two different chunks have the same digest once in 2^127 comparisons: at a million
// per second, one update would be missed in 10^24 years.
[[nodiscard]] VertexDigest DigestOf(std::span<const uint8_t> vertices);

// ViewTraits::encoder_bytes of a backend that encodes by `encoder` on the threads of `arena`.
[[nodiscard]] uint64_t EncoderBytesOf(const DeformPlan& plan, const ViewSpec& spec,
                                      const ChunkEncoder& encoder, const CpuArena& arena);

class ViewEncoder {
 public:
  // Returns the vertices of the i-th named chunk in wire layout: a view of them where they are, or
  // of `scratch`, where it has put them. Called from the arena's threads.
  using BytesOf =
      absl::FunctionRef<std::span<const uint8_t>(size_t i, std::vector<uint8_t>& scratch)>;

  // DeformView::Patterns of a view.
  using PatternsOf = std::function<std::span<const uint16_t>(uint32_t chunk)>;

  // Keeps references to the plan and the arena. `patterns_of`: only of a view with a tolerance.
  ViewEncoder(const DeformPlan& plan, const ViewSpec& spec,
              std::shared_ptr<const ChunkEncoder> encoder, CpuArena& arena,
              PatternsOf patterns_of = {})
      : plan_(plan),
        spec_(spec),
        encoder_(std::move(encoder)),
        arena_(arena),
        patterns_of_(std::move(patterns_of)) {}

  // results[i] and digests[i] belong to chunks[i], as DeformView::Encode says. `range`: of the
  // quantisation box.
  [[nodiscard]] absl::Status Encode(std::span<const uint32_t> chunks, Encoding encoding,
                                    double range, BytesOf bytes_of, std::span<VertexDigest> digests,
                                    std::span<SharedBytes> results);

  // The triangles of a chunk of a view without a tolerance. They stay valid as long as this.
  const ChunkConnectivity& Connectivity(uint32_t chunk);

  size_t MemoryBytes() const;
  // The largest MemoryBytes of a view of `spec`.
  [[nodiscard]] static uint64_t MostBytes(const ViewSpec& spec);

 private:
  // Returns the chunks whose digest differs from `digests`, and updates `digests`.
  std::vector<size_t> FindChanged(size_t count, BytesOf bytes_of, std::span<VertexDigest> digests);
  size_t PointsOf(uint32_t chunk) const;
  // Points into `bytes`, the vertices of the chunk.
  QuantisedVertices VerticesOf(uint32_t chunk, std::span<const uint8_t> bytes) const;
  // Draco streams of chunks[i] for the i in `places`.
  [[nodiscard]] absl::Status EncodeDraco(std::span<const uint32_t> chunks,
                                         std::span<const size_t> places, Encoding encoding,
                                         double range, BytesOf bytes_of,
                                         std::span<SharedBytes> results) const;

  const DeformPlan& plan_;
  ViewSpec spec_;
  std::shared_ptr<const ChunkEncoder> encoder_;
  CpuArena& arena_;
  const PatternsOf patterns_of_;
  // By the number of patches in a chunk: the last chunk of a plan may have fewer. Made for kDracoMesh.
  std::map<size_t, ChunkConnectivity> connectivity_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_VIEW_ENCODER_H_
