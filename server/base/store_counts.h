// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a store has written since the server started, and what state it is in. Counted where it happens, read by
// server/edge/metrics.h.
//
// Threads  safe, without locks
#ifndef LATTICED_SERVER_BASE_STORE_COUNTS_H_
#define LATTICED_SERVER_BASE_STORE_COUNTS_H_

#include <atomic>
#include <cstdint>

#include "server/base/duration_histogram.h"

namespace latticed {

struct StoreCounts {
  // Records: durable, with their bytes; and refused, because the medium failed or their scene is broken.
  std::atomic<uint64_t> appends_stored = 0, appends_refused = 0, append_bytes = 0;
  // Snapshots: durable, with their bytes; and not stored.
  std::atomic<uint64_t> snapshots_stored = 0, snapshots_failed = 0, snapshot_bytes = 0;
  // How often a scene was broken by a record that could not be written: it is read anew before it is edited again.
  std::atomic<uint64_t> scenes_broken = 0;
  // Bytes that went to the log of commits, where the store has one.
  std::atomic<uint64_t> log_bytes = 0;
  // How often the medium failed, so that the store refused writes for a while.
  std::atomic<uint64_t> failures = 0;
  // What is not answered yet, with the bytes of its records and snapshots.
  std::atomic<uint64_t> waiting_writes = 0, waiting_bytes = 0;
  // False from a failure of the medium until it takes a write again.
  std::atomic<bool> writable = true;
  // Transactions, with waiting for the medium.
  DurationHistogram commits;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_STORE_COUNTS_H_
