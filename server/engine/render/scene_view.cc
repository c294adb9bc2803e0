// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/scene_view.h"

#include <algorithm>
#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "server/engine/render/chunk_blocks.h"
#include "server/engine/scene.h"

namespace latticed {
namespace {

absl::Status NobodyWatches() { return absl::CancelledError("the last watcher left"); }

// Adds the time that `call` takes to `sum`.
template <typename Call>
void Timed(absl::Duration& sum, Call call) {
  const absl::Time start = absl::Now();
  call();
  sum += absl::Now() - start;
}

}  // namespace

void SceneView::AddActive() {
  std::array<VertexSlot, 2> failed;  // destroyed without the lock
  const MutexLock lock(&mutex_);
  ++active_;
  last_watched_ = absl::Now();
  newest_taken_ = true;
  // Memory may have been freed since: a new watcher is a new try.
  one_slot_only_ = false;
  if (failure_.ok()) return;
  failure_ = absl::OkStatus();
  for (size_t s = 0; s < slots_.size(); ++s) {
    std::swap(failed[s], slots_[s]);
    ForgetSlot(s);
  }
  two_slots_ = false;
  room_.Release();
  dirty_.AddAll();
}

void SceneView::RemoveActive() {
  std::optional<ViewWork> dropped;
  const MutexLock lock(&mutex_);
  --active_;
  last_watched_ = absl::Now();
  if (!watched()) dropped = DropHeld();
}

absl::Time SceneView::last_watched() const {
  const MutexLock lock(&mutex_);
  return watched() ? absl::Now() : last_watched_;
}

void SceneView::MarkDirty(const std::vector<uint32_t>& chunks) {
  const MutexLock lock(&mutex_);
  dirty_.Add(chunks);
  for (ChunkSet& stale : stale_) stale.Add(chunks);
}

void SceneView::MarkAllDirty() {
  const MutexLock lock(&mutex_);
  dirty_.AddAll();
  for (ChunkSet& stale : stale_) stale.AddAll();
}

std::optional<ViewWork> SceneView::Begin(std::shared_ptr<SceneView> self,
                                         std::shared_ptr<const SceneState> state,
                                         uint64_t most_points) {
  const MutexLock lock(&mutex_);
  if (!watched() || !failure_.ok()) return std::nullopt;
  if (held_.has_value() && !encoding_) {
    if (held_->points > most_points) return std::nullopt;
    ViewWork work = *std::exchange(held_, std::nullopt);
    work.view = std::move(self);
    StartEncoding(work);
    return work;
  }
  const auto slot = ChooseSlot(*state);
  if (!slot.has_value()) return std::nullopt;
  const size_t count = state->plan->chunk_count();
  uint64_t points = PointsOf(dirty_.Count(count));
  if (!state->target->evaluates_on_device()) points += PointsOf(stale_[*slot].Count(count));
  if (points > most_points) return std::nullopt;

  ViewWork work{
      .view = std::move(self), .state = std::move(state), .slot = *slot, .points = points};
  if (begun_structure_ != work.state->structure_id) {
    work.drop_other = std::exchange(two_slots_, false);
    one_slot_only_ = false;
  }
  if (encoding_) two_slots_ = true;
  work.chunks = dirty_.Take(count);
  work.stale = stale_[*slot].Take(count);
  evaluating_ = true;
  if (ring_.newest() != nullptr && begun_revision_ < work.state->revision) {
    residency_->counts().revisions_merged += work.state->revision - begun_revision_ - 1;
  }
  begun_revision_ = work.state->revision;
  begun_structure_ = work.state->structure_id;
  begun_slot_ = *slot;
  return work;
}

std::optional<size_t> SceneView::ChooseSlot(const SceneState& state) {
  if (evaluating_ || held_.has_value()) return std::nullopt;
  if (encoding_) {
    const bool worth = state.target->evaluates_on_device() && awaited_ && encoding_ends_soon_;
    // Another structure would need the memory of both.
    const bool room = !one_slot_only_ && begun_structure_ == state.structure_id;
    if (!worth || !room || begun_revision_ == state.revision) return std::nullopt;
    return 1 - encoding_slot_;
  }
  if (!newest_taken_) return std::nullopt;
  const auto newest = ring_.newest();
  if (newest != nullptr && newest->revision == state.revision && !dirty_.all()) return std::nullopt;
  return begun_slot_;
}

uint64_t SceneView::PointsOf(size_t chunks) const {
  return uint64_t{chunks} * limits::kPatchesPerChunk *
         static_cast<uint64_t>(PointsPerPatch(key_.spec.segments));
}

bool SceneView::Run(ViewWork work, const WorkHooks& hooks,
                    std::shared_ptr<const Snapshot>& replaced) {
  if (!work.evaluated) {
    const Next next = EvaluateStage(work, hooks);
    if (next != Next::kEncode) return next == Next::kEnd;
  }
  replaced = newest();
  EncodeStage(work, hooks, replaced.get());
  return true;
}

SceneView::Next SceneView::EvaluateStage(ViewWork& work, const WorkHooks& hooks) {
  const absl::Status status = CatchBadAlloc("the view", [&] { return Evaluate(work, hooks); });
  const bool failed = !status.ok() && !absl::IsCancelled(status);
  if (failed) slots_[work.slot].Reset();
  MemoryUse memory = slots_[work.slot].memory();

  const MutexLock lock(&mutex_);
  evaluating_ = false;
  slot_memory_[work.slot] = std::move(memory);
  if (status.ok()) {
    work.evaluated = true;
    evaluate_time_ = work.evaluate_time;
  }
  if (!status.ok() || !watched()) {
    GiveUp(work, status);
    return Next::kEnd;
  }
  if (encoding_) {
    held_.emplace();
    std::swap(*held_, work);
    held_->view.swap(work.view);  // or it would keep itself alive
    return Next::kHeld;
  }
  StartEncoding(work);
  return Next::kEncode;
}

absl::Status SceneView::Evaluate(ViewWork& work, const WorkHooks& hooks) {
  if (work.drop_other) {
    slots_[1 - work.slot].Reset();
    const MutexLock lock(&mutex_);
    ForgetSlot(1 - work.slot);
  }
  if (!watched()) return NobodyWatches();
  const SceneState& state = *work.state;
  VertexSlot& slot = slots_[work.slot];
  auto room = residency_->Run([&] {
    const MutexLock lock(&mutex_);
    return room_.Make(*state.target, key_, {.slots = SlotBytes(), .chunks = ring_.held_bytes()});
  });
  if (!room.ok()) return room;
  LATTICED_RETURN_IF_ERROR(slot.Prepare(state, key_.spec));
  {
    const MutexLock lock(&mutex_);
    ++evaluations_;
    ++residency_->counts().evaluations;
    if (encoding_) {
      ++evaluations_beside_;
      ++residency_->counts().evaluations_beside;
    }
  }
  absl::Status status;
  absl::Duration of_others;
  Timed(work.evaluate_time, [&] {
    status = slot.Evaluate(state, work.stale, [&](uint64_t points) {
      Timed(of_others, [&] { hooks.part_done(points); });
    });
  });
  work.evaluate_time -= of_others;
  return status;
}

void SceneView::StartEncoding(ViewWork& work) {
  encoding_ = true;
  encoding_slot_ = work.slot;
  encoding_ends_soon_ = false;
  unpublished_.Add(work.chunks);
  work.chunks = unpublished_.Take(work.state->plan->chunk_count());
}

void SceneView::EncodeStage(const ViewWork& work, const WorkHooks& hooks, const Snapshot* before) {
  VertexSlot& slot = slots_[work.slot];
  absl::Duration of_others;
  size_t told = 0;
  auto snapshot = CatchBadAlloc("the view", [&] {
    return EncodeSnapshot(
        key_, *work.state, work.chunks, slot.view(), before, [&](const EncodeProgress& progress) {
          const size_t batch = progress.done - std::exchange(told, progress.done);
          if (auto s = BetweenBatches(work, progress, hooks); !s.ok() || batch == 0) return s;
          Timed(of_others, [&] { hooks.part_done(PointsOf(batch)); });
          return absl::OkStatus();
        });
  });
  if (snapshot.ok()) {
    const absl::Status room =
        CatchBadAlloc("the view", [&] { return MakeRoomFor(**snapshot, work); });
    if (!room.ok()) snapshot = room;
  }
  if (!snapshot.ok() && !absl::IsCancelled(snapshot.status())) slot.Reset();
  MemoryUse memory = slot.memory();

  SnapshotRing::Dropped dropped;  // destroyed without the lock
  const MutexLock lock(&mutex_);
  encoding_ = false;
  slot_memory_[work.slot] = std::move(memory);
  if (!snapshot.ok()) {
    GiveUp(work, snapshot.status());
    return;
  }
  (*snapshot)->number = next_number_++;
  (*snapshot)->evaluate_time = work.evaluate_time;
  (*snapshot)->encode_time -= of_others;
  EngineCounts& counts = residency_->counts();
  counts.evaluate.Observe((*snapshot)->evaluate_time);
  counts.encode.Observe((*snapshot)->encode_time);
  dropped = ring_.Publish(*std::move(snapshot), absl::Now());
  counts.snapshots_retired += dropped.retired;
  newest_taken_ = false;
  awaited_ = false;
}

absl::Status SceneView::MakeRoomFor(Snapshot& next, const ViewWork& work) {
  const MemoryUse memory = slots_[work.slot].memory();
  const auto make = [&] {
    const MutexLock lock(&mutex_);
    slot_memory_[work.slot] = memory;
    return room_.Make(*work.state->target, key_,
                      {.slots = SlotBytes(), .chunks = ring_.held_bytes() + next.held_bytes});
  };
  if (make().ok()) return absl::OkStatus();
  LeaveEmptyBlocks(next);
  return residency_->Run(make);
}

uint64_t SceneView::SlotBytes() const {
  return HostBytes(slot_memory_[0]) + HostBytes(slot_memory_[1]);
}

absl::Status SceneView::BetweenBatches(const ViewWork& work, const EncodeProgress& progress,
                                       const WorkHooks& hooks) {
  if (!watched()) return NobodyWatches();
  if (!work.state->target->evaluates_on_device()) return absl::OkStatus();
  {
    const MutexLock lock(&mutex_);
    if (encoding_ends_soon_ || !progress.EndsWithin(evaluate_time_)) return absl::OkStatus();
    encoding_ends_soon_ = true;
  }
  hooks.more_work();
  return absl::OkStatus();
}

void SceneView::GiveUp(const ViewWork& work, const absl::Status& status) {
  unpublished_.Add(work.chunks);
  if (status.ok() || absl::IsCancelled(status)) {
    if (!work.evaluated) stale_[work.slot].Add(work.stale);
    return;
  }
  ForgetSlot(work.slot);
  if (two_slots_) {
    // The other slot goes on, perhaps with the stage that it is in. Where memory was short it may
    // do; anything else will show there.
    two_slots_ = false;
    one_slot_only_ = true;
    begun_slot_ = 1 - work.slot;
    return;
  }
  // No other stage is out.
  failure_ = status;
  room_.Release();
}

std::optional<ViewWork> SceneView::DropHeld() {
  if (held_.has_value()) unpublished_.Add(held_->chunks);
  return std::exchange(held_, std::nullopt);
}

void SceneView::ForgetSlot(size_t slot) {
  stale_[slot].AddAll();
  slot_memory_[slot].clear();
}

std::shared_ptr<const Snapshot> SceneView::PinNewest(uint64_t at_least, bool takes_next) {
  const MutexLock lock(&mutex_);
  const auto newest = ring_.newest();
  if (newest != nullptr && newest->revision >= at_least) {
    if (takes_next) newest_taken_ = true;
    return ring_.PinNewest(absl::Now());
  }
  newest_taken_ = true;
  awaited_ = awaited_ || takes_next;
  return nullptr;
}

bool SceneView::TakeNext(uint64_t number) {
  const MutexLock lock(&mutex_);
  const auto newest = ring_.newest();
  if (newest == nullptr || newest->number != number) return false;
  return !std::exchange(newest_taken_, true);
}

bool SceneView::WaitForNewer(uint64_t number, bool takes_next) {
  const MutexLock lock(&mutex_);
  const auto newest = ring_.newest();
  if (newest == nullptr || newest->number != number) return false;
  const bool taken = std::exchange(newest_taken_, true);
  const bool awaited = std::exchange(awaited_, awaited_ || takes_next);
  return !taken || (!awaited && awaited_ && encoding_);
}

std::shared_ptr<const Snapshot> SceneView::newest() const {
  const MutexLock lock(&mutex_);
  return ring_.newest();
}

void SceneView::Unpin(uint64_t number) {
  std::shared_ptr<const Snapshot> dropped;  // destroyed without the lock
  const MutexLock lock(&mutex_);
  dropped = ring_.Unpin(number);
}

std::shared_ptr<const Snapshot> SceneView::Find(uint64_t number) {
  const MutexLock lock(&mutex_);
  return ring_.Find(number, absl::Now());
}

absl::Status SceneView::failure() const {
  const MutexLock lock(&mutex_);
  return failure_;
}

uint64_t SceneView::GivableBytes() const {
  const MemoryUse use = memory();
  const MutexLock lock(&mutex_);
  return DeviceBytes(use) + std::max(HostBytes(use), room_.bytes());
}

MemoryUse SceneView::memory() const {
  const MutexLock lock(&mutex_);
  MemoryUse use;
  for (const MemoryUse& slot : slot_memory_) {
    for (const auto& [purpose, bytes] : slot) use[purpose] += bytes;
  }
  if (ring_.size() > 0) use["chunks"] += ring_.bytes();
  return use;
}

}  // namespace latticed
