// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// All shared state of the server, built once (in_process.cc) and passed by pointer. Services hold a
// ServerEnv* that outlives them.
//
// Threads  options, backends, boot_id, node and peer_key are immutable after Start; the stores lock
// themselves
#ifndef LATTICED_SERVER_RPC_SERVER_ENV_H_
#define LATTICED_SERVER_RPC_SERVER_ENV_H_

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/backend.h"
#include "server/base/drain_signal.h"
#include "server/base/options.h"
#include "server/base/worker_pool.h"
#include "server/stores/mesh_store.h"

namespace latticed {

class Authenticator;  // server/base/auth.h
class CallCounts;     // server/rpc/call_counts.h
class SceneRegistry;  // server/stores/scene_registry.h
class UploadStore;    // server/stores/upload_store.h

struct ServerEnv {
  explicit ServerEnv(Options options);
  ~ServerEnv();
  ServerEnv(const ServerEnv&) = delete;  // services hold its address
  ServerEnv& operator=(const ServerEnv&) = delete;

  // The first one is what scenes use.
  Backend& backend() const { return *backends.front(); }

  const Options options;
  const std::string boot_id;  // 32 random hex digits, new at every start
  const std::string node;     // options.node or the host name
  // Under this metadata key server/web says for whom it calls. Nobody else knows it.
  const std::string peer_key;
  const absl::Time start_time;
  DrainSignal drain;
  const std::unique_ptr<CallCounts> calls;
  std::vector<std::unique_ptr<Backend>> backends;
  std::shared_ptr<const Authenticator> authenticator;
  const std::shared_ptr<MemoryBudget> memory;
  const std::shared_ptr<MemoryBudget> requests;  // that wait for a worker
  const std::shared_ptr<MemoryBudget> replies;   // that wait for their client
  MeshStore meshes;
  std::shared_ptr<UploadStore> uploads;
  std::shared_ptr<SceneRegistry> scenes;  // shared_ptr: its type need not be complete here
  WorkerPool workers;                     // last: its threads may use all of the above
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SERVER_ENV_H_
