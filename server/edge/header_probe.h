// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Threads  any
#ifndef LATTICED_SERVER_EDGE_HEADER_PROBE_H_
#define LATTICED_SERVER_EDGE_HEADER_PROBE_H_

#include "absl/functional/function_ref.h"

namespace latticed {

// Sends a header to a server of gRPC's that is there for nothing else, over a pair of sockets, and
// waits until `seen`. False where that is not within a second.
[[nodiscard]] bool SendHeader(absl::FunctionRef<bool()> seen);

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_HEADER_PROBE_H_
