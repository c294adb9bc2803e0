// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes by id, watches by id, and the housekeeping of both. With a store, scenes that nobody uses, and those of earlier
// runs, are asleep: the first call that finds one makes it again. Where servers share the store, a scene is claimed
// before it is made, and released when it goes to sleep.
//
// Errors   kNotFound for an unknown id; kUnavailable, reason SCENE_MOVED, for a scene that another server owns
// Threads  safe; no lock is held while a scene is planned, evaluated or destroyed, or the store is waited for
#ifndef LATTICED_SERVER_STORES_SCENE_REGISTRY_H_
#define LATTICED_SERVER_STORES_SCENE_REGISTRY_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/backend.h"
#include "core/base/limits.h"
#include "core/base/mutex.h"
#include "server/engine/scene.h"

namespace latticed {

class WatchControl;  // server/engine/watch_control.h

// The scenes of a mesh. Scenes that are being made are counted, without bytes.
struct MeshUse {
  size_t scenes = 0;
  uint64_t device_bytes = 0;  // of their plans
};

class SceneRegistry {
 public:
  struct Options {
    size_t max_scenes = limits::kDefaultMaxScenes;
    // The budget of all scenes and views, which are evicted when it is short. Null: no limit.
    std::shared_ptr<MemoryBudget> memory;
    // Called by every Tick, with no lock held, for other housekeeping.
    std::function<void()> on_tick;
    // Called about once a second, with no lock held, on a thread that may wait for the store.
    std::function<void(absl::Time now)> on_tend;
    // Called with no lock held when the scene was deleted, or has expired, here.
    std::function<void(std::string_view id)> on_delete;
    // Null: scenes end with the server. Else it outlives the registry.
    Store* store = nullptr;
    // The threads that measure surfaces; it outlives the registry. Null: the callers' own.
    CpuArena* arena = nullptr;
    // The configuration of a stored scene, from its header; and its mesh's id alone, empty if the header is damaged.
    std::function<absl::StatusOr<SceneConfig>(std::string_view header)> config_of;
    std::function<std::string(std::string_view header)> mesh_of;
    // After what time without use a stored scene expires. Null: scenes that are only in a shared store do not.
    std::function<absl::Duration(std::string_view header)> idle_ttl_of;
    // Called with no lock held after a scene was evicted, with the most bytes that this freed.
    std::function<void(const Scene&, uint64_t)> on_evict;
  };
  // `backend` outlives the registry. `workers` threads evaluate and encode.
  SceneRegistry(Backend* backend, int workers) : SceneRegistry(backend, workers, Options()) {}
  SceneRegistry(Backend* backend, int workers, Options options);
  ~SceneRegistry();
  SceneRegistry(const SceneRegistry&) = delete;  // its thread holds its address
  SceneRegistry& operator=(const SceneRegistry&) = delete;

