// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/encode_snapshot.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/status_macros.h"
#include "core/patches/edge_order.h"
#include "server/engine/render/chunk_blocks.h"

namespace latticed {

namespace {

// Without chunks of its own: those of `before`, which is of the same plan, or none.
std::shared_ptr<Snapshot> Begin(const ViewKey& key, const SceneState& state,
                                const Snapshot* before) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->view = key;
  snapshot->revision = state.revision;
  snapshot->structure_id = state.structure_id;
  snapshot->box = state.box;
  snapshot->plan = state.plan;
  snapshot->edit_time = state.commit_time;
  const bool same_plan = before != nullptr && before->structure_id == state.structure_id;
  if (!HasPositions(key.spec)) {
    snapshot->first_edges =
        same_plan ? before->first_edges
                  : std::make_shared<const std::vector<uint32_t>>(FirstEdges(*state.plan));
    if (state.lattices.size() > 1) snapshot->summed_points = state.control_points;
  }
  snapshot->chunks = same_plan ? before->chunks.Share() : ChunkTable(state.plan->chunk_count());
  return snapshot;
}

// Puts the chunks of a batch in a snapshot.
class BatchTaker {
 public:
  // `before`: null where its bytes mean something else.
  BatchTaker(std::span<const uint32_t> batch, const Snapshot* before,
             std::span<const uint64_t> revisions, Snapshot& snapshot)
      : batch_(batch), before_(before), revisions_(revisions), snapshot_(snapshot) {}

  // Of what each chunk was, where its bytes mean the same. An attempt to encode may replace them.
  std::span<VertexDigest> Known() {
    digests_.assign(batch_.size(), VertexDigest());
    is_taken_.assign(batch_.size(), false);
    if (before_ == nullptr) return digests_;
    // Elsewhere the bytes follow from the vertices alone.
    const bool has_triangles = snapshot_.view.encoding == Encoding::kDracoMesh;
    for (size_t i = 0; i < batch_.size(); ++i) {
      if (!has_triangles || KeepsPatterns(i)) digests_[i] = Before(i).digest;
    }
    return digests_;
  }

  // As TakeEarly says: the bytes are not there yet, so those that may be the old ones stay in `results`. That is rare: a chunk
  // was encoded on the host, and now on a device.
  void TakeSome(size_t first, std::span<SharedBytes> results,
                std::span<const VertexDigest> digests) {
    for (size_t k = 0; k < results.size(); ++k) {
      const size_t i = first + k;
      const bool is_new = before_ == nullptr || results[k].data != nullptr;
      is_taken_[i] = !is_new || !MayBeTheOldBytes(i, results[k], digests[k]);
      if (!is_taken_[i]) continue;
      is_new ? Put(i, std::exchange(results[k], SharedBytes()), digests[k])
             : PutVertices(i, digests[k]);
    }
  }
  void TakeRest(std::span<SharedBytes> results) {
    for (size_t i = 0; i < results.size(); ++i) {
      // One that was told may be encoded again, and not told again.
      if (is_taken_[i] && results[i].data == nullptr) continue;
      SharedBytes& data = results[i];
      const bool is_new = before_ == nullptr || (data.data != nullptr &&
                                                 !std::ranges::equal(Before(i).data, data.span()));
      is_new ? Put(i, std::move(data), digests_[i]) : PutVertices(i, digests_[i]);
    }
  }

 private:
  SnapshotChunk Before(size_t i) const { return before_->chunks[batch_[i]]; }
  bool MayBeTheOldBytes(size_t i, const SharedBytes& data, const VertexDigest& digest) const {
    return before_ != nullptr && Before(i).data.size() == data.size &&
           !Before(i).digest.DiffersForSure(digest);
  }
  bool KeepsPatterns(size_t i) const {
    return std::ranges::equal(before_->patterns.OfChunk(batch_[i]),
                              snapshot_.patterns.OfChunk(batch_[i]));
  }
  // The chunk keeps its bytes; and its revision, unless a pattern changed.
  void PutVertices(size_t i, const VertexDigest& digest) {
    const uint32_t chunk = batch_[i];
    const SnapshotChunk had = Before(i);
    if (!KeepsPatterns(i)) return Put(i, before_->chunks.Data(chunk), digest);
    if (snapshot_.chunks[chunk].data.data() != had.data.data()) {  // by an attempt that failed
      snapshot_.chunks.Set(chunk, {had.revision, before_->chunks.Data(chunk), digest});
    }
    // Host and device have different digests for the same vertices, and may take turns at encoding.
    snapshot_.chunks.SetDigest(chunk, digest);
  }
  void Put(size_t i, SharedBytes data, const VertexDigest& digest) {
    const uint32_t chunk = batch_[i];
    const uint64_t revision = revisions_.empty() ? snapshot_.revision : revisions_[chunk];
    snapshot_.chunks.Set(chunk, {revision, std::move(data), digest});
  }

  const std::span<const uint32_t> batch_;
  const Snapshot* const before_;
  const std::span<const uint64_t> revisions_;
  Snapshot& snapshot_;
  std::vector<VertexDigest> digests_;
  std::vector<bool> is_taken_;  // in this attempt
};

}  // namespace

absl::StatusOr<std::shared_ptr<Snapshot>> EncodeSnapshot(
    const ViewKey& key, const SceneState& state, std::span<const uint32_t> chunks,
    std::span<const uint64_t> revisions, const ViewTraits& traits, const Snapshot* before,
    EncodeBatch encode, PatternCodes patterns) {
  const auto snapshot = Begin(key, state, before);
  snapshot->patterns = std::move(patterns);
  // Under another quantisation box the same integers mean other positions.
  const bool is_comparable = before != nullptr && before->structure_id == state.structure_id &&
                             before->quantisation_id() == snapshot->quantisation_id();
  if (before != nullptr) revisions = {};

  const absl::Time start = absl::Now();
  const std::vector<uint32_t> order = EncodeOrder(traits, chunks);
  for (size_t done = 0; done < order.size();) {
    const auto batch =
        std::span(order).subspan(done, std::min(traits.encode_batch, order.size() - done));
    BatchTaker taker(batch, is_comparable ? before : nullptr, revisions, *snapshot);
    const auto early = [&taker](auto... some) { taker.TakeSome(some...); };
    const auto known = [&taker] { return taker.Known(); };
    LATTICED_ASSIGN_OR_RETURN(auto encoded, encode(batch, known, early));
    taker.TakeRest(encoded);
    done += batch.size();
  }
  KeepBlocksFew(*snapshot);
  snapshot->encode_time = absl::Now() - start;
  return snapshot;
}

}  // namespace latticed
