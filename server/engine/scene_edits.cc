// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edits of a Scene: applied, stored, published, answered.
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/engine/scene.h"
#include "server/store/store_errors.h"

namespace latticed {

absl::StatusOr<EditSummary> Scene::ApplyEdits(const EditBatch& batch, StopCheck stop) {
  struct Waiting {
    Mutex mutex;
    Answer answer ABSL_GUARDED_BY(mutex);
  };
  // Shared: where memory is short, this may end before its answer comes.
  const auto waiting = std::make_shared<Waiting>();
  SubmitEdits(batch, stop, [waiting](const absl::StatusOr<EditSummary>& summary) {
    const MutexLock lock(&waiting->mutex);
    waiting->answer = summary;
  });
  const MutexLock lock(&waiting->mutex);
  const auto answered = [&waiting]()
                            ABSL_NO_THREAD_SAFETY_ANALYSIS { return waiting->answer.has_value(); };
  waiting->mutex.Await(answered);
  return *waiting->answer;
}

void Scene::SubmitEdits(const EditBatch& batch, StopCheck stop, EditDone done) {
  std::optional<PlanCandidate> candidate;
  std::shared_ptr<TargetSlot> target;
  while (true) {
    std::optional<PlanKey> wanted;
    const Answer answer = TryEdits(batch, candidate, target, wanted, done);
    if (!wanted.has_value()) {
      // Here rather than in TryEdits: an answer takes the lock of a stream, which comes before edit_mutex_.
      if (answer.has_value()) done(*answer);
      if (!ended().ok()) NotifyListeners();
      return;
    }
    // Freed first, so that the old and the new candidate are never in memory together.
    candidate.reset();
    target = nullptr;
    auto prepared = PrepareFor(batch, *wanted, stop);
    if (IsStopped(prepared.status())) {
      ++counts().edits_refused;
      return done(prepared.status());
    }
    if (prepared.ok()) {
      candidate.emplace(PlanCandidate{*std::move(wanted), std::move(prepared->state)});
      target = std::move(prepared->target);
    } else {
      candidate.emplace(PlanCandidate{*std::move(wanted), prepared.status()});
    }
  }
}

Scene::Answer Scene::TryEdits(const EditBatch& batch, std::optional<PlanCandidate>& candidate,
                              std::shared_ptr<TargetSlot> target, std::optional<PlanKey>& wanted,
                              const EditDone& done) {
  // Destroyed after the locks are released, because a large plan takes long to destroy.
  const RenderInput retired = Head();
  const MutexLock edit_lock(&edit_mutex_);
  if (const absl::Status admitted = AdmitEdit(); !admitted.ok()) {
    ++counts().edits_refused;
    return admitted;
  }
  const auto now = Now();
  const uint64_t records = editor_.records();
  SceneJournal::Attempt attempt(journal_);
  auto commit = editor_.Apply(batch, *applied_, candidate, wanted, now, absl::Now);
  if (wanted.has_value()) {
    attempt.Done();
    return std::nullopt;
  }
  if (commit.ok() && commit->state != nullptr) applied_ = commit->state;
  const bool is_recorded = editor_.records() != records;
  if (!journal_.durable()) {
    attempt.Done();
    Answer answer = Settle(commit, target, absl::OkStatus());
    EditRecord forgotten;
    if (is_recorded) FitHistory(forgotten);
    return answer;
  }

  const bool new_box = commit.ok() && commit->box_changed;
  std::optional<absl::Time> commit_time;
  if (commit.ok() && commit->state != nullptr) commit_time = commit->state->commit_time;
  auto then = [self = shared_from_this(), commit = std::move(commit), target = std::move(target),
               done](const absl::Status& durable) { done(self->Settle(commit, target, durable)); };
  if (!is_recorded) {
    journal_.Wait(std::move(then));
    attempt.Done();
    return std::nullopt;
  }
  SceneRecord record{.edit = editor_.LastRecord(batch, now), .commit_time = absl::Now()};
  if (commit_time.has_value()) record.commit_time = *commit_time;
  FitHistory(record.edit);
  // A box that followed from the plan, which no later life of the scene makes.
  if (new_box || !std::exchange(is_box_stored_, true)) record.box = applied_->box;
  journal_.Append(records + 1, record, std::move(then));
  attempt.Done();
  MaybeSnapshot(record);
  return std::nullopt;
}

void Scene::MaybeSnapshot(const SceneRecord& record) {
  if (!journal_.WantsSnapshot()) return;
  // The edit is on its way already: without memory for a snapshot, a later edit makes one.
  const auto put = CatchBadAlloc("the snapshot", [&]() ABSL_NO_THREAD_SAFETY_ANALYSIS {
    journal_.PutSnapshot(editor_.records(), {.histories = editor_.history().images(),
                                             .box = applied_->box,
                                             .now = record.edit.now,
                                             .commit_time = record.commit_time});
    return absl::OkStatus();
  });
  put.IgnoreError();
}

SceneLog Scene::Copy() {
  SceneImage image;
  uint64_t records = 0;
  {
    const MutexLock lock(&edit_mutex_);
    records = editor_.records();
    image = {.histories = editor_.history().images(),
             .box = applied_->box,
             .now = Now(),
             .commit_time = absl::Now()};
  }
  SceneLog log{.header = config_.stored_header, .snapshot_lsn = records};
  if (log.snapshot_lsn > 0) log.snapshot = EncodeImage(image);
  return log;
}

absl::Status Scene::AdmitEdit() {
  LATTICED_RETURN_IF_ERROR(ended());
  if (journal_.is_broken() && journal_.is_idle()) {
    LATTICED_RETURN_IF_ERROR(ReadAgain());
  }
  return journal_.Admit();
}

absl::Status Scene::ReadAgain() {
  const auto log = journal_.Read();
  if (absl::IsAborted(log.status())) return Lose();
  LATTICED_RETURN_IF_ERROR(log.status());
  LATTICED_ASSIGN_OR_RETURN(auto life,
                            Replay(*log, {config_.weights, config_.mesh->positions.size()}));
  auto head = State();
  // What was refused is stored: clients learn it from the scene that is made from the store.
  if (life.history.revision() != head->revision) return Lose();
  editor_ = SceneEditor(std::move(life.history), config_.fold_watch);
  applied_ = std::move(head);
  is_box_stored_ = life.box.has_value() && life.box->id == applied_->box.id;
  journal_.Mend();
  return absl::OkStatus();
}

absl::Status Scene::Lose() {
  Life lives = Life::kLives;
  life_.compare_exchange_strong(lives, Life::kLeft);
  return ended();
}

absl::StatusOr<EditSummary> Scene::Settle(const absl::StatusOr<EditCommit>& commit,
                                          const std::shared_ptr<TargetSlot>& target,
                                          const absl::Status& durable) {
  if (absl::IsAborted(durable)) {
    const absl::Status lost = Lose();
    NotifyListeners();
    ++counts().edits_refused;
    return lost;
  }
  const absl::Status& refusal = durable.ok() ? commit.status() : durable;
  if (!refusal.ok()) {
    ++counts().edits_refused;
    return refusal;
  }
  EditSummary summary = commit->summary;
  if (commit->state == nullptr) {
    ++counts().edits_repeated;
    return summary;
  }
  summary.commit_time = std::chrono::steady_clock::now();
  Publish(*commit, target);
  return summary;
}

void Scene::Publish(const EditCommit& commit, std::shared_ptr<TargetSlot> target) {
  // Destroyed after the lock is released, because a large plan takes long to destroy.
  RenderInput replaced;
  {
    const MutexLock lock(&mutex_);
    replaced = head_;
    head_.state = commit.state;
    if (commit.structure_changed) {
      head_.target = std::move(target);
      moved_ = PointRevisions(commit.state->control_points->size(), commit.state->revision);
    } else {
      moved_.Move(commit.moved, commit.state->revision);
    }
    for (const auto& [key, view] : views_) {
      const bool all = commit.structure_changed || (commit.box_changed && HasPositions(key.spec));
      all ? view->MarkAllDirty() : view->MarkDirty(commit.dirty);
    }
    log_.Add(commit.delta, commit.structure_changed || commit.constraints_changed);
    last_use_ = absl::Now();
  }
  ++counts().edits_applied;
  RequestWork();  // before the listeners: each of them may take the time to build a message
  NotifyListeners();
}

void Scene::FitHistory(EditRecord& record) {
  do {
    history_bytes_ = HistoryBytes();
  } while (!history_reservation_.Hold(history_bytes_, applied_->lattices) && ForgetOldest(record));
}

bool Scene::ForgetOldest(EditRecord& record) {
  if (editor_.ForgetOldestStep()) {
    ++counts().undo_steps_forgotten;
    ++record.steps_forgotten;
    return true;
  }
  {
    const MutexLock lock(&mutex_);
    if (log_.ForgetOldest()) return true;
  }
  if (!editor_.ForgetOldestEditor()) return false;
  ++record.editors_forgotten;
  return true;
}

}  // namespace latticed
