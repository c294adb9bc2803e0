// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What Linux knows of this process. What cannot be read is 0.
#ifndef LATTICED_SERVER_EDGE_PROCESS_STATS_H_
#define LATTICED_SERVER_EDGE_PROCESS_STATS_H_

#include <cstdint>

namespace latticed {

struct ProcessStats {
  double cpu_seconds = 0;
  double start_time_seconds = 0;  // since the epoch
  uint64_t resident_bytes = 0, virtual_bytes = 0;
  uint64_t open_files = 0, max_files = 0;
  uint64_t threads = 0;
};

[[nodiscard]] ProcessStats ReadProcessStats();

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_PROCESS_STATS_H_
