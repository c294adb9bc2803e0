// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes of a SceneRegistry that are in the store and not in memory: they wake, go to sleep, move to other servers.
#include <utility>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/base/auth/tenant.h"
#include "server/base/telemetry.h"
#include "server/store/store_errors.h"
#include "server/stores/scene_registry.h"

namespace latticed {
namespace {

// Waits until the store has answered all edits of a scene that is lost, so that none comes after the scene is read.
absl::Status AwaitStored(Scene& lost) {
  constexpr absl::Duration kMost = absl::Seconds(2), kPause = absl::Milliseconds(1);
  lost.Leave();
  const absl::Time end = absl::Now() + kMost;
  while (lost.has_pending()) {
    if (absl::Now() > end) return lost.ended();
    absl::SleepFor(kPause);
  }
  return absl::OkStatus();
}

}  // namespace

void SceneRegistry::AddAsleep(std::string id, std::string mesh_id, absl::Time expires) {
  const MutexLock lock(&mutex_);
  asleep_[std::move(id)] = {std::move(mesh_id), expires};
}

size_t SceneRegistry::asleep_count() const {
  const MutexLock lock(&mutex_);
  return asleep_.size();
}

bool SceneRegistry::IsAsleep(std::string_view id) const {
  const MutexLock lock(&mutex_);
  const auto found = scenes_.find(id);
  if (found != scenes_.end()) return found->second->is_lost();
  return asleep_.contains(id) || shared();
}

absl::StatusOr<std::vector<StoredEntry>> SceneRegistry::Stored() const {
  if (options_.store == nullptr) return std::vector<StoredEntry>();
  return options_.store->Scenes();
}

absl::StatusOr<std::shared_ptr<Scene>> SceneRegistry::Wake(std::string_view id) {
  const std::string key(id);
  std::shared_ptr<Scene> lost;
  uint64_t leavings = 0;
  {
    const MutexLock lock(&mutex_);
    LATTICED_RETURN_IF_ERROR(AwaitFree(key, NeverStop));
    const auto found = scenes_.find(key);
    if (found != scenes_.end() && !found->second->is_lost()) return found->second;
    if (found != scenes_.end()) lost = found->second;
    const auto sleeper = asleep_.find(key);
    if (lost == nullptr && sleeper == asleep_.end() && !shared()) {
      return error::NotFound("scene", IdOf(key));
    }
    creating_[key] = {sleeper == asleep_.end() ? "" : sleeper->second.mesh_id, nullptr};
    leavings = leavings_;
  }
  Making making(this, key);
  auto scene = CatchBadAlloc("the scene", [&]() -> absl::StatusOr<std::shared_ptr<Scene>> {
    if (lost != nullptr) {
      LATTICED_RETURN_IF_ERROR(AwaitStored(*lost));
      Forget(std::move(lost));
    }
    return Restored(key);
  });
  if (!scene.ok() && !absl::IsNotFound(scene.status()) && !error::IsSceneMoved(scene.status())) {
    LogEvent(spdlog::level::err, "scene not restored",
             {{"scene", key}, {"status", scene.status().ToString()}});
  }
  if (!scene.ok()) return scene;
  {
    const MutexLock lock(&mutex_);
    if (leavings == leavings_) {
      scenes_[key] = *scene;
      asleep_.erase(key);
      making.End();
      return scene;
    }
  }
  // The lease that it was claimed with is lost, or this server ends.
  (void)options_.store->ReleaseScene(key);
  return error::SceneMoved("");
}

void SceneRegistry::Forget(std::shared_ptr<Scene> lost) {
  const MutexLock lock(&mutex_);
  if (!shared()) asleep_[lost->id()] = {lost->config().mesh_id, lost->expire_time()};
  scenes_.erase(lost->id());
}

absl::StatusOr<std::shared_ptr<Scene>> SceneRegistry::Restored(const std::string& id) {
  LATTICED_RETURN_IF_ERROR(Claim(id));
  const auto restored = [&]() -> absl::StatusOr<std::shared_ptr<Scene>> {
    LATTICED_ASSIGN_OR_RETURN(const auto log, options_.store->ReadScene(id));
    LATTICED_ASSIGN_OR_RETURN(auto config, options_.config_of(log.header));
    return Scene::Restore(std::move(config), log, context());
  };
  auto scene = restored();
  if (!scene.ok()) (void)options_.store->ReleaseScene(id);  // another server may have more memory
  if (absl::IsAborted(scene.status()))
    return error::SceneMoved("");  // claimed by another meanwhile
  if (scene.ok()) ++claims_;
  return scene;
}

absl::Status SceneRegistry::Claim(const std::string& id) {
  if (retired_) return error::SceneMoved("");
  LATTICED_ASSIGN_OR_RETURN(const SceneClaim claim, options_.store->ClaimScene(id));
  return claim.owner.empty() ? absl::OkStatus() : error::SceneMoved(claim.owner);
}

void SceneRegistry::Retire(absl::Duration patience) {
  retired_ = true;
  const MutexLock lock(&mutex_);
  must_leave_all_ = true;
  mutex_.AwaitFor([this]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return !must_leave_all_; }, patience);
}

