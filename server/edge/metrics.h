// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What Prometheus scrapes: GET /metrics of the admin listener.
//
//   ServerInfo, stores   gauges: memory, scenes, watchers, …      collected at the scrape
//   EngineCounts         edits, updates, stages                   counted where they happen
//   StoreCounts          records, commits, the medium's state     likewise; only with a store
//   CallCounts           calls, latencies, refusals               likewise
//   /proc/self           process_…, under the names that all Prometheus clients use
//
// No label takes a value that clients choose: a server has some hundred series for its rpcs, and
// some more for each of its devices, however many scenes there are.
//
// Units    in the names: seconds, bytes; what ends in _total only rises
// Threads  safe; takes the locks of stores and scenes, one at a time, and of none of the streams
#ifndef LATTICED_SERVER_EDGE_METRICS_H_
#define LATTICED_SERVER_EDGE_METRICS_H_

#include <string>

#include "server/base/connection_counts.h"

namespace latticed {

struct ServerEnv;

// All metrics of the server in Prometheus' text format. The arguments count the connections of --listen and
// of --http.
[[nodiscard]] std::string MetricsText(ServerEnv& env, const ConnectionCounts& grpc,
                                      const ConnectionCounts& http);

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_METRICS_H_