  struct Most {
    static Most Any() { return {}; }
    size_t of_account = std::numeric_limits<size_t>::max();  // scenes that have config.account
    // Asked with the number of scenes that the tenant has; called with the lock held.
    std::function<absl::Status(size_t)> of_tenant = nullptr;
  };
  // Makes the scene of config.id, or returns the one that an equal request (config.fingerprint) made or is
  // making. kAlreadyExists for another request with the id; kResourceExhausted, reason LIMIT_EXCEEDED, for
  // one scene too many; else Scene::Create's errors. `admit`, if given, is asked before a scene is made and
  // may refuse it; DeleteMesh deletes no mesh while it runs. kNotFound when the mesh was deleted by force
  // meanwhile. `most` says how many scenes there may be. `stop` ends waiting and making, and then
  // nothing is left; it is also asked with the lock held.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Scene>> Create(
      SceneConfig config, const std::function<absl::Status()>& admit = nullptr,
      StopCheck stop = NeverStop, const Most& most = Most::Any()) ABSL_LOCKS_EXCLUDED(mutex_);
  // The scene of config.id as `log` left it, which has no records: a copy of another one. In a store it is asleep.
  // kAlreadyExists; the errors of Create and of Scene::Restore.
  [[nodiscard]] absl::Status Restore(SceneConfig config, SceneLog log,
                                     const std::function<absl::Status()>& admit, StopCheck stop,
                                     const Most& most) ABSL_LOCKS_EXCLUDED(mutex_);
  // A scene of the store, which Find wakes. Until then it expires at `expires`.
  void AddAsleep(std::string id, std::string mesh_id, absl::Time expires)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Wakes the scene if it is asleep, which may take a second. kNotFound; kDataLoss and the errors of
  // Scene::Restore.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Scene>> Find(std::string_view id)
      ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] bool IsAsleep(std::string_view id) const ABSL_LOCKS_EXCLUDED(mutex_);
  // What the store keeps of all scenes, in order of id. Empty without a store; the store's errors.
  [[nodiscard]] absl::StatusOr<std::vector<StoredEntry>> Stored() const;
  // Ends the streams of all scenes, lets other servers claim them, and from now on claims none: this server ends. The
  // store is shared. Returns after `patience` at the latest: what a slow store has not done then is done later.
  void Retire(absl::Duration patience) ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends the scene's streams with kNotFound and forgets it. kNotFound; the store's errors, and then the scene
  // stays.
  [[nodiscard]] absl::Status Delete(std::string_view id) ABSL_LOCKS_EXCLUDED(mutex_);
  // In order of id.
  [[nodiscard]] std::vector<std::shared_ptr<Scene>> All() const ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] size_t size() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Scenes that are asleep. Where servers share the store, none is known.
  [[nodiscard]] size_t asleep_count() const ABSL_LOCKS_EXCLUDED(mutex_);
  // The scenes of a tenant, with those that are being made. Where servers share the store, this server's.
  [[nodiscard]] size_t CountOfTenant(std::string_view tenant) const ABSL_LOCKS_EXCLUDED(mutex_);
  // The scenes of a mesh, with those that are being made. Of a shared store: those of all servers.
  [[nodiscard]] MeshUse UseOfMesh(std::string_view mesh_id) const ABSL_LOCKS_EXCLUDED(mutex_);
  // The same for all meshes that have scenes, by id. The store's errors.
  [[nodiscard]] absl::StatusOr<std::map<std::string, MeshUse>> UseOfMeshes() const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // The memory of all scenes, without their meshes, which scenes share.
  [[nodiscard]] MemoryUse memory() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Calls `remove` while no scene of the mesh can be made, so that no scene names a deleted mesh. With `force`
  // its scenes are deleted too, also those that are being made; without it, kFailedPrecondition, reason
  // MESH_IN_USE, if there are any. Else remove's status.
  [[nodiscard]] absl::Status DeleteMesh(std::string_view mesh_id, bool force,
                                        const std::function<absl::Status()>& remove)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Handles time-outs: TickScenes, TendStore. The registry's own threads call those about once a second; tests call it
  // themselves.
  void Tick(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  // Streams by watch id, for ControlWatch. An expired one is kNotFound.
  void AddWatch(std::string id, std::weak_ptr<WatchControl> watch) ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] absl::StatusOr<std::shared_ptr<WatchControl>> FindWatch(std::string_view id) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  // How often the registry's own thread has called TickScenes, and when it did last.
  uint64_t ticks() const { return ticks_.load(); }
  absl::Time last_tick() const { return absl::FromUnixNanos(last_tick_ns_.load()); }
  DeviceHealth& health() { return render_backend_.health(); }
  EngineCounts& counts() { return render_backend_.counts(); }
  RenderQueue& queue() { return queue_; }
  // How often a scene was claimed and made from the store; and how often one was given up, or was lost, to others.
  uint64_t claims() const { return claims_.load(); }
  uint64_t departures() const { return departures_.load(); }
  // How often the lease was lost, and all scenes with it.
  uint64_t leases_lost() const { return leases_lost_.load(); }
  // How often a scene was evicted to free memory for another.
  uint64_t evictions() const { return evictions_.load(); }

 private:
  // An id in creating_, for as long as this is, or until End.
  class Making {
   public:
    Making(SceneRegistry* registry, std::string id) : registry_(registry), id_(std::move(id)) {}
    ~Making() {
      if (registry_ == nullptr) return;
      const MutexLock lock(&registry_->mutex_);
      End();
    }
    Making(const Making&) = delete;  // it ends once
    Making& operator=(const Making&) = delete;

    void End() ABSL_NO_THREAD_SAFETY_ANALYSIS {  // with the lock held
      registry_->creating_.erase(id_);
      registry_ = nullptr;
    }

   private:
    SceneRegistry* registry_;
    const std::string id_;
  };

  // The threads. The first never waits for the store, and the watchdog looks after it.
  void KeepHouse() ABSL_LOCKS_EXCLUDED(mutex_);
  void KeepStore() ABSL_LOCKS_EXCLUDED(mutex_);
  void TickScenes(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);
  // What may wait for the store: scenes go to sleep, and expire.
  void TendStore(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);
  // Scenes of a shared store that no server has had lately.
  void ExpireUnused(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);
  // Waits until nobody makes, wakes or deletes the scene.
  [[nodiscard]] absl::Status AwaitFree(std::string_view id, StopCheck stop)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Scene>> Wake(std::string_view id)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Deletes the scene if `condemned`, which is asked with the lock held, says so.
  [[nodiscard]] absl::Status DeleteIf(std::string_view id, const std::function<bool()>& condemned)
      ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] absl::Status DeleteScenesOf(std::string_view mesh_id) ABSL_LOCKS_EXCLUDED(mutex_);
  // Forgets a lost scene, and with it its plan; it is asleep then.
  void Forget(std::shared_ptr<Scene> lost) ABSL_LOCKS_EXCLUDED(mutex_);
  // Claims the scene and makes it from its log.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Scene>> Restored(const std::string& id);
  [[nodiscard]] absl::Status Claim(const std::string& id);
  // Puts scenes to sleep that nobody has used since `time`.
  void SleepUnusedSince(absl::Time time) ABSL_LOCKS_EXCLUDED(mutex_);
  // The lease is lost: marks all scenes as lost, and leaves the rest to the thread of KeepStore.
  void LoseAll() ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends the streams of all scenes that are lost; or of all scenes, which are then released.
  void LeaveLost() ABSL_LOCKS_EXCLUDED(mutex_);
  void LeaveAll() ABSL_LOCKS_EXCLUDED(mutex_);
  // Takes the scenes out of scenes_, and into creating_ until LetGo has ended.
  std::vector<std::shared_ptr<Scene>> TakeToLeave(
      const std::function<bool(const Scene&)>& condemned) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void LetGo(const std::shared_ptr<Scene>& scene, bool release) ABSL_LOCKS_EXCLUDED(mutex_);
  bool shared() const { return options_.store != nullptr && options_.store->shared(); }
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Scene>> Made(SceneConfig config, StopCheck stop);
  // Keeps a copy. Null where it is asleep.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<Scene>> Copied(SceneConfig config, SceneLog log,
                                                              StopCheck stop);
  // Why one more scene cannot be made of the mesh, for the account.
  [[nodiscard]] absl::Status CheckRoom(const std::string& id, const std::string& mesh_id,
                                       const MemoryAccountPtr& account, const Most& most) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  SceneContext context() { return {&render_backend_, &queue_, options_.store, options_.arena}; }
  // The budget's evictor: evicts scenes that nobody uses, the least recently used first.
  bool Evict(const MemoryShortage& shortage) ABSL_LOCKS_EXCLUDED(mutex_);
  std::vector<std::shared_ptr<Scene>> TakeWhere(const std::function<bool(const Scene&)>& condemned)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  size_t CountLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  size_t CountOfAccountLocked(const MemoryAccountPtr& account) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  size_t CountOfTenantLocked(std::string_view tenant) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  size_t CountOfMeshLocked(std::string_view mesh_id) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Options options_;
  const std::shared_ptr<MemoryBudget> memory_;
  RenderBackend render_backend_;
  std::atomic<uint64_t> evictions_ = 0, claims_ = 0, departures_ = 0, leases_lost_ = 0;
  std::atomic<uint64_t> ticks_ = 0;
  std::atomic<int64_t> last_tick_ns_ = absl::ToUnixNanos(absl::Now());

  mutable Mutex mutex_;
  std::map<std::string, std::shared_ptr<Scene>, std::less<>> scenes_ ABSL_GUARDED_BY(mutex_);
  struct InMaking {
    std::string mesh_id;  // emptied when the mesh was deleted meanwhile
    MemoryAccountPtr account;
  };
  // By id: scenes that are being made, woken or deleted.
  std::map<std::string, InMaking, std::less<>> creating_ ABSL_GUARDED_BY(mutex_);
  struct Sleeper {
    std::string mesh_id;
    absl::Time expires;
    MemoryAccountPtr account = nullptr;  // of who restored it
  };
  std::map<std::string, Sleeper, std::less<>> asleep_ ABSL_GUARDED_BY(mutex_);
  std::set<std::string, std::less<>> going_meshes_ ABSL_GUARDED_BY(mutex_);  // being deleted
  std::map<std::string, std::weak_ptr<WatchControl>, std::less<>> watches_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::atomic<bool> retired_ = false;
  bool must_leave_lost_ ABSL_GUARDED_BY(mutex_) = false;  // by KeepStore, as the next one
  bool must_leave_all_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Time next_sweep_ ABSL_GUARDED_BY(mutex_) = absl::Now();  // by ExpireUnused
  uint64_t leavings_ ABSL_GUARDED_BY(mutex_) = 0;                // calls of LoseAll and LeaveAll
  RenderQueue queue_;                      // last but two: its threads use all of the above
  std::thread housekeeper_, storekeeper_;  // last, for the same reason
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORES_SCENE_REGISTRY_H_
