// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_SERVER_RPC_RESTORE_STORED_H_
#define LATTICED_SERVER_RPC_RESTORE_STORED_H_

#include "absl/status/status.h"

namespace latticed {

struct ServerEnv;

// Brings back what the server's store has: reads all meshes, and names the scenes, which wake when they are called. What is
// damaged is named in the log and left where it is. Called once, before the server serves.
// The store's errors; kResourceExhausted where the meshes do not fit in memory.
[[nodiscard]] absl::Status RestoreStored(ServerEnv& env);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_RESTORE_STORED_H_
