// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a load has measured: the edits of all scenes against the updates of all their streams.
//
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_REPORT_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_REPORT_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "client/cpp/latticectl/latency_recorder.h"
#include "client/cpp/load/edit_log.h"
#include "client/cpp/load/load_plan.h"
#include "client/cpp/load/update_log.h"
#include "client/cpp/load/verified_points.h"

namespace latticed::client {

// Chunks that an update has brought, of all that the surface has.
struct SentChunks {
  uint64_t sent = 0, all = 0;
  double share() const {
    return all == 0 ? 0 : static_cast<double>(sent) / static_cast<double>(all);
  }
};

// Streams of one kind. A latency is counted for every edit of a scene and every stream of it: from
// when the edit was due to the first update that holds it.
struct StreamGroup {
  uint64_t streams = 0;
  uint64_t updates = 0, bytes = 0;
  uint64_t merged = 0;  // edits that share their update with a later one
  // Updates begun in place of one that was superseded on its way (UpdateBegin.restart): its snapshot
  // was retired since the stream is slow, or it gave way to less detail since edits came again. The
  // server counts them as latticed_updates_restarted_total.
  uint64_t restarted = 0;
  uint64_t unseen = 0;  // edits whose update had not come at the end
  LatencyRecorder first_chunk, update_end, decoded;
  std::vector<SentChunks> chunks;  // of each update

  // One stream more. `edits` are its scene's, by revision; updates up to `first_revision` are the
  // warm-up's.
  void Add(const UpdateLog& log, std::span<const TimedEdit> edits, uint64_t first_revision);
  // By their share; zeros where there was no update.
  SentChunks MedianChunks() const;
};

// Times on the server, as update_end and edit_result tell them: of the batches, and of the updates
// of each scene's first editor.
struct ServerStages {
  LatencyRecorder apply, queue, evaluate, encode, send;
  // From the arrival of the batch that made an update's revision to update_begin, when all its bytes
  // are in the host's memory: the sum of that batch's and that update's times, of each update by
  // itself. Batches that were merged into it had come earlier, by what the server does not tell.
  LatencyRecorder arrival_to_bytes;

  // `applied`: the scene's batches, by revision.
  void Add(const UpdateLog& log, std::span<const AppliedEdit> applied, uint64_t first_revision);
};

// Processor time of the measured run.
struct CpuTimes {
  absl::Duration own;
  bool own_holds_server = false;         // which runs in this process
  std::optional<absl::Duration> server;  // of a process of its own
};

struct LoadReport {
  std::string meshes;
  uint64_t patches = 0, points = 0;  // of all scenes
  v1::Encoding encoding = v1::ENCODING_UNSPECIFIED;
  uint64_t edits = 0;     // that were due and have taken effect
  uint64_t replaced = 0;  // of these, unsent: a newer one took their place
  uint64_t unsent = 0;    // due as well, when the run was stopped
  absl::Duration duration;
  StreamGroup editors, watchers, slow;
  ServerStages stages;
  CpuTimes cpu;
  // Updates that the server gave up on their way for a newer one in less detail, as it counts them
  // itself (latticed_updates_superseded_total); known of one in this process.
  std::optional<uint64_t> superseded;
  VerifiedPoints verified;

  uint64_t updates() const { return editors.updates + watchers.updates + slow.updates; }
  uint64_t bytes() const { return editors.bytes + watchers.bytes + slow.bytes; }
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_REPORT_H_
