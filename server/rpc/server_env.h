// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// All shared state of the server, built once (in_process.cc) and passed by pointer. Services hold a
// ServerEnv* that outlives them.
//
// Threads  safe: members are immutable or lock themselves
#ifndef LATTICED_SERVER_RPC_SERVER_ENV_H_
#define LATTICED_SERVER_RPC_SERVER_ENV_H_

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "absl/time/time.h"
#include "core/backend.h"
#include "server/base/auth.h"
#include "server/base/options.h"
#include "server/stores/mesh_store.h"

namespace boost::asio {
class thread_pool;
}

namespace latticed {

class CallCounts;     // server/rpc/call_counts.h
class SceneRegistry;  // server/stores/scene_registry.h
class UploadStore;    // server/stores/upload_store.h

struct ServerEnv {
  // `backends` has at least one; the first one serves. `authenticator` decides who may call.
  ServerEnv(Options options, std::vector<std::unique_ptr<Backend>> backends,
            Authenticator authenticator);
  ~ServerEnv();
  ServerEnv(const ServerEnv&) = delete;  // services hold its address
  ServerEnv& operator=(const ServerEnv&) = delete;

  // Runs `work`, which may take long, on a worker. The destructor waits for all of it.
  void Post(std::function<void()> work);
  // Scenes use the first backend.
  Backend& backend() const { return *backends.front(); }

  const Options options;
  const std::string boot_id;  // 32 random hex digits, new at every start
  const std::string node;     // options.node or the host name
  // The metadata key under which server/web passes the address of its client. It is secret, so that clients
  // cannot set it.
  const std::string peer_key;
  const std::string token_key;  // of resume tokens; secret, new at every start
  const absl::Time start_time;
  std::stop_source drain;  // stopped once the server drains: streams send goaway and end OK
  const std::unique_ptr<CallCounts> calls;
  const std::vector<std::unique_ptr<Backend>> backends;
  const Authenticator authenticator;
  const std::shared_ptr<MemoryBudget> memory;
  const std::shared_ptr<MemoryBudget> requests;  // requests that wait for a worker
  const std::shared_ptr<MemoryBudget> replies;   // replies that wait for their client
  MeshStore meshes;
  const std::unique_ptr<UploadStore> uploads;
  const std::unique_ptr<SceneRegistry> scenes;  // its thread uses the uploads

 private:
  const std::unique_ptr<boost::asio::thread_pool> workers_;  // last: they may use all of the above
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SERVER_ENV_H_
