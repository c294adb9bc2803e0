// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/scene_load.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "client/cpp/load/closed_loop_editor.h"
#include "client/cpp/load/lattice_replay.h"
#include "client/cpp/load/periodic_editor.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

using Pace = LoadWatcher::Pace;

constexpr size_t kLastChunks = 4;     // verified of a stream that does not keep up
constexpr uint64_t kWarmUpEdits = 4;  // an even number: all points are back where they were

// Names the scene in the message. Keeps the details.
absl::Status About(const absl::Status& status, const std::string& scene) {
  if (status.ok()) return status;
  return error::WithDetails(absl::Status(status.code(), fmt::format("scene {}: {}", scene,
                                                                    std::string(status.message()))),
                            error::DetailsOf(status));
}

}  // namespace

SceneLoad::SceneLoad(const LoadPlan* plan, LoadScene scene, NewClient new_client,
                     LoadControl* control)
    : plan_(*plan),
      scene_(std::move(scene.id)),
      mesh_(std::move(scene.mesh)),
      new_client_(std::move(new_client)),
      control_(control),
      client_(new_client_()) {}

v1::WatchRequest SceneLoad::Request() const {
  v1::WatchRequest request;
  request.set_scene(scene_);
  *request.mutable_view() = plan_.view;
  return request;
}

absl::Status SceneLoad::Open() {
  LATTICED_ASSIGN_OR_RETURN(lattice_, client_->GetLattice(scene_));
  LATTICED_RETURN_IF_ERROR(OpenEditors());
  const bool decode_all = plan_.decoding == Decoding::kAll;
  LATTICED_RETURN_IF_ERROR(OpenWatchers(plan_.watchers, {.decodes = decode_all}));
  LATTICED_RETURN_IF_ERROR(
      OpenWatchers(plan_.slow, {.pace = Pace::kSlow, .bytes_per_second = plan_.slow_rate}));
  return OpenWatchers(plan_.stalled, {.pace = Pace::kStalled});
}

absl::Status SceneLoad::OpenEditors() {
  for (int i = 0; i < plan_.editors; ++i) {
    const bool decodes =
        plan_.decoding == Decoding::kAll || (plan_.decoding == Decoding::kFirst && i == 0);
    const auto open =
        plan_.mode == LoadMode::kClosed ? ClosedLoopEditor::Open : PeriodicEditor::Open;
    auto editor = open(new_client_(), Request(),
                       {.plan = &plan_,
                        .lattice = &lattice_,
                        .edits = &edits_,
                        .control = control_,
                        .number = i,
                        .decodes = decodes});
    if (!editor.ok()) return About(editor.status(), scene_);
    editors_.push_back(*std::move(editor));
  }
  return absl::OkStatus();
}

absl::Status SceneLoad::OpenWatchers(int count, const LoadWatcher::Options& options) {
  for (int i = 0; i < count && !control_->Ended(); ++i) {
    auto watcher = LoadWatcher::Open(new_client_(), Request(), options, control_);
    if (!watcher.ok()) return About(watcher.status(), scene_);
    watchers_.push_back(*std::move(watcher));
  }
  return absl::OkStatus();
}

absl::Status SceneLoad::WarmUp() {
  v1::EditBatch batch;
  const std::string editor = RandomEditorId();
  for (uint64_t step = 0; step < kWarmUpEdits && !control_->Ended(); ++step) {
    batch = MakeLoadEdit(lattice_, /*all_points=*/true, step);
    batch.set_scene(scene_);
    batch.set_editor_id(editor);
    batch.set_sequence(step + 1);
    const auto result = client_->ApplyEdits(batch);
    if (!result.ok()) return About(result.status(), scene_);
    first_revision_ = result->revision();
    warm_up_.push_back({.revision = first_revision_, .editor = kWarmUpEditor, .step = step});
    LATTICED_RETURN_IF_ERROR(WaitForAll(first_revision_));
  }
  return absl::OkStatus();
}

void SceneLoad::Start(absl::Time begin) {
  for (const auto& editor : editors_) editor->Start(begin);
}

void SceneLoad::WaitUntilDone() {
  for (const auto& editor : editors_) editor->WaitUntilDone();
}

