// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/stores/scene_registry.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/base/telemetry.h"
#include "server/engine/memory/eviction.h"
#include "server/engine/watch_control.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr uint64_t kUnlimited = std::numeric_limits<uint64_t>::max();
// How often a call that waits for another call to make the scene checks whether it must stop.
constexpr absl::Duration kStopCheckInterval = absl::Milliseconds(50);

uint64_t DeviceBytesOf(const Scene& scene) { return DeviceBytes(scene.Head().target->memory()); }

}  // namespace

SceneRegistry::SceneRegistry(Backend* backend, int workers, Options options)
    : options_(std::move(options)),
      memory_(options_.memory != nullptr ? options_.memory
                                         : std::make_shared<MemoryBudget>(kUnlimited)),
      render_backend_(backend, memory_),
      queue_(workers),
      housekeeper_([this] { KeepHouse(); }),
      storekeeper_([this] { KeepStore(); }) {
  memory_->SetEvictor([this](const MemoryShortage& shortage) { return Evict(shortage); });
  if (shared()) options_.store->OnFenced([this] { LoseAll(); });
}

SceneRegistry::~SceneRegistry() {
  if (shared()) options_.store->OnFenced(nullptr);
  memory_->SetEvictor(nullptr);
  {
    const MutexLock lock(&mutex_);
    stopping_ = true;
  }
  housekeeper_.join();
  storekeeper_.join();
}

bool SceneRegistry::Evict(const MemoryShortage& shortage) {
  const auto scenes = All();
  std::vector<EvictionCandidate> candidates;
  candidates.reserve(scenes.size());
  for (const auto& scene : scenes) {
    candidates.push_back({scene->EvictableBytes(shortage), scene->last_use()});
  }
  bool evicted = false;
  for (const size_t victim : ChooseVictims(candidates, shortage.bytes)) {
    if (!scenes[victim]->Evict()) continue;
    evicted = true;
    ++evictions_;
    if (options_.on_evict != nullptr) options_.on_evict(*scenes[victim], candidates[victim].bytes);
  }
  return evicted;
}

