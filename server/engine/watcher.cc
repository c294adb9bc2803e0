// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/watcher.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/engine/scene/topology_id.h"

namespace latticed {
namespace {

// Of a run's name in tokens, which every update has.
constexpr size_t kRunDigits = 8;

// kInvalidArgument if the plan has more points than the view allows, even in the least detail.
absl::Status CheckMaxPoints(const WatchView& view, const DeformPlan& plan) {
  const uint64_t least =
      plan.patches.size() * static_cast<uint64_t>(PointsPerPatch(limits::kMinSegments));
  if (view.max_points == 0 || least <= view.max_points) return absl::OkStatus();
  return error::InvalidField(
      "view.max_points",
      fmt::format("got {}, 1 segment already needs {} points", view.max_points, least),
      "OUT_OF_RANGE");
}

}  // namespace

Watcher::Watcher(std::shared_ptr<Scene> scene, const WatcherOptions& options)
    : scene_(std::move(scene)),
      editor_id_(options.editor_id),
      account_(options.account),
      scope_{scene_->config().token_key, options.evaluator, options.run.substr(0, kRunDigits)},
      only_full_detail_(options.only_full_detail) {
  client_.max_unacked_updates = options.max_unacked_updates;
}

absl::StatusOr<std::unique_ptr<Watcher>> Watcher::Create(std::shared_ptr<Scene> scene,
                                                         WatcherOptions options) {
  std::unique_ptr<Watcher> watcher(new Watcher(std::move(scene), options));
  LATTICED_RETURN_IF_ERROR(watcher->UseView(options.view));
  const auto state = watcher->scene_->State();
  ClientState& client = watcher->client_;
  client.had =
      ParseResumeToken(options.resume_token, watcher->scope_, watcher->key(), *state,
                       [&](uint64_t revision) { return watcher->scene_->CommitTime(revision); });
  watcher->resumed_ = client.had.has_value();
  // Revisions must never go back, but an idle view may hold an older snapshot than this client saw elsewhere.
  client.min_revision = std::max(options.min_revision, state->revision);
  return watcher;
}

Watcher::~Watcher() {
  Drop();
  if (attached_) board_->Detach(absl::Now());
}

absl::Status Watcher::UseView(const WatchView& asked) {
  const auto state = scene_->State();
  LATTICED_RETURN_IF_ERROR(CheckMaxPoints(asked, *state->plan));
  LATTICED_ASSIGN_OR_RETURN(auto board, scene_->AcquireView(asked.key, account_));
  if (attached_) board_->Detach(absl::Now());
  attached_ = false;
  full_board_ = board_ = std::move(board);
  asked_ = asked;
  detail_ = LevelOfDetail(asked);
  UpdateActivity();
  return absl::OkStatus();
}

absl::Status Watcher::SetView(const WatchView& view) {
  const bool same_bounds = view.key == asked_.key && view.client_normals != asked_.client_normals;
  LATTICED_RETURN_IF_ERROR(UseView(view));
  if (!same_bounds) return absl::OkStatus();
  // An update tells the client that its view has changed.
  Drop();
  client_.had.reset();
  return absl::OkStatus();
}

void Watcher::SwitchTo(const ViewKey& key) {
  if (key == board_->key()) return;
  auto board =
      key == asked_.key ? full_board_ : scene_->AcquireView(key, account_).value_or(nullptr);
  if (board == nullptr) return;
  if (attached_) {
    const absl::Time now = absl::Now();
    board->Attach(now);
    board_->Detach(now);
    scene_->RequestWork();
  }
  board_ = std::move(board);
}

void Watcher::ChooseDetail(absl::Time now) {
  if (only_full_detail_) return SwitchTo(asked_.key);
  const auto state = scene_->State();
  const std::optional<ClientSurface>& had = client_.had;
  const bool same_grid = had.has_value() && had->structure_id == state->structure_id &&
                         had->quantisation_id == QuantisationId(had->view, state->box);
  SwitchTo(detail_.Choose(*state, same_grid ? &had->view : nullptr, now));
  const absl::Time change = LevelOfDetail::ChangesAt(*state);
  if (board_ != full_board_ && change > now) wake_at_ = change;
}

bool Watcher::GivesWay(const Snapshot& snapshot, absl::Time now) {
  if (only_full_detail_ || snapshot.view.spec.segments != asked_.key.spec.segments) return false;
  const auto state = scene_->State();
  if (state->revision == snapshot.revision) return false;
  uint64_t left = 0;
  for (size_t i = client_.update->sent; i < client_.update->chunks.size(); ++i) {
    left += snapshot.chunks[client_.update->chunks[i]].data.size();
  }
  return detail_.GivesWay(*state, left, now);
}

void Watcher::UpdateActivity() {
  client_.takes_updates = !paused_ && !silent_;
  if (client_.takes_updates == attached_) return;
  attached_ = client_.takes_updates;
  attached_ ? board_->Attach(absl::Now()) : board_->Detach(absl::Now());
  if (attached_) scene_->RequestWork();
}

void Watcher::Drop() {
  DropUpdate(client_);
  lease_.reset();
}

absl::Status Watcher::CheckAck(uint64_t update_id) const {
  if (update_id <= client_.last_update_id) return absl::OkStatus();
  return error::OutOfRange("acked_update_id", static_cast<double>(update_id), 0,
                           static_cast<double>(client_.last_update_id));
}

absl::Status Watcher::Ack(uint64_t update_id) {
  LATTICED_RETURN_IF_ERROR(CheckAck(update_id));
  Acknowledge(client_, update_id);
  // If no update is in progress, Next asks for a newer snapshot when the client can take one.
  if (update_in_progress()) WantNewer(nullptr);
  return absl::OkStatus();
}

void Watcher::SetPaused(bool paused) {
  paused_ = paused;
  UpdateActivity();
}

void Watcher::SetSilent(bool silent) {
  silent_ = silent;
  if (silent_) Drop();
  UpdateActivity();
}

bool Watcher::lattice_current() const {
  return has_lattice() && *client_.lattice_revision >= scene_->State()->revision;
}

absl::StatusOr<std::optional<WatchEvent>> Watcher::Next(absl::Time now) {
  wake_at_ = absl::InfiniteFuture();
  LATTICED_RETURN_IF_ERROR(scene_->ended());
  auto [state, deltas] = scene_->LatticeAfter(client_.lattice_revision);
  WatchOffer offer{
      .state = std::move(state), .deltas = std::move(deltas), .asked = asked_, .now = now};
  if (LatticeIsDue(client_, offer.deltas)) return latticed::Next(client_, offer).event;

  if (attached_ && !board_->failure().ok()) {
    if (board_ == full_board_) return board_->failure();
    WantFullDetail();
  }
  offer.snapshot = TakeSnapshot(now);
  if (offer.snapshot != nullptr) offer.topology_id = TopologyOf(*offer.snapshot);
  const bool had_update = update_in_progress();
  auto next = latticed::Next(client_, offer);
  if (!had_update && update_in_progress()) detail_.Learn(*offer.snapshot);
  WantNewer(offer.snapshot.get());
  if (!update_in_progress()) lease_.reset();
  wake_at_ = std::min(wake_at_, next.wake_at);
  if (!next.event.has_value()) return std::nullopt;
  if (auto* end = std::get_if<UpdateEnds>(&*next.event)) Complete(*end);
  Count(*next.event);
  return std::move(next.event);
}

std::shared_ptr<const Snapshot> Watcher::TakeSnapshot(absl::Time now) {
  if (update_in_progress()) {
    auto snapshot = lease_->Get(now);
    const bool gives_way =
        snapshot != nullptr && (GivesWay(*snapshot, now) || LacksLattice(client_, *snapshot));
    if (snapshot != nullptr && !gives_way) return snapshot;
    if (gives_way && client_.update->id != 0) ++scene_->counts().updates_superseded;
    Drop();
  }
  if (!client_.takes_updates || !AcksAllow(client_, 1)) return nullptr;
  ChooseDetail(now);
  lease_ = SnapshotLease::OfNewest(board_, now);
  if (!lease_.has_value()) return nullptr;
  return lease_->Get(now);
}

void Watcher::WantNewer(const Snapshot* offered) {
  if (!WantsNewer(client_, offered)) return;
  if (lease_.has_value() && lease_->board() != board_) return;
  if (board_->Want(lease_.has_value() ? lease_->number() : 0)) scene_->RequestWork();
}

const std::string& Watcher::TopologyOf(const Snapshot& snapshot) {
  const std::pair of(snapshot.structure_id, TopologySegments(snapshot.view.spec));
  if (std::exchange(named_, of) != of) {
    name_ = TopologyId(WeightedMeshId(IdOf(scene_->config().mesh_id), snapshot.plan->mesh_weights),
                       *snapshot.plan, of.second);
  }
  return name_;
}

void Watcher::Complete(UpdateEnds& end) {
  end.resume_token = MakeResumeToken(scope_, *client_.had);
  if (!editor_id_.empty()) {
    applied_sequence_ =
        std::max(applied_sequence_, scene_->AppliedSequence(editor_id_, end.revision));
  }
  end.applied_sequence = applied_sequence_;
}

void Watcher::Count(const WatchEvent& event) const {
  EngineCounts& counts = scene_->counts();
  if (const auto* begin = std::get_if<UpdateBegins>(&event)) {
    ++counts.updates_begun;
    if (begin->restart) ++counts.updates_restarted;
  } else if (const auto* batch = std::get_if<ChunkBatch>(&event)) {
    counts.chunk_bytes += batch->bytes;
  } else if (const auto* end = std::get_if<UpdateEnds>(&event)) {
    ++counts.updates_finished;
    // A first update may belong to an edit of long ago.
    if (end->update_id > 1) counts.queue.Observe(end->queue_time);
    counts.send.Observe(end->send_time);
  }
}

}  // namespace latticed