absl::Status SceneLoad::Settle() {
  const auto scene = client_->GetScene(scene_);
  if (!scene.ok()) return About(scene.status(), scene_);
  return WaitForAll(scene->revision());
}

absl::Status SceneLoad::WaitForAll(uint64_t revision) const {
  absl::Status status;
  for (const auto& editor : editors_) status.Update(editor->WaitFor(revision));
  for (const auto& watcher : watchers_) {
    if (watcher->pace() == Pace::kFull) {
      status.Update(watcher->log().WaitFor(revision));
    }
  }
  return About(status, scene_);
}

void SceneLoad::Close() {
  for (const auto& editor : editors_) editor->Close();
  for (const auto& watcher : watchers_) watcher->Close();
}

absl::Status SceneLoad::Verify(bool fused) {
  SurfaceVerifier verifier(client_.get(), scene_, mesh_, fused);
  size_t stream = 0;
  absl::Status status;
  for (const auto& editor : editors_) {
    status.Update(verifier.Check(editor->surface(), stream++));
  }
  for (const auto& watcher : watchers_) {
    if (watcher->pace() != Pace::kFull) continue;
    status.Update(verifier.Check(watcher->surface(), stream++));
  }
  if (status.ok()) status = VerifySamples(verifier);
  verified_ = verifier.result();
  return About(status, scene_);
}

std::vector<SampledUpdate> SceneLoad::Samples() const {
  std::vector<SampledUpdate> samples;
  const auto add = [&](const UpdateLog& log) {
    // A slow watcher may still have been at the warm-up.
    std::ranges::copy_if(log.samples(), std::back_inserter(samples), [&](const SampledUpdate& s) {
      return s.surface.revision() > first_revision_;
    });
  };
  for (const auto& editor : editors_) add(editor->log());
  for (const auto& watcher : watchers_) {
    add(watcher->log());
    if (watcher->pace() == Pace::kFull) continue;
    const Surface& last = watcher->surface();
    samples.emplace_back(last, SpreadChunks(last.chunk_count(), kLastChunks, samples.size()));
  }
  std::ranges::sort(samples, {}, [](const SampledUpdate& s) { return s.surface.revision(); });
  return samples;
}

absl::Status SceneLoad::VerifySamples(SurfaceVerifier& verifier) const {
  std::vector<AppliedEdit> edits = warm_up_;
  edits.insert(edits.end(), edits_.applied().begin(), edits_.applied().end());
  LatticeReplay replay(plan_, lattice_, std::move(edits));
  for (const SampledUpdate& sample : Samples()) {
    LATTICED_ASSIGN_OR_RETURN(const auto control_points, replay.At(sample.surface.revision()));
    LATTICED_RETURN_IF_ERROR(verifier.CheckPast(sample.surface, sample.chunks, control_points));
  }
  return absl::OkStatus();
}

void SceneLoad::AddTo(LoadReport* report) const {
  report->edits += edits_.edits().size();
  report->replaced += edits_.replaced();
  report->unsent += edits_.unsent();
  std::vector<TimedEdit> edits = edits_.edits();
  std::sort(edits.begin(), edits.end(),
            [](const TimedEdit& a, const TimedEdit& b) { return a.revision < b.revision; });
  for (const auto& editor : editors_) report->editors.Add(editor->log(), edits, first_revision_);
  for (const auto& watcher : watchers_) {
    const UpdateLog& log = watcher->log();
    if (watcher->pace() == Pace::kFull) report->watchers.Add(log, edits, first_revision_);
    if (watcher->pace() == Pace::kSlow) report->slow.Add(log, edits, first_revision_);
  }
  std::vector<AppliedEdit> applied = edits_.applied();
  std::ranges::sort(applied, {}, &AppliedEdit::revision);
  report->stages.Add(editors_.front()->log(), applied, first_revision_);
  const v1::Topology& topology = editors_.front()->surface().topology();
  report->patches += topology.patch_count();
  report->points += topology.point_count();
  report->encoding = editors_.front()->surface().view().encoding();
  report->verified.Add(verified_);
}

}  // namespace latticed::client
