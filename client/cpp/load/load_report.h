// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The result of a load: for the edits of all scenes, the updates of all their streams.
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
#include "client/cpp/latticectl/commands/load_plan.h"
#include "client/cpp/latticectl/output/latency_recorder.h"
#include "client/cpp/load/edit_log.h"
#include "client/cpp/load/surface_verifier.h"
#include "client/cpp/load/update_log.h"

namespace latticed::client {

// The streams of one kind. Each pair of an edit and a stream of its scene gives one latency: from the
// time that the edit was due to the first update that holds it.
struct StreamGroup {
  uint64_t streams = 0;
  uint64_t updates = 0, bytes = 0;
  uint64_t merged = 0;  // edits that share their update with a later one
  // Updates with UpdateBegin.restart. They replaced an update that had not ended: its snapshot was
  // retired because the stream was slow, or a less detailed update superseded it because edits came
  // again. The server counts them as latticed_updates_restarted_total.
  uint64_t restarted = 0;
  uint64_t unseen = 0;  // edits whose update had not come when the run ended
  LatencyRecorder first_chunk, update_end, decoded;

  // Adds a stream. `edits` are those of its scene, sorted by revision. Updates up to
  // `first_revision` belong to the warm-up.
  void Add(const UpdateLog& log, std::span<const TimedEdit> edits, uint64_t first_revision);
};

// Times on the server. They come from the edit_result of each batch, and from the update_end events of
// each scene's first editor.
struct ServerStages {
  LatencyRecorder apply, queue, evaluate, encode, send;
  // From the arrival of the batch that made an update's revision to update_begin, when all bytes of
  // the update are in host memory: the batch's apply_time plus the update's queue time. Batches merged
  // into the update came earlier; the server does not report by how much.
  LatencyRecorder arrival_to_bytes;

  // `batches` are those of the scene, sorted by revision.
  void Add(const UpdateLog& log, std::span<const AppliedBatch> batches, uint64_t first_revision);
};

// Counters that grow during a run.
struct LoadCounters {
  absl::Duration own_cpu;                    // processor time of this process
  std::optional<absl::Duration> server_cpu;  // of the server's process, if its id is known
  // Updates that a less detailed one superseded. The server counts them over all of its streams.
  uint64_t superseded = 0;
};

struct LoadReport {
  std::string meshes;
  uint64_t patches = 0, points = 0;  // of all scenes
  v1::Encoding encoding = v1::ENCODING_UNSPECIFIED;
  std::string encoding_reason;  // empty: --encoding names it
  uint64_t edits = 0;           // that were due, replaced ones included
  uint64_t replaced = 0;        // edits that a newer one replaced before they were sent
  absl::Duration duration;
  StreamGroup editors, watchers, slow;
  ServerStages stages;
  bool own_holds_server = false;  // the server runs in this process
  LoadCounters before, after;     // before and after the measured run
  VerifiedPoints verified;

  uint64_t updates() const { return editors.updates + watchers.updates + slow.updates; }
  uint64_t bytes() const { return editors.bytes + watchers.bytes + slow.bytes; }
};

// One stage of the time from an edit to its update at an editor:
//
//   apply | wait for a turn | evaluate | encode | send | on the way | decode
//
// Each stage has its own median, so their sum is near the median of the whole, but not equal to it.
struct TimeShare {
  std::string key, name;  // for programs; for people
  double ms = 0;
};
// Returns the stages, longest first: that one is the next bottleneck. Without decoding if nothing was
// decoded; empty if no update was timed.
[[nodiscard]] std::vector<TimeShare> TimeShares(const LoadReport& report);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_REPORT_H_
