// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the scenes of a server have done since it started. Counted where it happens, read by
// server/edge/metrics.h.
//
// Threads  safe, without locks
#ifndef LATTICED_SERVER_BASE_ENGINE_COUNTS_H_
#define LATTICED_SERVER_BASE_ENGINE_COUNTS_H_

#include <atomic>
#include <cstdint>

#include "server/base/duration_histogram.h"

namespace latticed {

struct EngineCounts {
  // Batches of edits: committed; refused, or cancelled while their plan was made; answered from memory,
  // because they came a second time.
  std::atomic<uint64_t> edits_applied = 0, edits_refused = 0, edits_repeated = 0;
  // Undo steps that a scene forgot because memory was short, before limits::kMaxUndoSteps and kMaxUndoBytes.
  std::atomic<uint64_t> undo_steps_forgotten = 0;
  // Revisions that a view skipped, because a newer one existed when its turn came.
  std::atomic<uint64_t> revisions_merged = 0;

  std::atomic<uint64_t> evaluations = 0;  // of views, begun

  // Updates of watchers: begun and finished; given up for a newer one in less detail; begun with restart set,
  // because the update that they replace was not finished.
  std::atomic<uint64_t> updates_begun = 0, updates_finished = 0, updates_superseded = 0,
                        updates_restarted = 0;
  // Snapshots that a view retired while a watcher was being sent them, because the reader was too slow for
  // limits::kMaxSnapshotsPerView.
  std::atomic<uint64_t> snapshots_retired = 0;
  std::atomic<uint64_t> chunk_bytes = 0;  // handed to gRPC

  // As in UpdateTimings. Evaluation and encoding are counted once a snapshot, queue and send once an update
  // of a watcher. The queue leaves out first updates, which may show edits of long ago.
  DurationHistogram queue, evaluate, encode, send;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_ENGINE_COUNTS_H_
