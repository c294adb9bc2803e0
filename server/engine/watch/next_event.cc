// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/watch/next_event.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "absl/container/btree_set.h"
#include "core/base/limits.h"

namespace latticed {
namespace {

// The first batch of an update is small, so that something arrives early.
constexpr size_t kFirstBatchBytes = size_t{32} << 10;
// After a pause, the bytes that max_bytes_per_second allows in this time may be sent at once.
constexpr absl::Duration kBurst = absl::Milliseconds(250);

// All lattices are sent of one revision, from which deltas go on.
LatticeWhole NextWhole(ClientState& client) {
  LatticeWhole whole{client.wholes, client.next_whole++};
  if (client.next_whole >= whole.state->lattices.size()) {
    client.wholes = nullptr;
    client.next_whole = 0;
  }
  return whole;
}

WatchEvent NextLattice(ClientState& client, const WatchOffer& offer) {
  const EditLog::Deltas& news = offer.deltas;
  if (client.also != nullptr) {
    auto delta = std::exchange(client.also, nullptr);
    client.also = delta->also;
    return delta;
  }
  if (client.wholes != nullptr) return NextWhole(client);
  if (client.lattice_revision.has_value() && news.complete &&
      news.deltas.front()->structure_id == client.lattice_structure) {
    client.lattice_revision = news.deltas.front()->revision;
    client.also = news.deltas.front()->also;
    return news.deltas.front();
  }
  client.lattice_revision = client.lattice_from = offer.state->revision;
  client.lattice_structure = offer.state->structure_id;
  client.wholes = offer.state;
  return NextWhole(client);
}

bool IsComparable(const ClientState& client, const Snapshot& snapshot) {
  return client.had.has_value() && client.had->view == snapshot.view &&
         client.had->structure_id == snapshot.structure_id &&
         client.had->quantisation_id == snapshot.quantisation_id() &&
         (client.had->revision >= snapshot.first.revision ||
          client.had->curvature_tolerance == snapshot.first.curvature_tolerance);
}

// The lowest revision that may be sent. Revisions never go back. In another detail, a revision that the client
// has already is not sent again if there is a newer one.
uint64_t LeastRevision(const ClientState& client, const WatchOffer& offer) {
  uint64_t least = std::max(client.min_revision, client.covered.value_or(0));
  if (!client.had.has_value()) return least;
  least = std::max(least, client.had->revision);
  if (client.covered.has_value() && client.had->view != offer.snapshot->view) {
    least = std::max(least, std::min(*client.covered + 1, offer.state->revision));
  }
  return least;
}

bool MayStart(const ClientState& client, const WatchOffer& offer) {
  if (!client.takes_updates || !AcksAllow(client, 1) || offer.snapshot == nullptr) return false;
  const Snapshot& newest = *offer.snapshot;
  const bool nothing_new =
      client.covered == newest.revision && !client.restart && IsComparable(client, newest);
  const bool too_new = client.ceiling.has_value() && newest.revision > *client.ceiling;
  return !nothing_new && !too_new && newest.revision >= LeastRevision(client, offer) &&
         !LacksLattice(client, newest);
}

void Start(ClientState& client, const WatchOffer& offer) {
  const Snapshot& snapshot = *offer.snapshot;
  ClientUpdate& update = client.update.emplace();
  update.topology_id = offer.topology_id;
  if (IsComparable(client, snapshot)) {
    update.chunks = snapshot.chunks.ChangedAfter(client.had->revision);
  } else {
    update.chunks.resize(snapshot.chunks.size());
    std::iota(update.chunks.begin(), update.chunks.end(), 0u);
  }
}

WatchEvent Begin(ClientState& client, const WatchOffer& offer) {
  ClientUpdate& update = *client.update;
  update.id = ++client.last_update_id;
  update.begin_time = offer.now;
  if (client.max_unacked_updates > 0) client.unacked.push_back(update.id);
  // An update of points, or of one lattice.
  if (offer.snapshot->summed_points == nullptr) client.sum = nullptr;
  WatchView in_force = offer.asked;
  in_force.key = offer.snapshot->view;
  return UpdateBegins{.update_id = update.id,
                      .revision = offer.snapshot->revision,
                      .chunk_count = update.chunks.size(),
                      .restart = std::exchange(client.restart, false),
                      .view = in_force};
}

// In an update that is dropped the client keeps it, too.
SumNews NextSum(ClientState& client, const WatchOffer& offer) {
  client.update->has_sum = true;
  const Snapshot& snapshot = *offer.snapshot;
  if (std::exchange(client.sum_structure, snapshot.structure_id) != snapshot.structure_id) {
    client.sum = nullptr;
  }
  return {offer.snapshot, std::exchange(client.sum, snapshot.summed_points)};
}

ChunkBatch NextBatch(const ClientUpdate& update, const WatchOffer& offer) {
  ChunkBatch batch{
      .update_id = update.id, .topology_id = update.topology_id, .snapshot = offer.snapshot};
  const size_t enough = update.sent == 0 ? kFirstBatchBytes : limits::kMinChunkBatchBytes;
  const size_t end = std::min(update.chunks.size(), update.sent + limits::kMaxBatchChunks);
  for (size_t i = update.sent; i < end && batch.bytes < enough; ++i) {
    const uint32_t chunk = update.chunks[i];
    const size_t bytes = offer.snapshot->BytesOf(chunk);
    if (!batch.chunks.empty() && batch.bytes + bytes > limits::kMaxChunkBatchBytes) break;
    batch.chunks.push_back(chunk);
    batch.bytes += bytes;
  }
  return batch;
}

// Those of the batch that the client does not have, the first ones if they are many. The client then has them.
std::vector<uint16_t> TakeNewPatterns(ClientState& client, const ChunkBatch& batch) {
  absl::btree_set<uint16_t> missing;
  for (const uint32_t chunk : batch.chunks) {
    for (const uint16_t code : batch.snapshot->patterns.OfChunk(chunk)) {
      if (!client.patterns[code]) missing.insert(code);
    }
  }
  std::vector<uint16_t> taken;
  for (const uint16_t code : missing) {
    if (taken.size() == PatternNews::kMost) break;
    taken.push_back(code);
    client.patterns.set(code);
  }
  return taken;
}

WatchEvent Batch(ClientState& client, const WatchOffer& offer) {
  ClientUpdate& update = *client.update;
  ChunkBatch batch = NextBatch(update, offer);
  if (auto codes = TakeNewPatterns(client, batch); !codes.empty()) {
    return PatternNews{std::move(codes)};
  }
  update.sent += batch.chunks.size();
  if (const uint64_t rate = offer.asked.max_bytes_per_second; rate > 0) {
    const double seconds = static_cast<double>(batch.bytes) / static_cast<double>(rate);
    client.next_batch_time =
        std::max(client.next_batch_time, offer.now - kBurst) + absl::Seconds(seconds);
  }
  return batch;
}

WatchEvent End(ClientState& client, const WatchOffer& offer) {
  const Snapshot& snapshot = *offer.snapshot;
  client.had = ClientSurface{.view = snapshot.view,
                             .structure_id = snapshot.structure_id,
                             .quantisation_id = snapshot.quantisation_id(),
                             .revision = snapshot.revision,
                             .commit_time = snapshot.edit_time,
                             .curvature_tolerance = snapshot.curvature_tolerance};
  client.covered = snapshot.revision;
  const ClientUpdate update = *std::exchange(client.update, std::nullopt);
  return UpdateEnds{.update_id = update.id,
                    .revision = snapshot.revision,
                    .head_revision = offer.state->revision,
                    .full_detail = snapshot.view == offer.asked.key,
                    .certified_error = snapshot.certified_error,
                    .queue_time = update.begin_time - snapshot.edit_time,
                    .evaluate_time = snapshot.evaluate_time,
                    .encode_time = snapshot.encode_time,
                    .send_time = offer.now - update.begin_time};
}

NextEvent NextOfUpdate(ClientState& client, const WatchOffer& offer) {
  const ClientUpdate& update = *client.update;
  if (client.topology_id != update.topology_id) {
    client.topology_id = update.topology_id;
    return {TopologyNews{update.topology_id, offer.snapshot}};
  }
  const std::pair quantisation(offer.snapshot->quantisation_id(), offer.snapshot->view);
  if (quantisation.first != 0 && client.quantisation != quantisation) {
    client.quantisation = quantisation;
    return {QuantisationNews{offer.snapshot}};
  }
  if (update.id == 0) return {Begin(client, offer)};
  if (offer.snapshot->summed_points != nullptr && !update.has_sum) return {NextSum(client, offer)};
  if (update.sent == update.chunks.size()) return {End(client, offer)};
  if (offer.now < client.next_batch_time) return {std::nullopt, client.next_batch_time};
  return {Batch(client, offer)};
}

}  // namespace

bool LatticeIsDue(const ClientState& client, const EditLog::Deltas& deltas) {
  return client.also != nullptr || client.wholes != nullptr ||
         !client.lattice_revision.has_value() || !deltas.complete || !deltas.deltas.empty();
}

NextEvent Next(ClientState& client, const WatchOffer& offer) {
  if (LatticeIsDue(client, offer.deltas)) return {NextLattice(client, offer)};
  if (!client.update.has_value()) {
    if (!MayStart(client, offer)) return {};
    Start(client, offer);
  }
  return NextOfUpdate(client, offer);
}

bool LacksLattice(const ClientState& client, const Snapshot& snapshot) {
  return !HasPositions(snapshot.view.spec) && snapshot.summed_points == nullptr &&
         snapshot.revision < client.lattice_from;
}

bool AcksAllow(const ClientState& client, size_t updates) {
  const size_t most = client.max_unacked_updates;
  return most == 0 || client.unacked.size() + updates <= most;
}

bool WantsNewer(const ClientState& client, const Snapshot* offered) {
  if (!client.takes_updates) return false;
  if (client.update.has_value()) return AcksAllow(client, client.update->id == 0 ? 2 : 1);
  const bool held_back =
      offered != nullptr && client.ceiling.has_value() && offered->revision > *client.ceiling;
  return AcksAllow(client, 1) && !held_back;
}

void DropUpdate(ClientState& client) {
  if (!client.update.has_value()) return;
  client.restart = client.restart || client.update->id != 0;
  // An update that did not end is never acknowledged.
  std::erase(client.unacked, client.update->id);
  client.update.reset();
}

void Acknowledge(ClientState& client, uint64_t id) {
  std::erase_if(client.unacked, [id](uint64_t other) { return other <= id; });
}

}  // namespace latticed
