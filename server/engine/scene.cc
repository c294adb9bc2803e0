// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "server/base/auth/tenant.h"
#include "server/base/random_id.h"
#include "server/engine/watch/view_tolerance.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

// A view that nobody has watched for this long is dropped.
constexpr absl::Duration kIdleView = absl::Seconds(60);

SceneConfig WithTokenKey(SceneConfig config) {
  if (config.token_key.empty()) config.token_key = NewRandomId();
  return config;
}

}  // namespace

Scene::Scene(SceneConfig config, SceneLife life, MemoryReservation history,
             const SceneContext& context)
    : config_(WithTokenKey(std::move(config))),
      context_(context),
      epoch_(std::chrono::steady_clock::now() - life.now.time_since_epoch()),
      commits_(std::move(life.commits)),
      editor_(std::move(life.history), config_.fold_watch),
      journal_(context.store, config_.id, life.replayed),
      history_reservation_(std::move(history)),
      last_use_(absl::Now()) {}

Scene::~Scene() = default;

absl::StatusOr<std::shared_ptr<Scene>> Scene::Create(SceneConfig config,
                                                     const SceneContext& context, StopCheck stop) {
  for (const Lattice& lattice : config.lattices) LATTICED_RETURN_IF_ERROR(Validate(lattice));
  ViewSpec default_spec = config.default_view.key.spec;
  if (default_spec.position_bits == 0) default_spec.position_bits = limits::kMaxPositionBits;
  LATTICED_RETURN_IF_ERROR(Validate(default_spec));
  SceneLife life{.history = SceneHistory(std::exchange(config.lattices, {}), config.strength),
                 .commit_time = config.create_time};
  LATTICED_RETURN_IF_ERROR(life.history.MadeWith(config.weights, config.mesh->positions.size()));
  life.moved = PointRevisions(life.history.first().lattice().control_points.size(), 0);
  LATTICED_ASSIGN_OR_RETURN(auto scene, Make(std::move(config), std::move(life), context, stop));
  const RenderInput head = scene->Head();
  LATTICED_RETURN_IF_ERROR(
      SettleTolerance(scene->config_.default_view, *head.target, head.state->box, "default_view")
          .status());
  return scene;
}

absl::StatusOr<std::shared_ptr<Scene>> Scene::Restore(SceneConfig config, const SceneLog& log,
                                                      const SceneContext& context, StopCheck stop) {
  config.lattices = {};
  LATTICED_ASSIGN_OR_RETURN(auto life,
                            Replay(log, {config.weights, config.mesh->positions.size()}));
  // No clock ran meanwhile, but that of the machine.
  const absl::Duration since = std::max(absl::Now() - life.commit_time, absl::ZeroDuration());
  life.now += absl::ToChronoNanoseconds(since);
  return Make(std::move(config), std::move(life), context, stop);
}

absl::StatusOr<std::shared_ptr<Scene>> Scene::Make(SceneConfig config, SceneLife life,
                                                   const SceneContext& context, StopCheck stop) {
  const PlanKey key{life.history.structures(), life.history.weights()};
  const auto box = life.box;
  const absl::Time commit_time = life.commit_time;
  PointRevisions moved = std::move(life.moved);
  LATTICED_ASSIGN_OR_RETURN(
      auto history, context.backend->memory().Reserve("the scene's history", 0, config.account));
  const std::shared_ptr<Scene> scene(
      new Scene(std::move(config), std::move(life), std::move(history), context));
  LATTICED_ASSIGN_OR_RETURN(auto prepared, scene->Prepare(key, stop));
  const MutexLock edit_lock(&scene->edit_mutex_);
  LATTICED_RETURN_IF_ERROR(scene->HoldRestored(prepared.state.lattices));
  scene->applied_ = scene->editor_.FirstState(std::move(prepared.state), commit_time, box);
  scene->is_box_stored_ = box.has_value() && box->id == scene->applied_->box.id;
  const MutexLock lock(&scene->mutex_);
  scene->head_ = {scene->applied_, std::move(prepared.target)};
  scene->moved_ = moved.Continued(*scene->applied_->lattices[0].map);
  return scene;
}

absl::Status Scene::HoldRestored(const SceneLattices& lattices) {
  {
    const MutexLock lock(&mutex_);
    const SceneHistory& history = editor_.history();
    for (size_t k = 0; k < history.size(); ++k) {
      for (const auto& [editor_id, last] : history.of(k).results()) {
        log_.Remember(editor_id, last.sequence, last.revision);
      }
    }
  }
  history_bytes_ = HistoryBytes();
  if (history_reservation_.Hold(history_bytes_, lattices)) return absl::OkStatus();
  return absl::ResourceExhaustedError("the scene's history does not fit in memory");
}

uint64_t Scene::HistoryBytes() const {
  const MutexLock lock(&mutex_);
  return editor_.MemoryBytes() + log_.MemoryBytes() +
         commits_.capacity() * sizeof(CommitTimes::value_type);
}

