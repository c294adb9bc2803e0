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
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/backend.h"
#include "core/base/mutex.h"
#include "server/base/audit_log.h"
#include "server/base/auth/authenticator.h"
#include "server/base/auth/token_throttle.h"
#include "server/base/options.h"
#include "server/base/process_memory.h"
#include "server/base/quotas/tenant_quotas.h"
#include "server/base/watchdog.h"
#include "server/base/watched_file.h"
#include "server/base/worker_lanes.h"
#include "server/rpc/stalled_calls.h"
#include "server/store/store.h"
#include "server/stores/callers.h"
#include "server/stores/mesh_store.h"
#include "server/stores/share_store.h"

namespace latticed {

class CallCounts;     // server/rpc/call_counts.h
class CpuArena;       // core/view/cpu_arena.h
class SceneRegistry;  // server/stores/scene_registry.h
struct SceneConfig;   // server/engine/scene.h
class UploadStore;    // server/stores/upload_store.h

struct ServerEnv {
  static constexpr absl::Duration kStillTime = absl::Seconds(10);

  // `backends` has at least one; the first one serves. `authenticator` decides who may call. `store` may be null.
  ServerEnv(Options options, std::vector<std::unique_ptr<Backend>> backends,
            Authenticator authenticator, std::shared_ptr<Store> store = nullptr);
  ~ServerEnv();
  ServerEnv(const ServerEnv&) = delete;  // services hold its address
  ServerEnv& operator=(const ServerEnv&) = delete;

  // Runs `work` on a worker of the lane, when it is the caller's turn. The destructor waits for all of it.
  void Post(WorkerLanes::Lane lane, const CallerAccount& caller, std::function<void()> work) {
    workers_->Post(lane, caller.has_share() ? &caller : nullptr, std::move(work));
  }
  // Whether the first call for the scene must make it from its log, which takes long.
  [[nodiscard]] bool IsAsleep(std::string_view scene) const;
  // kUnavailable with the reason when the server does not do its work: the device is lost, or the engine or the
  // workers have not moved for kStillTime.
  [[nodiscard]] absl::Status Health() const;
  [[nodiscard]] Pulse TakePulse() const;
  // Who may call. Replaced when tokens or their keys are read again.
  [[nodiscard]] std::shared_ptr<const Authenticator> authenticator() const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Reads tokens and their keys again. kInvalidArgument if a file cannot be used; what it held stays.
  [[nodiscard]] absl::Status RenewTokens() ABSL_LOCKS_EXCLUDED(renewal_, mutex_);
  // Reads --quota-file. kInvalidArgument if it cannot be used; then the quotas stay.
  [[nodiscard]] absl::Status ReadQuotas() ABSL_LOCKS_EXCLUDED(renewal_);
  // Scenes use the first backend.
  Backend& backend() const { return *backends.front(); }

  const Options options;
  const std::string boot_id;  // 32 random hex digits, new at every start
  const std::string node;     // options.node or the host name
  // The metadata key under which server/web passes the address of its client. It is secret, so that clients
  // cannot set it.
  const std::string peer_key;
  // Servers with the same make the same bytes, if their backends' Arithmetic is the same too: WatcherOptions.
  const std::string evaluator;
  const absl::Time start_time;
  std::stop_source drain;  // stopped once the server drains: streams send goaway and end OK
  const std::unique_ptr<CallCounts> calls;
  const std::shared_ptr<Store> store;  // null: meshes and scenes end with the server
  const std::vector<std::unique_ptr<Backend>> backends;
  const std::unique_ptr<CpuArena> point_arena;  // the threads that evaluate point sets and measure
  Callers callers;
  TokenThrottle wrong_tokens;
  TenantQuotas quotas;
  AuditLog audit;
  StalledCalls stalled_calls;
  const std::shared_ptr<MemoryBudget> memory;
  const std::shared_ptr<MemoryBudget> requests;  // requests that wait for a worker
  const std::shared_ptr<MemoryBudget> replies;   // replies that wait for their client
  MeshStore meshes;
  ShareStore shares;
  HeapTrimmer heap;
  const std::unique_ptr<UploadStore> uploads;
  const std::unique_ptr<SceneRegistry> scenes;  // its thread uses the uploads

 private:
  void KeepHouse();
  // `read` is Renew or ReadKeys of Authenticator.
  [[nodiscard]] absl::Status RenewAuthenticator(absl::Status (Authenticator::*read)(const Options&))
      ABSL_LOCKS_EXCLUDED(renewal_, mutex_);
  [[nodiscard]] absl::StatusOr<StoredMesh> ReadMesh(const std::string& id) const;
  [[nodiscard]] absl::StatusOr<SceneConfig> ConfigOf(std::string_view header);

  WatchedFile jwks_file_, quota_file_;  // used by KeepHouse only
  Mutex renewal_;  // before mutex_: held from reading the files until what they hold counts
  mutable Mutex mutex_;
  std::shared_ptr<const Authenticator> authenticator_ ABSL_GUARDED_BY(mutex_);
  std::optional<WorkerLanes> workers_;  // last: they may use all of the above
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SERVER_ENV_H_