void SceneRegistry::LoseAll() {
  ++leases_lost_;
  const MutexLock lock(&mutex_);
  ++leavings_;
  for (const auto& [id, scene] : scenes_) scene->Lose().IgnoreError();
  must_leave_lost_ = true;
}

void SceneRegistry::LeaveLost() {
  std::vector<std::shared_ptr<Scene>> gone;
  {
    const MutexLock lock(&mutex_);
    must_leave_lost_ = false;
    gone = TakeToLeave([](const Scene& scene) { return scene.is_lost(); });
  }
  for (const auto& scene : gone) LetGo(scene, /*release=*/false);
}

void SceneRegistry::LeaveAll() {
  std::vector<std::shared_ptr<Scene>> gone;
  {
    const MutexLock lock(&mutex_);
    ++leavings_;
    gone = TakeToLeave([](const Scene&) { return true; });
  }
  for (const auto& scene : gone) LetGo(scene, /*release=*/true);
  const MutexLock lock(&mutex_);
  must_leave_all_ = false;
}

std::vector<std::shared_ptr<Scene>> SceneRegistry::TakeToLeave(
    const std::function<bool(const Scene&)>& condemned) {
  // A lost scene that is being made again is in creating_ already.
  auto gone = TakeWhere([&](const Scene& scene) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    return !creating_.contains(scene.id()) && condemned(scene);
  });
  for (const auto& scene : gone) creating_[scene->id()] = {scene->config().mesh_id, nullptr};
  return gone;
}

void SceneRegistry::SleepUnusedSince(absl::Time time) {
  // A store that refuses writes may let a release wait for long.
  if (options_.store == nullptr || !options_.store->Admit().ok()) return;
  std::vector<std::shared_ptr<Scene>> idle;
  {
    const MutexLock lock(&mutex_);
    // Whoever has another reference uses it, and whoever wants one waits for this lock.
    idle = TakeToLeave([&](const Scene& scene) ABSL_NO_THREAD_SAFETY_ANALYSIS {
      const auto& held = scenes_.find(scene.id())->second;
      // Points that clients keep beside a scene are not stored.
      return held.use_count() == 1 && scene.last_use() < time && scene.point_sets().All().empty();
    });
    for (size_t i = 0; i < idle.size() && !shared(); ++i) {
      asleep_[idle[i]->id()] = {idle[i]->config().mesh_id, idle[i]->expire_time()};
    }
  }
  for (const auto& scene : idle) LetGo(scene, /*release=*/true);
}

void SceneRegistry::LetGo(const std::shared_ptr<Scene>& scene, bool release) {
  const Making making(this, scene->id());
  scene->Leave();
  ++departures_;
  // What could not be released waits for the lease.
  if (release) (void)options_.store->ReleaseScene(scene->id());
}

}  // namespace latticed
