// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of a watcher: takes SceneEvents, returns complete updates. An update changes the surface
// only when it has ended (proto/latticed/v1/event.proto).
//
// Errors   kDataLoss when events contradict each other: the stream cannot be trusted any more
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LIBRARY_SURFACE_H_
#define LATTICED_CLIENT_CPP_LIBRARY_SURFACE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cpp/library/patch_layout.h"
#include "client/cpp/library/patches/lattice_history.h"
#include "client/cpp/library/vertex_decoder.h"
#include "latticed/v1/event.pb.h"
#include "latticed/v1/view.pb.h"

namespace latticed::client {

struct CompleteUpdate {
  v1::UpdateEnd end;
  size_t chunk_count = 0;
  uint64_t bytes = 0;  // of chunk data
};

class Surface {
 public:
  // Takes one event; returns an update when this event completes it.
  [[nodiscard]] absl::StatusOr<std::optional<CompleteUpdate>> Apply(v1::SceneEvent event);
  // Drops an update that has begun, because its stream has broken.
  void DropPartialUpdate();

  // Whether an update has been completed.
  bool complete() const { return complete_; }
  // These five belong to the newest complete update.
  const v1::Topology& topology() const { return topology_; }
  const v1::ViewOptions& view() const { return view_; }
  uint64_t revision() const { return revision_; }
  double certified_error() const { return certified_error_; }  // UpdateEnd.certified_error
  // The lattice that the update shows: with ENCODING_PATCHES that of revision(), and the sum if the scene has several. In other
  // views it is the first one; a lattice_state may have skipped it, and this is the next one.
  const v1::LatticeState& update_lattice() const {
    return shows_sum_ ? sum_.of_update() : lattices_.of_update();
  }
  // Bytes of all chunks of the surface.
  uint64_t bytes() const;
  // The received share of the update in progress, 0 to 1; 1 if none is in progress.
  double progress() const;
  // The lattice after the newest edit that the server has reported, of several the first one. The next updates show it.
  const v1::LatticeState& lattice() const { return lattices_.newest(); }

  // The quantisation grid announced last. All chunks use it unless an update is in progress.
  const v1::Quantisation& quantisation() const;
  size_t chunk_count() const { return chunks_.size(); }
  struct PatchRange {
    uint64_t first = 0, count = 0;
  };
  // The patches of a chunk below chunk_count().
  PatchRange PatchesOf(size_t chunk) const;

  // The layout of each patch, in the order of patches; of one chunk's patches.
  [[nodiscard]] absl::StatusOr<std::vector<PatchLayout>> Layouts() const;
  [[nodiscard]] absl::StatusOr<std::vector<PatchLayout>> Layouts(size_t chunk) const;
  // The number of points of the newest complete update; 0 before it.
  uint64_t PointCount() const;

  // With ENCODING_PATCHES: a byte for each edge of the plan, for PatchEvaluator. There is nothing to decode then.
  [[nodiscard]] absl::StatusOr<std::vector<uint8_t>> EdgeBounds() const;

  // All points of the newest complete update.
  [[nodiscard]] absl::StatusOr<DecodedPoints> Decode() const;
  // The points of some of its chunks, in this order. Chunks that come together are decoded faster. Several threads may decode
  // at once, while none applies an event.
  [[nodiscard]] absl::StatusOr<DecodedPoints> Decode(std::span<const uint32_t> chunks) const;
  // The same straight into the caller's memory, which has room for PointCount(chunks) vertices. Each thread has its own decoder.
  [[nodiscard]] absl::StatusOr<uint64_t> PointCount(std::span<const uint32_t> chunks) const;
  [[nodiscard]] absl::Status Decode(std::span<const uint32_t> chunks, VertexDecoder* decoder,
                                    std::span<GridVertex> vertices) const;
  [[nodiscard]] absl::Status Decode(std::span<const uint32_t> chunks, VertexDecoder* decoder,
                                    std::span<WorldVertex> vertices) const;

 private:
  struct HeldChunk {
    std::string data, levels;
    uint64_t level_points = 0;  // of the patterns that `levels` names
    // The grid announced before the chunk. After a change of view the server may send the same id
    // with other bits.
    std::shared_ptr<const v1::Quantisation> quantisation;
  };

  bool HasPatches() const { return view_.encoding() == v1::ENCODING_PATCHES; }
  absl::Status TakeSum(v1::PatchLattice news);
  absl::Status TakePatterns(v1::Patterns patterns);
  // The points of the patterns that its levels name.
  absl::StatusOr<uint64_t> PointsOf(const v1::Chunk& chunk) const;
  absl::Status TakeChunks(v1::Chunks chunks);
  absl::Status TakeBounds(v1::Chunks chunks);
  absl::Status KeepBounds();
  absl::StatusOr<CompleteUpdate> TakeEnd(v1::UpdateEnd end);
  absl::Status CheckHasPoints() const;
  static absl::Status CheckLevelCount(const HeldChunk& chunk, uint64_t patches);
  // Appends the layouts of a chunk.
  absl::Status LayoutOnto(size_t chunk, uint64_t patches, std::vector<PatchLayout>* layouts) const;
  absl::StatusOr<std::vector<EncodedChunk>> Encoded(std::span<const uint32_t> chunks) const;

  LatticeHistory lattices_;
  LatticeHistory sum_;                             // of several lattices, with ENCODING_PATCHES
  std::map<std::string, v1::Topology> announced_;  // topologies of updates to come
  std::shared_ptr<const v1::Quantisation> quantisation_;
  std::map<uint32_t, v1::PatchPattern> patterns_;  // by code; they are the same on every stream

  std::optional<v1::UpdateBegin> begin_;
  std::string begun_topology_;
  std::map<uint32_t, HeldChunk> begun_chunks_;
  std::vector<v1::Chunk> begun_bounds_;
  bool begun_sum_ = false;  // a patch_lattice has come
  uint64_t begun_bytes_ = 0;

  bool complete_ = false;
  v1::Topology topology_;
  v1::ViewOptions view_;
  uint64_t revision_ = 0;
  double certified_error_ = 0;
  bool shows_sum_ = false;
  std::vector<HeldChunk> chunks_;
  std::vector<uint8_t> edge_bounds_;  // with ENCODING_PATCHES, when chunks_ have no data
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_SURFACE_H_
