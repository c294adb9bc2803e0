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
  // Batches of edits: committed; refused, or cancelled while their plan was made; answered from
  // memory, since they came a second time.
  std::atomic<uint64_t> edits_applied = 0, edits_refused = 0, edits_repeated = 0;
  // Undo steps that a scene forgot for want of memory, before limits::kMaxUndoSteps and kMaxUndoBytes.
  std::atomic<uint64_t> undo_steps_forgotten = 0;
  // Revisions that a view skipped: a newer one was there when its turn came.
  std::atomic<uint64_t> revisions_merged = 0;

  std::atomic<uint64_t> evaluations = 0;  // of views, begun

  // Of watchers: update_begin and update_end sent; given up on the way for a newer one in less
  // detail; begun with restart, since what they replace was not finished.
  std::atomic<uint64_t> updates_begun = 0, updates_finished = 0, updates_superseded = 0,
                        updates_restarted = 0;
  // Snapshots that a view dropped, at the limit of limits::kMaxSnapshotsPerView, while a watcher
  // was being sent them: so often readers were too slow.
  std::atomic<uint64_t> snapshots_retired = 0;
  std::atomic<uint64_t> chunk_bytes = 0;  // handed to gRPC

  // As in UpdateTimings: evaluation and encoding once a snapshot, queue and send once a watcher's
  // update. The queue leaves out first updates, which may be of edits of long ago.
  DurationHistogram queue, evaluate, encode, send;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_ENGINE_COUNTS_H_