std::optional<absl::Time> Scene::CommitTime(uint64_t revision) const {
  const auto found =
      std::ranges::lower_bound(commits_, revision, {}, &CommitTimes::value_type::first);
  return found == commits_.end() || found->first != revision ? std::nullopt
                                                             : std::optional(found->second);
}

std::shared_ptr<const SceneState> Scene::State() const { return Head().state; }

RenderInput Scene::Head() const {
  const MutexLock lock(&mutex_);
  return head_;
}

MemoryUse Scene::memory() const {
  const RenderInput head = Head();
  const SceneState& state = *head.state;
  MemoryUse use = head.target->memory();
  use["mesh"] += config_.mesh->MemoryBytes();
  use["patch_tree"] += state.patch_tree->MemoryBytes();
  if (const uint64_t bytes = state.measures->MemoryBytes(); bytes > 0) use["moments"] += bytes;
  use["lattice"] += LatticeBytes(state.lattices);
  use["history"] += history_bytes_.load();
  if (const uint64_t bytes = point_sets_.MemoryBytes(); bytes > 0) use["point_sets"] += bytes;
  for (const auto& set : point_sets_.All()) {
    const uint64_t bytes = set->Newest()->evaluator->device_bytes();
    if (bytes > 0) use["device_points"] += bytes;
  }
  const MutexLock lock(&mutex_);
  for (const auto& [key, view] : views_) {
    for (const auto& [purpose, bytes] : view->memory()) use[purpose] += bytes;
  }
  return use;
}

size_t Scene::WatchersLocked() const {
  return static_cast<size_t>(
      std::ranges::count_if(listeners_, [](const auto& l) { return !l.expired(); }));
}

bool Scene::InUseLocked() const {
  const bool viewed =
      std::ranges::any_of(views_, [](const auto& v) { return v.second.use_count() > 1; });
  return viewed || WatchersLocked() > 0 || hold_.use_count() > 1;
}

uint64_t Scene::EvictableBytes(const MemoryShortage& shortage) const {
  const std::optional<int> device = shortage.device;
  const MutexLock lock(&mutex_);
  if (InUseLocked()) return 0;
  uint64_t bytes = 0;
  if (shortage.account != nullptr) {
    for (const auto& [key, view] : views_) bytes += view->BytesChargedTo(*shortage.account);
    return bytes;
  }
  bytes = DeviceBytes(head_.target->memory());
  for (const auto& [key, view] : views_) {
    bytes += device.has_value() ? DeviceBytes(view->memory()) : view->EvictableBytes();
  }
  return device.has_value() ? head_.target->BytesOn(*device, bytes) : bytes;
}

absl::Time Scene::last_use() const {
  const MutexLock lock(&mutex_);
  return last_use_;
}

void Scene::NoteUse() {
  const MutexLock lock(&mutex_);
  last_use_ = absl::Now();
}

bool Scene::Evict() {
  std::map<ViewKey, std::shared_ptr<RenderView>> evicted;
  std::shared_ptr<TargetSlot> target;
  {
    const MutexLock lock(&mutex_);
    if (InUseLocked()) return false;
    evicted.swap(views_);
    target = head_.target;
  }
  const bool freed =
      std::ranges::any_of(evicted, [](const auto& v) { return v.second->EvictableBytes() > 0; });
  evicted.clear();  // after the lock is released; a target that views hold is not evicted
  // The target also stays if somebody has begun to use it again meanwhile.
  return target->Evict() || freed;
}

absl::Time Scene::expire_time() const {
  const MutexLock lock(&mutex_);
  return WatchersLocked() > 0 ? absl::InfiniteFuture() : last_use_ + config_.idle_ttl;
}

size_t Scene::watcher_count() const {
  const MutexLock lock(&mutex_);
  return WatchersLocked();
}

size_t Scene::WatchersOf(const MemoryAccount& account) const {
  std::vector<std::shared_ptr<SceneListener>> listeners;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  for (const auto& weak : listeners_) {
    if (auto listener = weak.lock(); listener != nullptr) listeners.push_back(std::move(listener));
  }
  return static_cast<size_t>(std::ranges::count(
      listeners, &account, [](const auto& listener) { return listener->account(); }));
}

absl::Status Scene::ended() const {
  switch (life_.load()) {
    case Life::kDeleted:
      return error::NotFound("scene", IdOf(id()));
    case Life::kLeft:
      return error::SceneMoved("");
    case Life::kLives:
      break;
  }
  return absl::OkStatus();
}

void Scene::End(Life life) {
  life_ = life;
  {
    const MutexLock lock(&edit_mutex_);
  }  // an edit that is being applied appends before this returns
  NotifyListeners();
}

