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

bool SameBytes(const SharedBytes& a, const SharedBytes& b) {
  return a.size == b.size && std::equal(a.data, a.data + a.size, b.data);
}

bool SamePatterns(const SnapshotChunk& chunk, std::span<const uint16_t> patterns) {
  if (chunk.patterns == nullptr) return patterns.empty();
  return std::ranges::equal(*chunk.patterns, patterns);
}

std::shared_ptr<const ChunkPatterns> Shareable(std::span<const uint16_t> patterns) {
  if (patterns.empty()) return nullptr;
  return std::make_shared<const ChunkPatterns>(patterns.begin(), patterns.end());
}

}  // namespace

absl::StatusOr<std::shared_ptr<Snapshot>> EncodeSnapshot(
    const ViewKey& key, const SceneState& state, std::span<const uint32_t> chunks,
    std::span<const uint64_t> revisions, const ViewTraits& traits, const Snapshot* before,
    EncodeBatch encode, PatternsOfChunk patterns_of) {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->view = key;
  snapshot->revision = state.revision;
  snapshot->structure_id = state.structure_id;
  snapshot->box = state.box;
  snapshot->plan = state.plan;
  snapshot->edit_time = state.commit_time;
  const bool same_plan = before != nullptr && before->structure_id == state.structure_id;
  // Under another quantisation box the same integers mean other positions.
  const bool comparable = same_plan && before->quantisation_id() == snapshot->quantisation_id();
  if (!HasPositions(key.spec)) {
    snapshot->first_edges =
        same_plan ? before->first_edges
                  : std::make_shared<const std::vector<uint32_t>>(FirstEdges(*state.plan));
    if (state.lattices.size() > 1) snapshot->summed_points = state.control_points;
  }
  snapshot->chunks = same_plan ? before->chunks.Share() : ChunkTable(state.plan->chunk_count());

  const absl::Time start = absl::Now();
  const std::vector<uint32_t> order = EncodeOrder(traits, chunks);
  for (size_t done = 0; done < order.size();) {
    const auto batch =
        std::span(order).subspan(done, std::min(traits.encode_batch, order.size() - done));
    std::vector<VertexDigest> digests(batch.size());
    // What each chunk was, where its bytes mean the same.
    std::vector<const SnapshotChunk*> comparable_chunks(batch.size());
    for (size_t i = 0; comparable && i < batch.size(); ++i) {
      const SnapshotChunk& had = before->chunks[batch[i]];
      if (!SamePatterns(had, patterns_of(batch[i]))) continue;
      comparable_chunks[i] = &had;
      digests[i] = had.digest;
    }
    LATTICED_ASSIGN_OR_RETURN(auto encoded, encode(batch, digests));
    for (size_t i = 0; i < batch.size(); ++i) {
      SharedBytes& data = encoded[i];
      const SnapshotChunk* const had = comparable_chunks[i];
      if (had != nullptr && (data.data == nullptr || SameBytes(had->data, data))) {
        // Host and device have different digests for the same vertices, and may take turns at encoding.
        snapshot->chunks.SetDigest(batch[i], digests[i]);
      } else {
        const bool is_dated = before == nullptr && !revisions.empty();
        snapshot->chunks.Set(batch[i],
                             {is_dated ? revisions[batch[i]] : snapshot->revision, std::move(data),
                              digests[i], Shareable(patterns_of(batch[i]))});
      }
    }
    done += batch.size();
  }
  KeepBlocksFew(*snapshot);
  snapshot->encode_time = absl::Now() - start;
  return snapshot;
}

}  // namespace latticed
