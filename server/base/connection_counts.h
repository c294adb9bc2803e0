// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The connections of a port.
#ifndef LATTICED_SERVER_BASE_CONNECTION_COUNTS_H_
#define LATTICED_SERVER_BASE_CONNECTION_COUNTS_H_

#include <cstddef>
#include <cstdint>

namespace latticed {

struct ConnectionCounts {
  size_t open = 0;
  size_t most = 0;       // MostConnections; 0: no limit
  uint64_t refused = 0;  // since the start, because there were too many
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_CONNECTION_COUNTS_H_
