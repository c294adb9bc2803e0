// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/dirty_set.h"
#include "server/engine/render/update_pipeline.h"

namespace latticed {
namespace {

// A view that nobody has watched for so long gives its memory back.
constexpr absl::Duration kIdleView = absl::Seconds(60);

uint64_t NextIncarnation() {
  static std::atomic<uint64_t> last = 0;
  return ++last;
}

}  // namespace

Scene::Scene(SceneConfig config, Lattice lattice, Residency* residency, UpdatePipeline* pipeline)
    : config_(std::move(config)),
      residency_(residency),
      pipeline_(pipeline),
      incarnation_(NextIncarnation()),
      history_(std::move(lattice)),
      history_room_(config_.memory),
      last_use_(absl::Now()) {}

Scene::~Scene() = default;

absl::StatusOr<std::shared_ptr<Scene>> Scene::Create(SceneConfig config, Residency* residency,
                                                     UpdatePipeline* pipeline, StopCheck stop) {
  LATTICED_RETURN_IF_ERROR(Validate(config.lattice));
  LATTICED_RETURN_IF_ERROR(Validate(config.default_view.key.spec));
  Lattice lattice = std::exchange(config.lattice, {});
  const LatticeStructure structure = lattice.structure;
  const std::shared_ptr<Scene> scene(
      new Scene(std::move(config), std::move(lattice), residency, pipeline));
  LATTICED_ASSIGN_OR_RETURN(auto state, scene->Prepare(structure, stop));

  const MutexLock edit_lock(&scene->edit_mutex_);
  state.revision = scene->history_.revision();
  state.structure_id = scene->history_.structure_id();
  state.control_points =
      std::make_shared<const std::vector<Vec3d>>(scene->history_.lattice().control_points);
  state.box = FitQuantisationBox(BoundsOf(state), 1);
  state.commit_time = absl::Now();
  const MutexLock lock(&scene->mutex_);
  scene->state_ = std::make_shared<const SceneState>(std::move(state));
  return scene;
}

absl::StatusOr<SceneState> Scene::Prepare(const LatticeStructure& structure, StopCheck stop) const {
  return CatchBadAlloc("the scene's plan", [&] { return PrepareUnguarded(structure, stop); });
}

absl::StatusOr<SceneState> Scene::PrepareUnguarded(const LatticeStructure& structure,
                                                   StopCheck stop) const {
  // Before the plan, which may take seconds.
  LATTICED_RETURN_IF_ERROR(residency_->health().status());
  SceneState state;
  const uint64_t least = LeastPlanBytes(*config_.mesh);
  LATTICED_ASSIGN_OR_RETURN(auto memory, residency_->Run([&] {
    return Reserve(config_.memory, "the scene's plan", least);
  }));
  ProbeMemory(least);
  LATTICED_ASSIGN_OR_RETURN(auto plan, MakePlan(config_.mesh, structure, stop));
  LATTICED_ASSIGN_OR_RETURN(auto target, residency_->Prepare(plan, config_.pipeline));
  LATTICED_RETURN_IF_ERROR(stop());
  state.patch_tree = std::make_shared<const PatchTree>(*plan);
  const uint64_t bytes = HostBytes(target->memory()) + state.patch_tree->MemoryBytes() +
                         LatticeBytes(structure) + LeastHistoryBytes(structure);
  auto room = residency_->Run([&] { return memory.Resize("the scene's plan", bytes); });
  if (!room.ok()) return room;
  state.memory = std::make_shared<const MemoryReservation>(std::move(memory));
  state.plan = std::move(plan);
  state.target = std::move(target);
  state.influential = std::make_shared<const std::vector<bool>>(InfluentialPoints(*state.plan));
  return state;
}

absl::StatusOr<EditSummary> Scene::ApplyEdits(const EditBatch& batch, StopCheck stop) {
  std::optional<Candidate> candidate;
  while (true) {
    std::optional<LatticeStructure> wanted;
    auto summary = TryEdits(batch, candidate, wanted);
    if (!wanted.has_value() && !summary.ok()) ++counts().edits_refused;
    if (!wanted.has_value()) return summary;
    candidate.reset();  // first, so that both plans do not need memory together
    auto state = Prepare(*wanted, stop);
    if (IsStopped(state.status())) {
      ++counts().edits_refused;
      return state.status();
    }
    candidate.emplace(Candidate{*std::move(wanted), std::move(state)});
  }
}

absl::StatusOr<EditSummary> Scene::TryEdits(const EditBatch& batch,
                                            std::optional<Candidate>& candidate,
                                            std::optional<LatticeStructure>& wanted) {
  // Large plans take long to destroy: after the locks.
  const auto retired = State();
  const MutexLock edit_lock(&edit_mutex_);
  if (deleted()) return error::NotFound("scene", id());

  const auto outcome = history_.Apply(batch, std::chrono::steady_clock::now(),
                                      [&](const LatticeStructure& structure) -> absl::Status {
                                        if (candidate && candidate->structure == structure) {
                                          return candidate->state.status();
                                        }
                                        wanted = structure;
                                        return EditHistory::PutOff();
                                      });
  if (!outcome.ok()) {
    KeepHistoryInRoom();
    return outcome.status();
  }
  if (outcome->repeated) {
    if (!outcome->summary.status.ok()) return outcome->summary.status;
    ++counts().edits_repeated;
    return outcome->summary;
  }

  SceneState next = outcome->structure_changed ? *std::move(candidate->state) : *State();
  DirtySet dirty(next.plan);
  if (outcome->structure_changed) {
    dirty.MarkAll();
  } else {
    dirty.MarkControlPoints(outcome->changed);
  }
  const QuantisationBox before = State()->box;
  next.revision = history_.revision();
  next.structure_id = history_.structure_id();
  next.control_points =
      std::make_shared<const std::vector<Vec3d>>(history_.lattice().control_points);
  next.commit_time = absl::Now();
  next.gesture_open = history_.gesture_open();
  const bool ends_gesture = !batch.gesture_id.empty() &&
                            batch.gesture_phase != GesturePhase::kUpdate && !next.gesture_open;
  next.busy_until =
      ends_gesture ? next.commit_time : BusyUntil(State()->commit_time, next.commit_time);
  next.box = NextQuantisationBox(before, BoundsOf(next), next.gesture_open).value_or(before);
  // A RAW view's origin may move with the plan, and an id never names two origins.
  if (outcome->structure_changed) next.box.id = before.id + 1;

  history_.SetTouched(batch.editor_id, dirty.boxes(), dirty.patches());
  EditSummary summary = outcome->summary;
  summary.commit_time = std::chrono::steady_clock::now();
  summary.boxes_touched = dirty.boxes();
  summary.patches_touched = next.patches_touched = dirty.patches();
  Commit(batch, *outcome, std::make_shared<const SceneState>(std::move(next)), dirty);
  KeepHistoryInRoom();
  return summary;
}

void Scene::Commit(const EditBatch& batch, const EditOutcome& outcome,
                   std::shared_ptr<const SceneState> next, const DirtySet& dirty) {
  auto delta = std::make_shared<LatticeDelta>();
  delta->revision = next->revision;
  delta->structure_id = next->structure_id;
  delta->editor_id = batch.editor_id;
  delta->sequence = batch.sequence;
  delta->indices = outcome.changed;
  delta->positions.reserve(outcome.changed.size());
  for (const uint32_t index : outcome.changed) {
    delta->positions.push_back((*next->control_points)[index]);
  }
  const std::vector<uint32_t> chunks = dirty.Chunks();
  {
    const MutexLock lock(&mutex_);
    const bool all = outcome.structure_changed || next->box.id != state_->box.id;
    state_ = std::move(next);
    for (const auto& [key, view] : views_) all ? view->MarkAllDirty() : view->MarkDirty(chunks);
    log_.Add(delta, outcome.structure_changed);
    last_use_ = absl::Now();
  }
  ++counts().edits_applied;
  RequestWork();  // first: each listener takes the time of a message
  WakeListeners();
}

void Scene::KeepHistoryInRoom() {
  const auto state = State();
  const auto log_bytes = [this] {
    const MutexLock lock(&mutex_);
    return log_.MemoryBytes();
  };
  do {
    history_bytes_ = history_.MemoryBytes() + log_bytes();
  } while (!history_room_.Make(history_bytes_, state->structure()) && ForgetOldest());
}

bool Scene::ForgetOldest() {
  if (history_.ForgetOldestStep()) {
    ++counts().undo_steps_forgotten;
    return true;
  }
  const MutexLock lock(&mutex_);
  return log_.ForgetOldest() || history_.ForgetOldestEditor();
}

std::shared_ptr<const SceneState> Scene::State() const {
  const MutexLock lock(&mutex_);
  return state_;
}

MemoryUse Scene::memory() const {
  const auto state = State();
  MemoryUse use = state->target->memory();
  use["mesh"] += config_.mesh->MemoryBytes();
  if (!use.contains("plan")) use["plan"] = state->plan->MemoryBytes();
  use["patch_tree"] += state->patch_tree->MemoryBytes();
  use["lattice"] += LatticeBytes(state->structure());
  use["history"] += history_bytes_.load();
  const MutexLock lock(&mutex_);
  for (const auto& [key, view] : views_) {
    for (const auto& [purpose, bytes] : view->memory()) use[purpose] += bytes;
  }
  return use;
}

bool Scene::WatchedLocked() const {
  return std::ranges::any_of(listeners_, [](const auto& l) { return !l.expired(); });
}

bool Scene::InUseLocked() const {
  const bool viewed =
      std::ranges::any_of(views_, [](const auto& v) { return v.second.use_count() > 1; });
  return viewed || WatchedLocked() || hold_.use_count() > 1;
}

uint64_t Scene::GivableBytes(std::optional<int> device) const {
  const MutexLock lock(&mutex_);
  if (InUseLocked()) return 0;
  const ResidentTarget& target = *state_->target;
  uint64_t bytes = DeviceBytes(target.memory());
  for (const auto& [key, view] : views_) {
    bytes += device.has_value() ? DeviceBytes(view->memory()) : view->GivableBytes();
  }
  return device.has_value() ? BytesOn(*device, target, bytes) : bytes;
}

bool Scene::GiveBack() {
  std::map<ViewKey, std::shared_ptr<SceneView>> given;
  std::shared_ptr<const SceneState> state;
  {
    const MutexLock lock(&mutex_);
    if (InUseLocked()) return false;
    given.swap(views_);
    state = state_;
  }
  const bool freed =
      std::ranges::any_of(given, [](const auto& v) { return v.second->GivableBytes() > 0; });
  given.clear();  // without the lock; their vertices are the target's
  // Where somebody has come meanwhile, and uses it again, it stays.
  return state->target->GiveBack() || freed;
}

absl::Time Scene::expire_time() const {
  const MutexLock lock(&mutex_);
  return WatchedLocked() ? absl::InfiniteFuture() : last_use_ + config_.idle_ttl;
}

size_t Scene::watcher_count() const {
  const MutexLock lock(&mutex_);
  return static_cast<size_t>(
      std::ranges::count_if(listeners_, [](const auto& l) { return !l.expired(); }));
}

void Scene::Delete() {
  deleted_ = true;
  WakeListeners();
}

void Scene::Tick(absl::Time now) {
  // An edit in the making is activity enough; the next tick will do.
  if (edit_mutex_.TryLock()) {
    history_.CommitIdleGestures(std::chrono::steady_clock::now() +
                                absl::ToChronoNanoseconds(now - absl::Now()));
    const bool gestures_ended = State()->gesture_open && !history_.gesture_open();
    if (gestures_ended) EndGestures();
    edit_mutex_.Unlock();
    if (gestures_ended) WakeListeners();
  }
  std::vector<std::shared_ptr<SceneView>> idle;  // destroyed without the lock
  const MutexLock lock(&mutex_);
  std::erase_if(listeners_, [](const auto& listener) { return listener.expired(); });
  if (!listeners_.empty()) last_use_ = now;
  std::erase_if(views_, [now, &idle](const auto& entry) {
    const auto& view = entry.second;
    if (view.use_count() > 1 || now - view->last_watched() <= kIdleView) return false;
    idle.push_back(view);
    return true;
  });
}

void Scene::EndGestures() {
  const MutexLock lock(&mutex_);
  auto state = std::make_shared<SceneState>(*state_);
  state->gesture_open = false;
  state_ = std::move(state);
}

void Scene::AddListener(std::weak_ptr<SceneListener> listener) {
  const MutexLock lock(&mutex_);
  std::erase_if(listeners_, [](const auto& other) { return other.expired(); });
  listeners_.push_back(std::move(listener));
  last_use_ = absl::Now();
}

void Scene::WakeListeners() {
  std::vector<std::shared_ptr<SceneListener>> awake;
  {
    const MutexLock lock(&mutex_);
    for (const auto& listener : listeners_) {
      if (auto alive = listener.lock(); alive != nullptr) awake.push_back(std::move(alive));
    }
  }
  for (const auto& listener : awake) listener->OnSceneChanged();
}

absl::StatusOr<std::shared_ptr<SceneView>> Scene::AcquireView(const ViewKey& key) {
  LATTICED_RETURN_IF_ERROR(Validate(key.spec));
  std::shared_ptr<SceneView> replaced;  // destroyed without the lock
  const MutexLock lock(&mutex_);
  state_->target->Touch();
  if (const auto found = views_.find(key); found != views_.end()) return found->second;
  if (views_.size() >= static_cast<size_t>(limits::kMaxViewsPerScene)) {
    // Only the map holds an idle one; the one idle longest makes room.
    auto oldest = views_.end();
    for (auto v = views_.begin(); v != views_.end(); ++v) {
      if (v->second.use_count() > 1) continue;
      if (oldest == views_.end() || v->second->last_watched() < oldest->second->last_watched()) {
        oldest = v;
      }
    }
    if (oldest == views_.end()) {
      return error::LimitExceeded("distinct views of a scene", limits::kMaxViewsPerScene);
    }
    replaced = std::move(oldest->second);
    views_.erase(oldest);
  }
  return views_[key] = std::make_shared<SceneView>(key, residency_, config_.memory);
}

void Scene::RequestWork() { pipeline_->Schedule(shared_from_this()); }

std::optional<ViewWork> Scene::TakeWork(uint64_t most_points) {
  if (deleted()) return std::nullopt;
  const MutexLock lock(&mutex_);
  for (size_t i = 0; i < views_.size(); ++i) {
    const auto& view =
        std::next(views_.begin(), static_cast<std::ptrdiff_t>(next_view_++ % views_.size()))
            ->second;
    if (auto work = view->Begin(view, state_, most_points); work.has_value()) return work;
  }
  return std::nullopt;
}

void Scene::RunWork(ViewWork work, std::function<void(uint64_t points)> part_done) {
  std::shared_ptr<const Snapshot> replaced;  // freed when the listeners have been told of the new
  bool news = false;
  {
    // Gone before the listeners run, so that a view that is let go now is idle.
    const auto view = work.view;
    news = view->Run(std::move(work),
                     {.more_work = [this] { RequestWork(); }, .part_done = std::move(part_done)},
                     replaced);
  }
  // First, so that what was evaluated meanwhile is encoded without waiting for them.
  RequestWork();
  if (news) WakeListeners();
}

EditLog::Deltas Scene::DeltasAfter(uint64_t revision) const {
  const MutexLock lock(&mutex_);
  return log_.After(revision, state_->revision);
}

uint64_t Scene::AppliedSequence(const std::string& editor_id, uint64_t revision) const {
  const MutexLock lock(&mutex_);
  return log_.AppliedSequence(editor_id, revision);
}

}  // namespace latticed
