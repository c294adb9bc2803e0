// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/render_view.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <numeric>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "server/engine/render/chunk_blocks.h"
#include "server/engine/render/chunk_revisions.h"
#include "server/engine/render/encode_snapshot.h"

namespace latticed {
namespace {

absl::Status NobodyWatches() { return absl::CancelledError("the last watcher left"); }

}  // namespace

uint64_t VertexBytes(const DeformPlan& plan, const ViewKey& key) {
  if (!HasPositions(key.spec)) return plan.edges.size();
  return plan.patches.size() * static_cast<uint64_t>(PointsPerPatch(key.spec.segments)) *
         BytesPerPoint(key.spec);
}

uint64_t SnapshotBytes(const DeformPlan& plan, const ViewKey& key, size_t lattices) {
  constexpr uint64_t kChunkHeaderBytes = 256, kPageBytes = 4096;
  const size_t chunks = plan.chunk_count();
  const uint64_t chunk_bytes = kChunkHeaderBytes * chunks + ChunkTable::MostBytes(chunks);
  // Blocks of codes, 2 bytes a patch, with 8 more a chunk, rounded up to a power of two.
  const uint64_t patterns =
      key.spec.tolerance > 0
          ? std::bit_ceil(kPageBytes + chunks * (8 + limits::kPatchesPerChunk * sizeof(uint16_t)))
          : 0;
  const uint64_t snapshots = IsCompressed(key.encoding) ? 1 : limits::kMaxSnapshotsPerView;
  const bool has_points = !HasPositions(key.spec) && lattices > 1;
  const uint64_t points =
      has_points ? static_cast<uint64_t>(plan.structure.control_point_count()) : 0;
  return snapshots * (VertexBytes(plan, key) + chunk_bytes + points * sizeof(Vec3d)) +
         limits::kMaxSnapshotsPerView * patterns;
}

RenderView::Stage RenderView::stage() const {
  const MutexLock lock(&mutex_);
  return stage_;
}

void RenderView::MarkDirty(std::span<const uint32_t> chunks) {
  const MutexLock lock(&mutex_);
  dirty_.Add(chunks);
}

void RenderView::MarkAllDirty() {
  const MutexLock lock(&mutex_);
  dirty_.AddAll();
}

std::optional<RenderWork> RenderView::Begin(std::shared_ptr<RenderView> self, RenderInput input,
                                            const PointRevisions& moved, uint64_t most_points) {
  const MutexLock lock(&mutex_);
  if (stage_ == Stage::kEvaluating || stage_ == Stage::kEncoding) return std::nullopt;
  if (!board_.watched() || !board_.wanted() || !board_.failure().ok()) return std::nullopt;
  const auto newest = board_.newest();
  const SceneState& state = *input.state;
  const bool current = newest != nullptr && newest->revision == state.revision;
  if (current && !dirty_.all()) return std::nullopt;
  const size_t count = state.plan->chunk_count();
  const uint64_t points = PointsOf(dirty_.Count(count)) * (input.target->on_device() ? 1 : 2);
  if (points > most_points) return std::nullopt;

  stage_ = Stage::kEvaluating;
  if (newest != nullptr && begun_revision_ < state.revision) {
    backend_->counts().revisions_merged += state.revision - begun_revision_ - 1;
  }
  begun_revision_ = state.revision;
  RenderWork work{.view = std::move(self), .input = std::move(input), .chunks = dirty_.Take(count)};
  if (newest == nullptr) work.moved = moved;
  return work;
}

uint64_t RenderView::PointsOf(size_t chunks) const {
  // The bounds of a patch take as long as some points.
  constexpr int kBoundsInPoints = 6;
  const ViewSpec& spec = key().spec;
  const int points = HasPositions(spec) ? PointsPerPatch(spec.segments) : kBoundsInPoints;
  return uint64_t{chunks} * limits::kPatchesPerChunk * static_cast<uint64_t>(points);
}

bool RenderView::Run(const RenderWork& work) {
  auto snapshot = CatchBadAlloc("the view", [&] {
    evaluated_ = work.chunks;
    return Render(work);
  });
  NoteMemory();
  if (!snapshot.ok()) return GiveUp(snapshot.status());
  Publish(*std::move(snapshot));
  return true;
}

absl::StatusOr<std::shared_ptr<Snapshot>> RenderView::Render(const RenderWork& work) {
  if (!board_.watched()) return NobodyWatches();
  LATTICED_RETURN_IF_ERROR(PrepareVertices(work.input));
  ++backend_->counts().evaluations;
  const absl::Time start = absl::Now();
  LATTICED_RETURN_IF_ERROR(Evaluate(work));
  const absl::Duration evaluate_time = absl::Now() - start;
  {
    const MutexLock lock(&mutex_);
    stage_ = Stage::kEncoding;
  }
  const auto before = board_.newest();
  std::vector<uint64_t> revisions;
  if (work.moved) {
    revisions = ChunkRevisions(*work.input.state->plan, *work.moved, key().spec);
  }
  const auto encode = [&](std::span<const uint32_t> chunks, KnownDigests known,
                          TakeEarly early) -> absl::StatusOr<std::vector<SharedBytes>> {
    if (!board_.watched()) return NobodyWatches();
    return backend_->Run([&] { return vertices_->Encode(chunks, key().encoding, known(), early); });
  };
  LATTICED_ASSIGN_OR_RETURN(auto snapshot,
                            EncodeSnapshot(key(), *work.input.state, evaluated_, revisions, traits_,
                                           before.get(), encode, vertices_->Patterns()));
  snapshot->certified_error = vertices_->certified_error();
  snapshot->curvature_tolerance = vertices_->curvature_tolerance();
  const bool is_first = before == nullptr || before->structure_id != snapshot->structure_id;
  snapshot->first =
      is_first ? FirstSnapshot{snapshot->revision, snapshot->curvature_tolerance} : before->first;
  snapshot->evaluate_time = evaluate_time;
  return snapshot;
}

absl::Status RenderView::PrepareVertices(const RenderInput& input) {
  if (vertices_ != nullptr && vertices_structure_ == input.state->structure_id) {
    return absl::OkStatus();
  }
  // Dropped first, so that old and new vertices are never in memory together.
  DropVertices();
  LATTICED_ASSIGN_OR_RETURN(target_, input.target->Get());
  LATTICED_RETURN_IF_ERROR(CheckSupported(*target_, key().spec));
  traits_ = target_->Traits(key().spec);
  MemoryBudget& memory = backend_->memory();
  LATTICED_ASSIGN_OR_RETURN(
      auto reservation,
      memory.Reserve("the view",
                     traits_.host_bytes +
                         SnapshotBytes(*input.state->plan, key(), input.state->lattices.size()),
                     account_));
  if (IsDraco(key().encoding)) {
    LATTICED_RETURN_IF_ERROR(memory.KeepAtLeast("the view's encoder", traits_.encoder_bytes));
  }
  LATTICED_ASSIGN_OR_RETURN(vertices_,
                            backend_->Run([&] { return target_->CreateView(key().spec); }));
  vertices_structure_ = input.state->structure_id;
  const MutexLock lock(&mutex_);
  reservation_ = std::move(reservation);
  return absl::OkStatus();
}

absl::Status RenderView::Evaluate(const RenderWork& work) {
  if (work.chunks.empty()) return absl::OkStatus();
  const SceneState& state = *work.input.state;
  // A failed evaluation may leave any vertices incomplete: the retry after an eviction evaluates all chunks.
  std::span<const uint32_t> named = work.chunks;
  std::vector<uint32_t> all;
  LATTICED_RETURN_IF_ERROR(backend_->Run([&] {
    const absl::Status status = vertices_->Evaluate(*state.control_points, state.box, named);
    if (!status.ok()) {
      all.resize(state.plan->chunk_count());
      std::iota(all.begin(), all.end(), 0u);
      named = all;
    }
    return status;
  }));
  // A retry names all, and then no others. But more than the first attempt named may have changed in it.
  const std::span<const uint32_t> also = vertices_->also_changed();
  evaluated_.clear();
  evaluated_.reserve(named.size() + also.size());
  std::ranges::set_union(named, also, std::back_inserter(evaluated_));
  return absl::OkStatus();
}

void RenderView::Publish(std::shared_ptr<Snapshot> snapshot) {
  EngineCounts& counts = backend_->counts();
  counts.evaluate.Observe(snapshot->evaluate_time);
  counts.encode.Observe(snapshot->encode_time);
  const MutexLock lock(&mutex_);
  stage_ = Stage::kPublished;
  const uint64_t room = reservation_.bytes() - std::min(reservation_.bytes(), traits_.host_bytes);
  if (board_.held_bytes() + snapshot->held_bytes > room) LeaveEmptyBlocks(*snapshot);
  counts.snapshots_retired += board_.Publish(std::move(snapshot), absl::Now(), room);
}

bool RenderView::GiveUp(const absl::Status& status) {
  const bool stopped = absl::IsCancelled(status);
  if (!stopped) DropVertices();
  const MutexLock lock(&mutex_);
  if (stopped) {
    stage_ = Stage::kIdle;
    dirty_.Add(evaluated_);
  } else {
    stage_ = Stage::kFailed;
    dirty_.AddAll();
    board_.Fail(status);
  }
  return !stopped;
}

void RenderView::DropVertices() {
  vertices_ = nullptr;
  target_ = nullptr;
  const MutexLock lock(&mutex_);
  reservation_.Release();
  vertex_memory_.clear();
}

void RenderView::NoteMemory() {
  MemoryUse use = vertices_ == nullptr ? MemoryUse{} : vertices_->memory();
  const MutexLock lock(&mutex_);
  vertex_memory_ = std::move(use);
}

MemoryUse RenderView::memory() const {
  MemoryUse use;
  {
    const MutexLock lock(&mutex_);
    use = vertex_memory_;
  }
  if (board_.newest() != nullptr) use["chunks"] += board_.chunk_bytes();
  return use;
}

uint64_t RenderView::EvictableBytes() const {
  const MemoryUse use = memory();
  const MutexLock lock(&mutex_);
  return DeviceBytes(use) + std::max(HostBytes(use), reservation_.bytes());
}

uint64_t RenderView::BytesChargedTo(const MemoryAccount& account) const {
  const MutexLock lock(&mutex_);
  return reservation_.account().get() == &account ? reservation_.bytes() : 0;
}

}  // namespace latticed
