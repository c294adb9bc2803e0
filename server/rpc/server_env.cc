// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/server_env.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <set>
#include <thread>
#include <utility>

#include "absl/functional/function_ref.h"
#include "absl/time/clock.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/view/cpu_arena.h"
#include "core/view/machine.h"
#include "fmt/format.h"
#include "server/base/random_id.h"
#include "server/base/telemetry.h"
#include "server/base/version.h"
#include "server/rpc/call.h"
#include "server/rpc/call_counts.h"
#include "server/stores/scene_registry.h"
#include "server/stores/upload_store.h"
#include "server/wire/stored_mesh.h"
#include "server/wire/stored_scene.h"

namespace latticed {
namespace {

// A worker parses or plans on one thread. More workers would only compete with the backend's threads.
constexpr unsigned kMinLongWorkers = 2, kMaxLongWorkers = 8;
// A quick call takes well below a millisecond.
constexpr unsigned kMinQuickWorkers = 1, kMaxQuickWorkers = 4, kCoresOfQuickWorker = 4;

// Threads that evaluate and encode views. The last one takes only short turns. Each also uses the backend's own
// threads.
constexpr int kRenderWorkers = 3;

std::string HostName() {
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return "unknown";
  return name.data();
}

// Sources that no commit names may be any. A scene goes to any of several devices, whose last bits may differ.
std::string EvaluatorName(const Options& options, const Backend& backend, const std::string& run) {
  std::set<std::string> devices;
  for (const DeviceState& device : backend.devices()) devices.insert(device.name);
  if (Commit() == "unknown" || devices.size() != 1) return run;
  return fmt::format("{} {} {} {} {}", Version(), Commit(), options.encoder, backend.name(),
                     *devices.begin());
}

// Reads again what a file holds if it was replaced. What cannot be read leaves all as it was.
void Reread(WatchedFile& file, const std::string& what, absl::FunctionRef<absl::Status()> read) {
  if (!file.Changed()) return;
  if (const absl::Status status = read(); status.ok()) {
    LogEvent(spdlog::level::info, what + " were read", {{"file", file.path()}});
  } else {
    LogEvent(spdlog::level::err, what + " stay as they were",
             {{"error", std::string(status.message())}});
  }
}

void LogEviction(const Scene& scene, uint64_t bytes) {
  LogEvent(spdlog::level::info, "scene evicted: another needs its memory",
           {{"scene", scene.id()}, {"bytes", fmt::to_string(bytes)}});
}

}  // namespace

ServerEnv::ServerEnv(Options options_in, std::vector<std::unique_ptr<Backend>> backends_in,
                     Authenticator authenticator_in, std::shared_ptr<Store> store_in)
    : options(std::move(options_in)),
      boot_id(NewRandomId()),
      node(options.node.empty() ? HostName() : options.node),
      peer_key("latticed-peer-" + NewRandomId()),
      evaluator(EvaluatorName(options, *backends_in.front(), boot_id)),
      start_time(absl::Now()),
      calls(std::make_unique<CallCounts>()),
      store(std::move(store_in)),
      backends(std::move(backends_in)),
      point_arena(std::make_unique<CpuArena>(AllowedThreads(options.threads))),
      callers(options.caller_share,
              {.memory = options.memory_bytes,
               .requests = options.memory_bytes / limits::kWaitingRequestsShare,
               .replies = options.memory_bytes / limits::kUntakenRepliesShare}),
      audit(options.audit_log),
      memory(std::make_shared<MemoryBudget>(options.memory_bytes)),
      requests(
          std::make_shared<MemoryBudget>(options.memory_bytes / limits::kWaitingRequestsShare)),
      replies(std::make_shared<MemoryBudget>(options.memory_bytes / limits::kUntakenRepliesShare)),
      meshes({.store = store.get(),
              .header_of = [](const StoredMesh& mesh) { return StoredHeaderOf(mesh); },
              .read = [this](const std::string& id) { return ReadMesh(id); }}),
      shares(store.get()),
      uploads(std::make_unique<UploadStore>(memory)),
      scenes(std::make_unique<SceneRegistry>(
          &backend(), kRenderWorkers,
          SceneRegistry::Options{
              .max_scenes = static_cast<size_t>(options.max_scenes),
              .memory = memory,
              .on_tick = [this] { KeepHouse(); },
              .on_tend = [this](absl::Time now) { shares.Tend(now); },
              .on_delete = [this](std::string_view id) { shares.DropScene(id); },
              .store = store.get(),
              .arena = point_arena.get(),
              .config_of = [this](std::string_view header) { return ConfigOf(header); },
              .mesh_of =
                  [](std::string_view header) {
                    return StoredSceneOf(header).value_or(StoredScene()).mesh_id;
                  },
              .idle_ttl_of =
                  [](std::string_view header) {
                    const auto scene = StoredSceneOf(header);
                    return scene.ok() ? scene->idle_ttl : absl::InfiniteDuration();
                  },
              .on_evict = LogEviction})),
      jwks_file_(options.jwks_file),
      quota_file_(options.quota_file),
      authenticator_(std::make_shared<const Authenticator>(std::move(authenticator_in))),
      workers_(std::in_place,
               std::clamp(std::thread::hardware_concurrency() / kCoresOfQuickWorker,
                          kMinQuickWorkers, kMaxQuickWorkers),
               std::clamp(std::thread::hardware_concurrency(), kMinLongWorkers, kMaxLongWorkers)) {}

ServerEnv::~ServerEnv() {
  workers_.reset();
  // What the store answers reaches scenes and streams, which use the rest.
  if (store != nullptr) store->Flush();
}

absl::StatusOr<StoredMesh> ServerEnv::ReadMesh(const std::string& id) const {
  LATTICED_ASSIGN_OR_RETURN(const auto header, store->ReadMeshHeader(id));
  LATTICED_ASSIGN_OR_RETURN(auto bytes, store->ReadMesh(id));
  LATTICED_ASSIGN_OR_RETURN(auto room, memory->Reserve("the mesh", bytes.size(), nullptr));
  LATTICED_ASSIGN_OR_RETURN(
      auto mesh,
      MeshFromStored(header, std::make_shared<const std::string>(std::move(bytes)), room));
  LATTICED_RETURN_IF_ERROR(room.Resize("the mesh", mesh.MemoryBytes()));
  mesh.memory = std::move(room);
  return mesh;
}

absl::StatusOr<SceneConfig> ServerEnv::ConfigOf(std::string_view header) {
  LATTICED_ASSIGN_OR_RETURN(const StoredScene scene, StoredSceneOf(header));
  const auto mesh = meshes.Find(scene.mesh_id);
  if (absl::IsNotFound(mesh.status())) {
    return absl::DataLossError(fmt::format("its mesh {} is missing", scene.mesh_id));
  }
  LATTICED_RETURN_IF_ERROR(mesh.status());
  return SceneConfigFromStored(header, **mesh);
}

// Once a second, on the registry's thread.
void ServerEnv::KeepHouse() {
  const absl::Time now = absl::Now();
  if (store != nullptr) store->SetFreeBytes(memory->free_bytes());
  uploads->DropExpired();
  meshes.DropUnusedSince(now - absl::Seconds(limits::kStoredIdleSeconds));
  heap.Tick();
  LogRefusalSums(*calls, now);
  stalled_calls.CancelSince(now - options.write_timeout);
  wrong_tokens.Forget(now);
  callers.DropUnused();
  Reread(jwks_file_, "the keys of tokens",
         [this] { return RenewAuthenticator(&Authenticator::ReadKeys); });
  Reread(quota_file_, "the quotas of tenants", [this] { return ReadQuotas(); });
  audit.WriteEditsBefore(now - AuditLog::kSilence);
}

absl::Status ServerEnv::ReadQuotas() {
  const MutexLock renewal(&renewal_);
  LATTICED_ASSIGN_OR_RETURN(QuotaTable table, QuotaTable::FromFile(options.quota_file));
  quotas.SetTable(std::move(table));
  return absl::OkStatus();
}

bool ServerEnv::IsAsleep(std::string_view scene) const { return scenes->IsAsleep(scene); }

absl::Status ServerEnv::Health() const {
  LATTICED_RETURN_IF_ERROR(scenes->health().status());
  const absl::Time now = absl::Now();
  if (const absl::Duration still = now - scenes->last_tick(); still > kStillTime) {
    return absl::UnavailableError(
        fmt::format("the engine has not moved for {:.0f} s", absl::ToDoubleSeconds(still)));
  }
  if (const absl::Duration wait = workers_->QuickStill(now); wait > kStillTime) {
    return absl::UnavailableError(fmt::format("no worker has taken a waiting call for {:.0f} s",
                                              absl::ToDoubleSeconds(wait)));
  }
  return absl::OkStatus();
}

Pulse ServerEnv::TakePulse() const {
  return {.engine_ticks = scenes->ticks(),
          .quick_calls = workers_->quick_taken(),
          .quick_calls_wait = workers_->QuickStill(absl::Now()) > absl::Seconds(1)};
}

std::shared_ptr<const Authenticator> ServerEnv::authenticator() const {
  const MutexLock lock(&mutex_);
  return authenticator_;
}

absl::Status ServerEnv::RenewAuthenticator(absl::Status (Authenticator::*read)(const Options&)) {
  const MutexLock renewal(&renewal_);
  auto renewed = std::make_shared<Authenticator>(*authenticator());
  const absl::Status status = (*renewed.*read)(options);
  const MutexLock lock(&mutex_);
  authenticator_ = std::move(renewed);
  return status;
}

absl::Status ServerEnv::RenewTokens() { return RenewAuthenticator(&Authenticator::Renew); }

}  // namespace latticed
