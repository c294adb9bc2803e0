// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/engine/engine_support.h"

#include <cmath>
#include <numeric>
#include <utility>

#include "absl/time/clock.h"
#include "core/cpu/cpu_backend.h"
#include "tests/support/status_matchers.h"

// ThreadSanitizer does not see the synchronisation inside a packaged libtbb, so the loops of the
// CPU backend look like races. No code of the engine is called from libtbb.
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() { return "race:libtbb.so\n"; }

namespace latticed::testing {

std::shared_ptr<const PolygonMesh> MakeWavyGrid(int cells) {
  auto mesh = std::make_shared<PolygonMesh>();
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const double x = static_cast<double>(i) / cells;
      const double y = static_cast<double>(j) / cells;
      mesh->positions.push_back({x, y, 0.2 * std::sin(7 * x + 5 * y)});
    }
  }
  const auto vertex = [cells](int i, int j) { return static_cast<uint32_t>(i + (cells + 1) * j); };
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      for (const uint32_t v :
           {vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)}) {
        mesh->corner_vertices.push_back(v);
      }
      mesh->face_offsets.push_back(static_cast<uint32_t>(mesh->corner_vertices.size()));
    }
  }
  return mesh;
}

SceneConfig MakeSceneConfig(std::string id, int cells, int size) {
  SceneConfig config;
  config.id = std::move(id);
  config.mesh_id = "grid";
  config.mesh = MakeWavyGrid(cells);
  auto lattice = FitLattice(config.mesh->ComputeBounds(), {size, size, size}, {2, 2, 2}, 0.05);
  EXPECT_OK(lattice);
  config.lattices = {*std::move(lattice)};
  config.default_view.key.spec.segments = 4;
  config.default_view.key.encoding = Encoding::kQuantised;
  return config;
}

EditBatch MoveBatch(const Scene& scene, std::string editor, uint64_t sequence,
                    std::vector<uint32_t> indices, Vec3d offset) {
  EditBatch batch;
  batch.editor_id = std::move(editor);
  batch.sequence = sequence;
  batch.structure_id = scene.State()->structure_id;
  batch.edits.push_back(MoveControlPoints{std::move(indices), offset});
  return batch;
}

EditBatch KnotBatch(const Scene& scene, std::string editor, uint64_t sequence, int axis,
                    double value) {
  EditBatch batch = MoveBatch(scene, std::move(editor), sequence, {}, {});
  batch.edits = {InsertKnot{axis, value}};
  return batch;
}

void Bell::OnSceneChanged() {
  const MutexLock lock(&mutex_);
  rung_ = true;
}

void Bell::Wait(absl::Duration most) {
  const MutexLock lock(&mutex_);
  mutex_.AwaitFor([this] { return rung_; }, most);
  rung_ = false;
}

WatcherClient::WatcherClient(std::shared_ptr<Scene> scene, const WatcherOptions& options,
                             RenderQueue* queue)
    : scene_(std::move(scene)), queue_(queue) {
  Reconnect(options);
}

void WatcherClient::AwaitNews() {
  if (queue_ == nullptr) return bell_->Wait(absl::Milliseconds(50));
  ASSERT_TRUE(queue_->RunNext(RenderQueue::Role::kAny)) << "no turn is left, and nothing to send";
}

void WatcherClient::Reconnect(const WatcherOptions& options) {
  WatcherOptions with_token = options;
  if (with_token.evaluator.empty()) with_token.evaluator = "cpu";
  if (!updates_.empty()) with_token.resume_token = updates_.back().end.resume_token;
  if (watcher_ == nullptr) scene_->AddListener(bell_);
  watcher_.reset();
  auto watcher = Watcher::Create(scene_, with_token);
  ASSERT_OK(watcher);
  watcher_ = *std::move(watcher);
  current_.reset();
  staged_.clear();
  topology_id_.clear();
  patterns_.clear();
  must_restart_ = false;
  first_update_ = updates_.size();
  if (!watcher_->resumed()) chunks_.clear();
}

bool WatcherClient::Step(absl::Time now) {
  auto event = watcher_->Next(now);
  if (!event.ok()) {
    status_ = event.status();
    return false;
  }
  if (!event->has_value()) return false;
  std::visit([this](const auto& e) { Take(e); }, **event);
  return true;
}

