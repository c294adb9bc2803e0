// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/scene_view.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/limits.h"
#include "core/ffd/tessellation_pattern.h"
#include "server/scene.h"

namespace latticed {
namespace {

// Encoding stops between batches of so many chunks when the last watcher has left.
constexpr size_t kChunksPerEncode = 256;

bool SameBytes(const SharedBytes& a, const SharedBytes& b) {
  return a.size == b.size && std::equal(a.data, a.data + a.size, b.data);
}

// What a view takes of the host's memory: vertices, which a device keeps itself, and the chunks of as
// many snapshots as there may be; Draco's are a quarter of its integers or less.
uint64_t ViewBytes(const DeformTarget& target, const ViewKey& key) {
  const DeformPlan& plan = target.plan();
  const uint64_t points =
      plan.patches.size() * static_cast<uint64_t>(PointsPerPatch(key.spec.segments));
  const uint64_t vertices = points * BytesPerPoint(key.spec);
  const bool draco = key.encoding == Encoding::kDracoPoints || key.encoding == Encoding::kDracoMesh;
  const uint64_t chunks = draco ? vertices / 4 : vertices;
  return (target.evaluates_on_device() ? 0 : vertices) + limits::kMaxSnapshotsPerView * chunks;
}

absl::Status NobodyWatches() { return absl::CancelledError("the last watcher left"); }

}  // namespace

void SceneView::AddActive() {
  const MutexLock lock(&mutex_);
  ++active_;
  last_watched_ = absl::Now();
  newest_taken_ = true;
  if (failure_.ok() || busy_) return;
  // Memory may have been freed since: a new watcher is a new try, from nothing.
  failure_ = absl::OkStatus();
  deform_view_.reset();
  all_dirty_ = true;
}

void SceneView::RemoveActive() {
  const MutexLock lock(&mutex_);
  --active_;
  last_watched_ = absl::Now();
}

absl::Time SceneView::last_watched() const {
  const MutexLock lock(&mutex_);
  return watched() ? absl::Now() : last_watched_;
}

void SceneView::MarkDirty(const std::vector<uint32_t>& chunks) {
  const MutexLock lock(&mutex_);
  if (all_dirty_) return;
  for (const uint32_t chunk : chunks) {
    if (chunk >= dirty_.size()) dirty_.resize(chunk + size_t{1});
    dirty_[chunk] = true;
  }
}

void SceneView::MarkAllDirty() {
  const MutexLock lock(&mutex_);
  all_dirty_ = true;
}

std::optional<ViewWork> SceneView::Begin(std::shared_ptr<SceneView> self,
                                         std::shared_ptr<const SceneState> state) {
  const MutexLock lock(&mutex_);
  if (busy_ || !watched() || !newest_taken_ || !failure_.ok()) return std::nullopt;
  const auto newest = ring_.newest();
  if (newest != nullptr && newest->revision == state->revision && !all_dirty_) return std::nullopt;

  ViewWork work{.view = std::move(self), .state = std::move(state)};
  const size_t count = work.state->plan->chunk_count();
  if (all_dirty_) {
    work.chunks.resize(count);
    std::iota(work.chunks.begin(), work.chunks.end(), 0u);
  } else {
    for (uint32_t c = 0; c < dirty_.size(); ++c) {
      if (dirty_[c]) work.chunks.push_back(c);
    }
  }
  all_dirty_ = false;
  dirty_.assign(count, false);
  busy_ = true;
  ++evaluations_;
  return work;
}

void SceneView::Run(const ViewWork& work) {
  const auto before = newest();
  auto snapshot = CatchBadAlloc("the view", [&] { return Compute(work, before.get()); });
  // What was left half done is evaluated from nothing if a watcher tries again.
  if (absl::IsResourceExhausted(snapshot.status())) {
    deform_view_.reset();
    reservation_.Release();
  }

  MemoryUse memory = deform_view_ != nullptr ? deform_view_->memory() : MemoryUse{};
  const MutexLock lock(&mutex_);
  busy_ = false;
  deform_memory_ = std::move(memory);
  if (snapshot.ok()) {
    (*snapshot)->number = next_number_++;
    ring_.Publish(*std::move(snapshot));
    newest_taken_ = false;
    return;
  }
  MarkAgain(work);
  if (!absl::IsCancelled(snapshot.status())) failure_ = snapshot.status();
}

void SceneView::MarkAgain(const ViewWork& work) {
  const size_t count = work.state->plan->chunk_count();
  if (work.chunks.size() == count || dirty_.size() > count) {
    all_dirty_ = true;
    return;
  }
  dirty_.resize(count);
  for (const uint32_t chunk : work.chunks) dirty_[chunk] = true;
}

absl::StatusOr<std::shared_ptr<Snapshot>> SceneView::Compute(const ViewWork& work,
                                                             const Snapshot* before) {
  const SceneState& state = *work.state;
  if (!watched()) return NobodyWatches();
  if (auto s = Prepare(state); !s.ok()) return s;

  auto snapshot = std::make_shared<Snapshot>();
  snapshot->view = key_;
  snapshot->revision = state.revision;
  snapshot->structure_id = state.structure_id;
  snapshot->box = state.box;
  snapshot->plan = state.plan;
  snapshot->edit_time = state.commit_time;
  if (before != nullptr && before->structure_id == state.structure_id) {
    snapshot->chunks = before->chunks;
  }
  snapshot->chunks.resize(state.plan->chunk_count());
  if (work.chunks.empty()) return snapshot;

  const absl::Time start = absl::Now();
  if (auto s = deform_view_->Evaluate(*state.control_points, state.box, work.chunks); !s.ok()) {
    return s;
  }
  const absl::Time evaluated = absl::Now();
  if (auto s = Encode(work, before, *snapshot); !s.ok()) return s;
  snapshot->evaluate_time = evaluated - start;
  snapshot->encode_time = absl::Now() - evaluated;
  return snapshot;
}

absl::Status SceneView::Prepare(const SceneState& state) {
  if (deform_view_ != nullptr && deform_view_structure_ == state.structure_id) {
    return absl::OkStatus();
  }
  // First, so that old and new do not need memory together.
  deform_view_.reset();
  reservation_.Release();
  auto room = Reserve(memory_, "the view", ViewBytes(*state.target, key_));
  if (!room.ok()) return room.status();
  auto made = state.target->CreateView(key_.spec);
  if (!made.ok()) return made.status();
  reservation_ = *std::move(room);
  deform_view_ = *std::move(made);
  deform_view_structure_ = state.structure_id;
  return absl::OkStatus();
}

absl::Status SceneView::Encode(const ViewWork& work, const Snapshot* before, Snapshot& snapshot) {
  // Under another box the same integers are other positions.
  const bool comparable = before != nullptr && before->structure_id == snapshot.structure_id &&
                          before->box.id == snapshot.box.id;
  const std::span<const uint32_t> all(work.chunks);
  for (size_t first = 0; first < all.size(); first += kChunksPerEncode) {
    if (!watched()) return NobodyWatches();
    const auto batch = all.subspan(first, std::min(kChunksPerEncode, all.size() - first));
    auto encoded = deform_view_->Encode(batch, key_.encoding);
    if (!encoded.ok()) return encoded.status();
    for (size_t i = 0; i < batch.size(); ++i) {
      SnapshotChunk& chunk = snapshot.chunks[batch[i]];
      if (comparable && chunk.data.data != nullptr && SameBytes(chunk.data, (*encoded)[i]))
        continue;
      chunk = {snapshot.revision, std::move((*encoded)[i])};
    }
  }
  return absl::OkStatus();
}

std::shared_ptr<const Snapshot> SceneView::PinNewest(uint64_t at_least) {
  const MutexLock lock(&mutex_);
  newest_taken_ = true;
  const auto newest = ring_.newest();
  if (newest == nullptr || newest->revision < at_least) return nullptr;
  return ring_.PinNewest();
}

std::shared_ptr<const Snapshot> SceneView::newest() const {
  const MutexLock lock(&mutex_);
  return ring_.newest();
}

void SceneView::Unpin(uint64_t number) {
  const MutexLock lock(&mutex_);
  ring_.Unpin(number);
}

std::shared_ptr<const Snapshot> SceneView::Find(uint64_t number) const {
  const MutexLock lock(&mutex_);
  return ring_.Find(number);
}

absl::Status SceneView::failure() const {
  const MutexLock lock(&mutex_);
  return failure_;
}

MemoryUse SceneView::memory() const {
  const MutexLock lock(&mutex_);
  MemoryUse use = deform_memory_;
  if (ring_.size() > 0) use["chunks"] += ring_.bytes();
  return use;
}

}  // namespace latticed
