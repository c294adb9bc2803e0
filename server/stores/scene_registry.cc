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
#include "server/engine/memory/eviction.h"
#include "server/engine/watch_control.h"

namespace latticed {
namespace {

constexpr uint64_t kUnlimited = std::numeric_limits<uint64_t>::max();
constexpr absl::Duration kTickInterval = absl::Seconds(1);
// How often a call that waits for another call to make the scene checks whether it must stop.
constexpr absl::Duration kStopCheckInterval = absl::Milliseconds(50);

}  // namespace

SceneRegistry::SceneRegistry(Backend* backend, int workers, Options options)
    : options_(std::move(options)),
      memory_(options_.memory != nullptr ? options_.memory
                                         : std::make_shared<MemoryBudget>(kUnlimited)),
      render_backend_(backend, memory_),
      queue_(workers),
      housekeeper_([this] { KeepHouse(); }) {
  memory_->SetEvictor([this](const MemoryShortage& shortage) { return Evict(shortage); });
}

SceneRegistry::~SceneRegistry() {
  memory_->SetEvictor(nullptr);
  {
    const MutexLock lock(&mutex_);
    stopping_ = true;
  }
  housekeeper_.join();
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

void SceneRegistry::KeepHouse() {
  while (true) {
    {
      const MutexLock lock(&mutex_);
      const auto stopping = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopping_; };
      if (mutex_.AwaitFor(stopping, kTickInterval)) return;
    }
    Tick(absl::Now());
    last_tick_ns_ = absl::ToUnixNanos(absl::Now());
    ++ticks_;
  }
}

absl::StatusOr<std::shared_ptr<Scene>> SceneRegistry::Create(
    SceneConfig config, const std::function<absl::Status()>& admit, StopCheck stop,
    size_t most_of_account) {
  const std::string id = config.id;
  const std::string mesh_id = config.mesh_id;
  {
    const MutexLock lock(&mutex_);
    // A client that retries should get the scene, not an error, so its call waits for the first one.
    const auto free = [&]()
                          ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !creating_.contains(id); };
    while (!mutex_.AwaitFor(free, kStopCheckInterval)) {
      LATTICED_RETURN_IF_ERROR(stop());
    }
    if (const auto found = scenes_.find(id); found != scenes_.end()) {
      if (found->second->config().fingerprint == config.fingerprint) return found->second;
      return error::AlreadyExists("scene", id);
    }
    if (scenes_.size() + creating_.size() >= options_.max_scenes) {
      return error::LimitExceeded("scenes", options_.max_scenes);
    }
    if (CountOfAccountLocked(config.account) >= most_of_account) {
      return error::LimitExceeded("scenes of one caller", most_of_account);
    }
    if (admit != nullptr) {
      LATTICED_RETURN_IF_ERROR(admit());
    }
    creating_[id] = {mesh_id, config.account};
  }
  auto scene = CatchBadAlloc("the scene", [&] {
    return Scene::Create(std::move(config), {&render_backend_, &queue_}, stop);
  });
  const MutexLock lock(&mutex_);
  const bool mesh_lives = creating_[id].mesh_id == mesh_id;
  creating_.erase(id);
  if (!scene.ok()) return scene;
  if (!mesh_lives) return error::NotFound("mesh", mesh_id);
  scenes_[id] = *scene;
  return scene;
}

absl::StatusOr<std::shared_ptr<Scene>> SceneRegistry::Find(std::string_view id) const {
  const MutexLock lock(&mutex_);
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return error::NotFound("scene", id);
  return found->second;
}

absl::Status SceneRegistry::Delete(std::string_view id) {
  std::shared_ptr<Scene> scene;
  {
    const MutexLock lock(&mutex_);
    const auto found = scenes_.find(id);
    if (found == scenes_.end()) return error::NotFound("scene", id);
    scene = std::move(found->second);
    scenes_.erase(found);
  }
  scene->Delete();
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
  const MutexLock lock(&mutex_);
  MeshUse use{.scenes = CountOfMeshLocked(mesh_id)};
  for (const auto& [id, scene] : scenes_) {
    if (scene->config().mesh_id != mesh_id) continue;
    use.device_bytes += DeviceBytes(scene->Head().target->memory());
  }
  return use;
}

MemoryUse SceneRegistry::memory() const {
  MemoryUse total;
  for (const auto& scene : All()) {
    for (const auto& [purpose, bytes] : scene->memory()) total[purpose] += bytes;
  }
  total.erase("mesh");
  return total;
}

size_t SceneRegistry::CountOfAccountLocked(const MemoryAccountPtr& account) const {
  const auto made = std::ranges::count(scenes_, account,
                                       [](const auto& s) { return s.second->config().account; });
  const auto in_making =
      std::ranges::count(creating_, account, [](const auto& c) { return c.second.account; });
  return static_cast<size_t>(made + in_making);
}

size_t SceneRegistry::CountOfMeshLocked(std::string_view mesh_id) const {
  const auto made = std::ranges::count_if(
      scenes_, [mesh_id](const auto& s) { return s.second->config().mesh_id == mesh_id; });
  const auto in_making =
      std::ranges::count(creating_, mesh_id, [](const auto& c) { return c.second.mesh_id; });
  return static_cast<size_t>(made + in_making);
}

absl::Status SceneRegistry::DeleteMesh(std::string_view mesh_id, bool force,
                                       const std::function<absl::Status()>& remove) {
  std::vector<std::shared_ptr<Scene>> gone;
  {
    const MutexLock lock(&mutex_);
    if (const size_t scenes = CountOfMeshLocked(mesh_id); scenes > 0 && !force) {
      return error::FailedPrecondition(
          "MESH_IN_USE",
          fmt::format("{} scene(s) use the mesh; delete them first, or set force", scenes));
    }
    LATTICED_RETURN_IF_ERROR(remove());
    for (auto& [id, in_making] : creating_) {
      if (in_making.mesh_id == mesh_id) in_making.mesh_id.clear();
    }
    gone = TakeWhere([mesh_id](const Scene& s) { return s.config().mesh_id == mesh_id; });
  }
  for (const auto& scene : gone) scene->Delete();
  return absl::OkStatus();
}

void SceneRegistry::Tick(absl::Time now) {
  for (const auto& scene : All()) scene->Tick(now);
  if (options_.on_tick != nullptr) options_.on_tick();
  std::vector<std::shared_ptr<Scene>> gone;
  {
    const MutexLock lock(&mutex_);
    gone = TakeWhere([now](const Scene& scene) { return scene.expire_time() <= now; });
    std::erase_if(watches_, [](const auto& watch) { return watch.second.expired(); });
  }
  for (const auto& scene : gone) scene->Delete();
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
  if (watch == nullptr) return error::NotFound("watch", id);
  return watch;
}

}  // namespace latticed
