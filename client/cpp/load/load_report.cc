// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_report.h"

#include <algorithm>
#include <functional>

namespace latticed::client {

void StreamGroup::Add(const UpdateLog& log, std::span<const TimedEdit> edits,
                      uint64_t first_revision) {
  ++streams;
  size_t next = 0;
  for (const LoggedUpdate& update : log.updates()) {
    if (update.revision <= first_revision) continue;
    ++updates;
    bytes += update.bytes;
    const size_t first = next;
    for (; next < edits.size() && edits[next].revision <= update.revision; ++next) {
      first_chunk.Add(update.first_chunk - edits[next].due);
      update_end.Add(update.end - edits[next].due);
      if (update.decoded > update.end) decoded.Add(update.decoded - edits[next].due);
    }
    if (next > first) merged += next - first - 1;
  }
  unseen += edits.size() - next;
  restarted += static_cast<uint64_t>(std::ranges::count_if(
      log.restarts(), [first_revision](uint64_t r) { return r > first_revision; }));
}

void ServerStages::Add(const UpdateLog& log, std::span<const AppliedBatch> batches,
                       uint64_t first_revision) {
  for (const AppliedBatch& batch : batches) apply.Add(batch.apply_time);
  uint64_t newest = first_revision;
  for (const LoggedUpdate& update : log.updates()) {
    if (update.revision <= first_revision) continue;
    const absl::Duration applied_to_begin = absl::Microseconds(update.timings.queue_us());
    const auto batch =
        std::ranges::lower_bound(batches, update.revision, {}, &AppliedBatch::revision);
    const bool made_it = batch != batches.end() && batch->revision == update.revision;
    // Skips a revision that comes again in more detail.
    if (made_it && update.revision > newest) {
      arrival_to_bytes.Add(batch->apply_time + applied_to_begin);
    }
    newest = update.revision;
    queue.Add(applied_to_begin);
    evaluate.Add(absl::Microseconds(update.timings.evaluate_us()));
    encode.Add(absl::Microseconds(update.timings.encode_us()));
    send.Add(absl::Microseconds(update.timings.send_us()));
  }
}

std::vector<TimeShare> TimeShares(const LoadReport& report) {
  const auto median = [](const LatencyRecorder& recorder) { return recorder.Summarise().p50; };
  const ServerStages& stages = report.stages;
  if (stages.queue.count() == 0 || report.editors.update_end.count() == 0) return {};
  const double apply = median(stages.apply), queue = median(stages.queue);
  const double evaluate = median(stages.evaluate), encode = median(stages.encode);
  const double send = median(stages.send), end = median(report.editors.update_end);
  std::vector<TimeShare> shares{
      {"apply", "applying", apply},
      {"wait", "waiting for a turn", std::max(queue - evaluate - encode, 0.0)},
      {"evaluate", "evaluating", evaluate},
      {"encode", "encoding", encode},
      {"send", "sending", send},
      {"way", "on the way", std::max(end - apply - queue - send, 0.0)}};
  if (report.editors.decoded.count() > 0) {
    shares.push_back({"decode", "decoding", std::max(median(report.editors.decoded) - end, 0.0)});
  }
  std::ranges::stable_sort(shares, std::greater(), &TimeShare::ms);
  return shares;
}

}  // namespace latticed::client