void Scene::Tick(absl::Time now) {
  EndIdleGestures(now);
  std::vector<std::shared_ptr<RenderView>> idle;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  std::erase_if(listeners_, [](const auto& listener) { return listener.expired(); });
  if (!listeners_.empty()) last_use_ = now;
  std::erase_if(views_, [now, &idle](const auto& entry) {
    const auto& view = entry.second;
    if (view.use_count() > 1 || now - view->board().last_watched(now) <= kIdleView) return false;
    idle.push_back(view);
    return true;
  });
}

void Scene::EndIdleGestures(absl::Time now) {
  // An edit is being applied or stored. The next tick is soon enough.
  if (!edit_mutex_.TryLock()) return;
  std::shared_ptr<const SceneState> ended;
  if (journal_.is_idle() && !journal_.is_broken()) {
    ended =
        editor_.EndIdleGestures(*applied_, Now() + absl::ToChronoNanoseconds(now - absl::Now()));
  }
  if (ended != nullptr) {
    applied_ = ended;
    const MutexLock lock(&mutex_);
    head_.state = ended;
  }
  edit_mutex_.Unlock();
  if (ended != nullptr) NotifyListeners();
}

void Scene::AddListener(std::weak_ptr<SceneListener> listener) {
  const MutexLock lock(&mutex_);
  std::erase_if(listeners_, [](const auto& other) { return other.expired(); });
  listeners_.push_back(std::move(listener));
  last_use_ = absl::Now();
}

void Scene::NotifyListeners() {
  std::vector<std::shared_ptr<SceneListener>> awake;
  {
    const MutexLock lock(&mutex_);
    for (const auto& listener : listeners_) {
      if (auto alive = listener.lock(); alive != nullptr) awake.push_back(std::move(alive));
    }
  }
  for (const auto& listener : awake) listener->OnSceneChanged();
}

absl::StatusOr<std::shared_ptr<SnapshotBoard>> Scene::AcquireView(const ViewKey& key,
                                                                  const MemoryAccountPtr& account) {
  LATTICED_RETURN_IF_ERROR(Validate(key.spec));
  std::shared_ptr<RenderView> replaced;  // destroyed after the lock is released
  const MutexLock lock(&mutex_);
  last_use_ = absl::Now();
  auto found = views_.find(key);
  // An idle view without vertices, of a caller whose share may be used up, gives way to one of this caller.
  if (found != views_.end() && found->second.use_count() == 1 &&
      found->second->account() != account && found->second->EvictableBytes() == 0) {
    replaced = std::move(found->second);
    views_.erase(found);
    found = views_.end();
  }
  if (found == views_.end()) {
    if (views_.size() >= static_cast<size_t>(limits::kMaxViewsPerScene)) {
      // Drops the view that has been idle longest. Only the map holds an idle view.
      auto oldest = views_.end();
      const auto idle_since = [now = last_use_](const auto& v) {
        return v->second->board().last_watched(now);
      };
      for (auto v = views_.begin(); v != views_.end(); ++v) {
        if (v->second.use_count() > 1) continue;
        if (oldest == views_.end() || idle_since(v) < idle_since(oldest)) oldest = v;
      }
      if (oldest == views_.end()) {
        return error::LimitExceeded("distinct views of a scene", limits::kMaxViewsPerScene);
      }
      replaced = std::move(oldest->second);
      views_.erase(oldest);
    }
    auto made = std::make_shared<RenderView>(key, context_.backend, account, last_use_);
    found = views_.emplace(key, std::move(made)).first;
  }
  return std::shared_ptr<SnapshotBoard>(found->second, &found->second->board());
}

std::function<void()> Scene::TakeWork(uint64_t most_points) {
  if (life_ != Life::kLives) return nullptr;
  const MutexLock lock(&mutex_);
  for (size_t i = 0; i < views_.size(); ++i) {
    const auto& view =
        std::next(views_.begin(), static_cast<std::ptrdiff_t>(next_view_++ % views_.size()))
            ->second;
    if (auto work = view->Begin(view, head_, moved_, most_points); work.has_value()) {
      return [this, self = shared_from_this(), work = *std::move(work)]() mutable {
        RunTurn(std::move(work));
      };
    }
  }
  return nullptr;
}

void Scene::RunTurn(RenderWork work) {
  // Held until the listeners are notified, because the last snapshot may take long to free.
  const std::shared_ptr<const Snapshot> replaced = work.view->board().newest();
  const bool news = work.view->Run(work);
  // Releases the view before the listeners run: a view that they leave then counts as idle.
  work = {};
  RequestWork();
  if (news) NotifyListeners();
}

Scene::LatticeNews Scene::LatticeAfter(std::optional<uint64_t> revision) const {
  const MutexLock lock(&mutex_);
  if (!revision.has_value()) return {head_.state, {}};
  return {head_.state, log_.After(*revision, head_.state->revision)};
}

uint64_t Scene::AppliedSequence(const std::string& editor_id, uint64_t revision) const {
  const MutexLock lock(&mutex_);
  return log_.AppliedSequence(editor_id, revision);
}

}  // namespace latticed