void WatcherClient::RunToUpdate(const std::function<absl::Time()>& clock) {
  const size_t before = updates_.size();
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  while (updates_.size() == before) {
    ASSERT_LT(absl::Now(), deadline) << "no update came";
    if (!Step(clock())) AwaitNews();
    ASSERT_OK(status_);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

void WatcherClient::RunIntoUpdate() {
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  while (!current_.has_value()) {
    ASSERT_LT(absl::Now(), deadline) << "no update began";
    if (!Step()) AwaitNews();
    ASSERT_OK(status_);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

void WatcherClient::RunToHead() {
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  while (true) {
    while (Step()) {
      if (updates_.size() == first_update_) continue;
      ASSERT_OK(watcher_->Ack(updates_.back().end.update_id));
    }
    ASSERT_OK(status_);
    if (watcher_->covered() == scene_->State()->revision && !watcher_->update_in_progress() &&
        watcher_->lattice_current() && updates_.size() > first_update_ &&
        updates_.back().begin.view.key == watcher_->key()) {
      return;
    }
    ASSERT_LT(absl::Now(), deadline) << "the watcher does not reach the head";
    AwaitNews();
    if (::testing::Test::HasFatalFailure()) return;
  }
}

void WatcherClient::Take(const LatticeWhole& event) {
  EXPECT_GE(event.state->revision, lattice_revision_);
  lattice_revision_ = lattice_from_ = event.state->revision;
  lattice_structure_ = event.state->structure_id;
  cage_ = *event.state->control_points;
  ++lattice_wholes_;
}

void WatcherClient::Take(const std::shared_ptr<const LatticeDelta>& delta) {
  EXPECT_EQ(delta->revision, lattice_revision_ + 1) << "deltas have no gap";
  EXPECT_EQ(delta->structure_id, lattice_structure_);
  lattice_revision_ = delta->revision;
  for (size_t i = 0; i < delta->indices.size(); ++i) {
    cage_.at(delta->indices[i]) = delta->positions[i];
  }
}

void WatcherClient::Take(const TopologyNews& event) {
  must_restart_ = current_.has_value();
  topology_id_ = event.topology_id;
  ++topologies_;
}

void WatcherClient::Take(const QuantisationNews& event) {
  must_restart_ = current_.has_value();
  quantisation_id_ = event.snapshot->box.id;
  ++quantisations_;
}

void WatcherClient::Take(const PatternNews& event) {
  EXPECT_TRUE(current_.has_value());
  for (const uint16_t code : event.codes) {
    EXPECT_TRUE(patterns_.insert(code).second) << "each pattern comes once";
  }
}

void WatcherClient::Take(const UpdateBegins& event) {
  EXPECT_EQ(current_.has_value(), event.restart) << "restart, and only it, drops an update";
  if (!updates_.empty()) {
    EXPECT_GE(event.revision, updates_.back().end.revision) << "revisions never go back";
  }
  must_restart_ = false;
  current_ = Update();
  current_->begin = event;
  staged_.clear();
}

void WatcherClient::Take(const SumNews& event) {
  ASSERT_TRUE(current_.has_value());
  EXPECT_EQ(event.snapshot->revision, current_->begin.revision) << "one update, one revision";
}

void WatcherClient::Take(const ChunkBatch& event) {
  ASSERT_TRUE(current_.has_value());
  EXPECT_FALSE(must_restart_) << "layout and grid change between updates";
  EXPECT_EQ(event.update_id, current_->begin.update_id);
  EXPECT_EQ(event.topology_id, topology_id_);
  if (HasPositions(event.snapshot->view.spec)) {
    EXPECT_EQ(event.snapshot->box.id, quantisation_id_);
  }
  EXPECT_EQ(event.snapshot->revision, current_->begin.revision) << "one update, one revision";
  for (const uint32_t chunk : event.chunks) {
    const std::span<const uint16_t> patterns = event.snapshot->patterns.OfChunk(chunk);
    EXPECT_EQ(!patterns.empty(), event.snapshot->view.spec.tolerance > 0);
    for (const uint16_t code : patterns) {
      EXPECT_TRUE(patterns_.contains(code)) << "a pattern comes before its first use";
    }
    EXPECT_TRUE(staged_.emplace(chunk, event.snapshot->chunks.Data(chunk)).second)
        << "every chunk of an update comes once";
  }
  current_->chunks_sent += event.chunks.size();
}

void WatcherClient::Take(const UpdateEnds& event) {
  ASSERT_TRUE(current_.has_value());
  EXPECT_FALSE(must_restart_) << "layout and grid change between updates";
  EXPECT_EQ(event.update_id, current_->begin.update_id);
  EXPECT_EQ(event.revision, current_->begin.revision);
  EXPECT_EQ(current_->chunks_sent, current_->begin.chunk_count);
  EXPECT_GE(event.head_revision, event.revision);
  EXPECT_LE(event.revision, lattice_revision_) << "the lattice comes first";
  if (!HasPositions(current_->begin.view.key.spec)) {
    EXPECT_GE(event.revision, lattice_from_) << "the lattice of the update's revision was skipped";
  }
  for (auto& [chunk, data] : staged_) {
    if (chunks_.size() <= chunk) chunks_.resize(chunk + size_t{1});
    chunks_[chunk] = data;
  }
  staged_.clear();
  current_->end = event;
  view_ = current_->begin.view.key;
  updates_.push_back(*std::exchange(current_, std::nullopt));
}

std::vector<std::vector<uint8_t>> EvaluateAfresh(const SceneState& state, const ViewKey& key) {
  std::vector<std::vector<uint8_t>> result;
  static Backend* const backend = MakeCpuBackend({.threads = 1}).release();
  const auto target = backend->Prepare(state.plan, Pipeline::kFused);
  EXPECT_OK(target);
  auto view = (*target)->CreateView(key.spec);
  EXPECT_OK(view);
  if (!view.ok()) return result;
  std::vector<uint32_t> all(state.plan->chunk_count());
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_OK((*view)->Evaluate(*state.control_points, state.box, all));
  const auto encoded = (*view)->Encode(all, key.encoding);
  EXPECT_OK(encoded);
  if (!encoded.ok()) return result;
  for (const SharedBytes& bytes : *encoded) {
    result.emplace_back(bytes.data, bytes.data + bytes.size);
  }
  return result;
}

}  // namespace latticed::testing
