// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads all of a store in a folder: every mesh with its hash, and every scene, whose history is made again from its log.
// The folder may be in use. Nothing that is kept is changed; SQLite may make its index anew, and an empty log.
//
// Errors   kFailedPrecondition: the folder belongs to another program or to a newer latticed; kNotFound: there is no
//          store; kUnavailable: it cannot be read
// Threads  not in the process of a server that uses the folder: its locks would be lost
#ifndef LATTICED_SERVER_CHECK_STORE_CHECK_H_
#define LATTICED_SERVER_CHECK_STORE_CHECK_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace latticed {

struct StoreFindings {
  uint64_t scenes = 0;
  uint64_t snapshots = 0;
  uint64_t records = 0;  // after the snapshots
  uint64_t meshes = 0;
  uint64_t mesh_bytes = 0;
  uint64_t unknown_files = 0;       // of meshes: a crash left them, or they are being written
  std::vector<std::string> damage;  // one sentence each
};

[[nodiscard]] absl::StatusOr<StoreFindings> CheckStore(const std::string& folder);

}  // namespace latticed

#endif  // LATTICED_SERVER_CHECK_STORE_CHECK_H_