absl::Status SceneRegistry::AwaitFree(std::string_view id, StopCheck stop) {
  const auto free = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !creating_.contains(id); };
  while (!mutex_.AwaitFor(free, kStopCheckInterval)) {
    LATTICED_RETURN_IF_ERROR(stop());
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<Scene>> SceneRegistry::Create(
    SceneConfig config, const std::function<absl::Status()>& admit, StopCheck stop,
    const Most& most) {
  const std::string id = config.id;
  const std::string mesh_id = config.mesh_id;
  uint64_t leavings = 0;
  if (options_.store != nullptr) {  // wakes the scene of an equal request
    const auto found = Find(id).status();
    if (absl::IsUnavailable(found)) return found;
  }
  {
    const MutexLock lock(&mutex_);
    // A client that retries should get the scene, not an error, so its call waits for the first one.
    LATTICED_RETURN_IF_ERROR(AwaitFree(id, stop));
    if (const auto found = scenes_.find(id); found != scenes_.end()) {
      if (found->second->config().fingerprint == config.fingerprint) return found->second;
      return error::AlreadyExists("scene", IdOf(id));
    }
    if (asleep_.contains(id)) return error::AlreadyExists("scene", IdOf(id));
    LATTICED_RETURN_IF_ERROR(CheckRoom(id, mesh_id, config.account, most));
    if (admit != nullptr) {
      LATTICED_RETURN_IF_ERROR(admit());
    }
    creating_[id] = {mesh_id, config.account};
    leavings = leavings_;
  }
  Making making(this, id);
  auto scene = Made(std::move(config), stop);
  bool mesh_lives = false;
  {
    const MutexLock lock(&mutex_);
    mesh_lives = creating_[id].mesh_id == mesh_id;
    const bool stays = mesh_lives && leavings == leavings_;
    if (scene.ok() && stays) scenes_[id] = *scene;
    making.End();
    if (!scene.ok() || stays) return scene;
  }
  if (mesh_lives) {  // the lease was lost meanwhile, or this server ends
    (void)options_.store->ReleaseScene(id);
    return error::SceneMoved("");
  }
  if (options_.store != nullptr) {
    LATTICED_RETURN_IF_ERROR(options_.store->DeleteScene(id));
  }
  return error::NotFound("mesh", IdOf(mesh_id));
}

absl::Status SceneRegistry::CheckRoom(const std::string& id, const std::string& mesh_id,
                                      const MemoryAccountPtr& account, const Most& most) const {
  if (CountLocked() >= options_.max_scenes) {
    return error::LimitExceeded("scenes", options_.max_scenes);
  }
  if (CountOfAccountLocked(account) >= most.of_account) {
    return error::LimitExceeded("scenes of one caller", most.of_account);
  }
  if (most.of_tenant != nullptr) {
    LATTICED_RETURN_IF_ERROR(most.of_tenant(CountOfTenantLocked(TenantOf(id))));
  }
  if (going_meshes_.contains(mesh_id)) return error::NotFound("mesh", IdOf(mesh_id));
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<Scene>> SceneRegistry::Made(SceneConfig config, StopCheck stop) {
  const std::string id = config.id;
  std::string header;
  if (options_.store != nullptr) header.swap(config.stored_header);  // it is kept there
  LATTICED_ASSIGN_OR_RETURN(auto scene, CatchBadAlloc("the scene", [&] {
                              return Scene::Create(std::move(config), context(), stop);
                            }));
  if (options_.store != nullptr) {
    LATTICED_RETURN_IF_ERROR(options_.store->CreateScene(id, std::move(header)));
  }
  return scene;
}

absl::StatusOr<std::shared_ptr<Scene>> SceneRegistry::Find(std::string_view id) {
  {
    const MutexLock lock(&mutex_);
    const auto found = scenes_.find(id);
    if (found != scenes_.end() && !found->second->is_lost()) return found->second;
    if (found == scenes_.end() && !asleep_.contains(id) && !shared()) {
      return error::NotFound("scene", IdOf(id));
    }
  }
  return Wake(id);
}

absl::Status SceneRegistry::Delete(std::string_view id) {
  return DeleteIf(id, [] { return true; });
}

absl::Status SceneRegistry::DeleteIf(std::string_view id, const std::function<bool()>& condemned) {
  const std::string key(id);
  std::shared_ptr<Scene> scene;
  {
    const MutexLock lock(&mutex_);
    LATTICED_RETURN_IF_ERROR(AwaitFree(key, NeverStop));
    const auto found = scenes_.find(key);
    if (found == scenes_.end() && !asleep_.contains(key) && !shared()) {
      return error::NotFound("scene", IdOf(key));
    }
    if (!condemned()) return absl::OkStatus();
    if (found != scenes_.end()) scene = found->second;
    creating_[key] = {};
  }
  Making making(this, key);
  absl::Status status;
  if (options_.store != nullptr) {
    status = Claim(key);
    if (status.ok()) status = options_.store->DeleteScene(key);
  }
  // Before another scene can have the id: what is being applied must not reach its log.
  if (status.ok() && scene != nullptr) scene->Delete();
  if (status.ok() && options_.on_delete != nullptr) options_.on_delete(key);
  const MutexLock lock(&mutex_);
  making.End();
  if (!status.ok()) return status;
  asleep_.erase(key);
  scenes_.erase(key);
  return absl::OkStatus();
}

std::vector<std::shared_ptr<Scene>> SceneRegistry::All() const {
  std::vector<std::shared_ptr<Scene>> all;
  const MutexLock lock(&mutex_);
  for (const auto& [id, scene] : scenes_) all.push_back(scene);
  return all;
}

size_t SceneRegistry::size() const {
  const MutexLock lock(&mutex_);
  return scenes_.size();
}

MeshUse SceneRegistry::UseOfMesh(std::string_view mesh_id) const {
  if (shared()) {
    const auto all = UseOfMeshes();
    if (!all.ok()) return {};
    const auto found = all->find(std::string(mesh_id));
    return found == all->end() ? MeshUse() : found->second;
  }
  const MutexLock lock(&mutex_);
  MeshUse use{.scenes = CountOfMeshLocked(mesh_id)};
  for (const auto& [id, scene] : scenes_) {
    if (scene->config().mesh_id == mesh_id) use.device_bytes += DeviceBytesOf(*scene);
  }
  return use;
}

absl::StatusOr<std::map<std::string, MeshUse>> SceneRegistry::UseOfMeshes() const {
  std::map<std::string, MeshUse> uses;
  const bool of_store = shared();
  if (of_store) {
    LATTICED_ASSIGN_OR_RETURN(const auto stored, Stored());
    for (const StoredEntry& entry : stored) ++uses[options_.mesh_of(entry.header)].scenes;
  }
  const MutexLock lock(&mutex_);
  for (const auto& [id, scene] : scenes_) {
    MeshUse& use = uses[scene->config().mesh_id];
    if (!of_store) ++use.scenes;
    use.device_bytes += DeviceBytesOf(*scene);
  }
  if (of_store) return uses;
  for (const auto& [id, sleeper] : asleep_) ++uses[sleeper.mesh_id].scenes;
  for (const auto& [id, in_making] : creating_) {
    if (!asleep_.contains(id)) ++uses[in_making.mesh_id].scenes;
  }
  return uses;
}

MemoryUse SceneRegistry::memory() const {
  MemoryUse total;
  for (const auto& scene : All()) {
    for (const auto& [purpose, bytes] : scene->memory()) total[purpose] += bytes;
  }
  total.erase("mesh");
  return total;
}

size_t SceneRegistry::CountLocked() const {
  const auto in_making = std::ranges::count_if(creating_, [&](const auto& c) {
    return !scenes_.contains(c.first) && !asleep_.contains(c.first);
  });
  return scenes_.size() + asleep_.size() + static_cast<size_t>(in_making);
}

size_t SceneRegistry::CountOfAccountLocked(const MemoryAccountPtr& account) const {
  const auto made = std::ranges::count(scenes_, account,
                                       [](const auto& s) { return s.second->config().account; });
  const auto in_making =
      std::ranges::count(creating_, account, [](const auto& c) { return c.second.account; });
  const auto restored =
      std::ranges::count(asleep_, account, [](const auto& s) { return s.second.account; });
  return static_cast<size_t>(made + in_making + (account == nullptr ? 0 : restored));
}

size_t SceneRegistry::CountOfTenant(std::string_view tenant) const {
  const MutexLock lock(&mutex_);
  return CountOfTenantLocked(tenant);
}

size_t SceneRegistry::CountOfTenantLocked(std::string_view tenant) const {
  const auto of_tenant = [tenant](const auto& entry) { return TenantOf(entry.first) == tenant; };
  const auto in_making = std::ranges::count_if(creating_, [&](const auto& c) {
    return of_tenant(c) && !scenes_.contains(c.first) && !asleep_.contains(c.first);
  });
  return static_cast<size_t>(std::ranges::count_if(scenes_, of_tenant) +
                             std::ranges::count_if(asleep_, of_tenant) + in_making);
}

size_t SceneRegistry::CountOfMeshLocked(std::string_view mesh_id) const {
  const auto made = std::ranges::count_if(
      scenes_, [mesh_id](const auto& s) { return s.second->config().mesh_id == mesh_id; });
  const auto asleep =
      std::ranges::count(asleep_, mesh_id, [](const auto& s) { return s.second.mesh_id; });
  const auto in_making = std::ranges::count_if(creating_, [&](const auto& c) {
    return c.second.mesh_id == mesh_id && !asleep_.contains(c.first);
  });
  return static_cast<size_t>(made + asleep + in_making);
}

absl::Status SceneRegistry::DeleteMesh(std::string_view mesh_id, bool force,
                                       const std::function<absl::Status()>& remove) {
  if (force && options_.store != nullptr) {
    LATTICED_RETURN_IF_ERROR(DeleteScenesOf(mesh_id));
  }
  const size_t stored = shared() ? UseOfMesh(mesh_id).scenes : 0;
  {
    const MutexLock lock(&mutex_);
    const size_t scenes = std::max(stored, CountOfMeshLocked(mesh_id));
    if (scenes > 0 && !force) {
      return error::FailedPrecondition(
          "MESH_IN_USE",
          fmt::format("{} scene(s) use the mesh; delete them first, or set force", scenes));
    }
    if (!going_meshes_.emplace(mesh_id).second) return error::NotFound("mesh", IdOf(mesh_id));
  }
  const absl::Status removed = remove();  // without the lock: it may wait for the store
  std::vector<std::shared_ptr<Scene>> gone;
  {
    const MutexLock lock(&mutex_);
    going_meshes_.erase(going_meshes_.find(mesh_id));
    LATTICED_RETURN_IF_ERROR(removed);
    for (auto& [id, in_making] : creating_) {
      if (in_making.mesh_id == mesh_id) in_making.mesh_id.clear();
    }
    gone = TakeWhere([mesh_id](const Scene& s) { return s.config().mesh_id == mesh_id; });
  }
  for (const auto& scene : gone) {
    scene->Delete();
    if (options_.store != nullptr) (void)options_.store->DeleteScene(scene->id());
    if (options_.on_delete != nullptr) options_.on_delete(scene->id());
  }
  return absl::OkStatus();
}

absl::Status SceneRegistry::DeleteScenesOf(std::string_view mesh_id) {
  std::vector<std::string> ids;
  LATTICED_ASSIGN_OR_RETURN(const auto stored, Stored());
  for (const StoredEntry& entry : stored) {
    if (options_.mesh_of(entry.header) == mesh_id) ids.push_back(entry.id);
  }
  // All of them or none: another server's scene cannot be deleted here.
  for (size_t i = 0; i < ids.size() && shared(); ++i) {
    const absl::Status claimed = Claim(ids[i]);
    if (error::IsSceneMoved(claimed)) {
      return error::FailedPrecondition(
          "MESH_IN_USE", fmt::format("scene '{}' uses the mesh, on server '{}'; delete it first",
                                     IdOf(ids[i]), error::DetailsOf(claimed).metadata["owner"]));
    }
    if (!claimed.ok() && !absl::IsNotFound(claimed)) return claimed;
  }
  for (const std::string& id : ids) {
    const absl::Status status = Delete(id);
    if (!status.ok() && !absl::IsNotFound(status)) return status;
  }
  return absl::OkStatus();
}

std::vector<std::shared_ptr<Scene>> SceneRegistry::TakeWhere(
    const std::function<bool(const Scene&)>& condemned) {
  std::vector<std::shared_ptr<Scene>> gone;
  std::erase_if(scenes_, [&](const auto& entry) {
    if (!condemned(*entry.second)) return false;
    gone.push_back(entry.second);
    return true;
  });
  return gone;
}

void SceneRegistry::AddWatch(std::string id, std::weak_ptr<WatchControl> watch) {
  const MutexLock lock(&mutex_);
  watches_[std::move(id)] = std::move(watch);
}

absl::StatusOr<std::shared_ptr<WatchControl>> SceneRegistry::FindWatch(std::string_view id) const {
  const MutexLock lock(&mutex_);
  const auto found = watches_.find(id);
  auto watch = found == watches_.end() ? nullptr : found->second.lock();
  if (watch == nullptr) return error::NotFound("watch", IdOf(id));
  return watch;
}

}  // namespace latticed
