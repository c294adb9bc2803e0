// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_SERVER_RPC_RESTORE_STORED_H_
#define LATTICED_SERVER_RPC_RESTORE_STORED_H_

#include "absl/status/status.h"

namespace latticed {

struct ServerEnv;

// Names the scenes of the server's store, which wake when they are called, and in the log what is damaged. Called once,
// before the server serves. The store's errors.
[[nodiscard]] absl::Status RestoreStored(ServerEnv& env);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_RESTORE_STORED_H_
