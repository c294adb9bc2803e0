// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The threads of a SceneRegistry, and what they do about once a second.
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "server/stores/scene_registry.h"

namespace latticed {
namespace {

constexpr absl::Duration kTickInterval = absl::Seconds(1);
// How often a list of all stored scenes is read. They have been unused for as long before they leave memory.
constexpr absl::Duration kSweepInterval = absl::Minutes(10);

}  // namespace

void SceneRegistry::KeepHouse() {
  while (true) {
    {
      const MutexLock lock(&mutex_);
      const auto stopping = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopping_; };
      if (mutex_.AwaitFor(stopping, kTickInterval)) return;
    }
    TickScenes(absl::Now());
    last_tick_ns_ = absl::ToUnixNanos(absl::Now());
    ++ticks_;
  }
}

void SceneRegistry::KeepStore() {
  const auto called = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stopping_ || must_leave_lost_ || must_leave_all_;
  };
  while (true) {
    bool lost = false, all = false;
    {
      const MutexLock lock(&mutex_);
      mutex_.AwaitFor(called, kTickInterval);
      if (stopping_) return;
      lost = must_leave_lost_;
      all = must_leave_all_;
    }
    if (lost) LeaveLost();
    if (all) LeaveAll();
    if (!lost && !all) TendStore(absl::Now());
  }
}

void SceneRegistry::Tick(absl::Time now) {
  TickScenes(now);
  TendStore(now);
}

void SceneRegistry::TickScenes(absl::Time now) {
  for (const auto& scene : All()) scene->Tick(now);
  if (options_.on_tick != nullptr) options_.on_tick();
  const MutexLock lock(&mutex_);
  std::erase_if(watches_, [](const auto& watch) { return watch.second.expired(); });
}

void SceneRegistry::TendStore(absl::Time now) {
  SleepUnusedSince(now - absl::Seconds(limits::kStoredIdleSeconds));
  ExpireUnused(now);
  std::vector<std::string> expired;
  const auto is_expired = [this, now](const std::string& id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (const auto scene = scenes_.find(id); scene != scenes_.end()) {
      return !scene->second->is_lost() && scene->second->expire_time() <= now;
    }
    const auto sleeper = asleep_.find(id);
    return sleeper != asleep_.end() && sleeper->second.expires <= now;
  };
  {
    const MutexLock lock(&mutex_);
    for (const auto& [id, scene] : scenes_) {
      if (is_expired(id)) expired.push_back(id);
    }
    for (const auto& [id, sleeper] : asleep_) {
      if (is_expired(id)) expired.push_back(id);
    }
  }
  for (const std::string& id : expired) {
    // Somebody may use it again meanwhile. What the store cannot delete now expires again with the next tick.
    const auto condemned = [&]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return is_expired(id); };
    (void)DeleteIf(id, condemned);
  }
  if (options_.on_tend != nullptr) options_.on_tend(now);
}

void SceneRegistry::ExpireUnused(absl::Time now) {
  if (!shared() || options_.idle_ttl_of == nullptr || retired_) return;
  {
    const MutexLock lock(&mutex_);
    if (now < next_sweep_) return;
    next_sweep_ = now + kSweepInterval;
  }
  const auto stored = Stored();
  if (!stored.ok()) return;  // the next sweep is soon enough
  for (const StoredEntry& entry : *stored) {
    if (!entry.damage.ok() || entry.unused == absl::ZeroDuration()) continue;
    const absl::Duration idle_ttl = options_.idle_ttl_of(entry.header);
    if (entry.unused < idle_ttl) continue;
    {
      const MutexLock lock(&mutex_);
      if (scenes_.contains(entry.id) || !creating_.try_emplace(entry.id).second) continue;
    }
    const Making deleting(this, entry.id);
    options_.store->ExpireScene(entry.id, idle_ttl).IgnoreError();
  }
}

}  // namespace latticed
