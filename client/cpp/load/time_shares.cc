// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/time_shares.h"

#include <algorithm>
#include <functional>

namespace latticed::client {

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
