// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/watch/watcher.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"
#include "server/engine/topology_id.h"

namespace latticed {
namespace {

// The first batch of an update is small, so that something arrives early.
constexpr size_t kFirstBatchBytes = size_t{32} << 10;
// max_bytes_per_second may be exceeded for so long after a pause.
constexpr absl::Duration kBurst = absl::Milliseconds(250);

// kInvalidArgument where even the least detail of the plan has more points than the view allows.
absl::Status CheckMaxPoints(const WatchView& view, const DeformPlan& plan) {
  const uint64_t least =
      plan.patches.size() * static_cast<uint64_t>(PointsPerPatch(limits::kMinSegments));
  if (view.max_points == 0 || least <= view.max_points) return absl::OkStatus();
  return error::InvalidField(
      "view.max_points",
      fmt::format("got {}, 1 segment makes {} points already", view.max_points, least),
      "OUT_OF_RANGE");
}

// Every number that distinguishes views, for the resume token.
std::string KeyText(const ViewKey& key) {
  const ViewSpec& s = key.spec;
  return fmt::format("{}.{}.{}.{}.{}.{}", s.segments, static_cast<int>(s.normals),
                     static_cast<int>(s.format), s.position_bits, s.normal_bits,
                     static_cast<int>(key.encoding));
}

}  // namespace

Watcher::Watcher(std::shared_ptr<Scene> scene, WatcherOptions options)
    : scene_(std::move(scene)), options_(std::move(options)) {}

absl::StatusOr<std::unique_ptr<Watcher>> Watcher::Create(std::shared_ptr<Scene> scene,
                                                         WatcherOptions options) {
  std::unique_ptr<Watcher> watcher(new Watcher(std::move(scene), std::move(options)));
  LATTICED_RETURN_IF_ERROR(watcher->UseView(watcher->options_.view));
  watcher->had_ = watcher->ParseToken(watcher->options_.resume_token);
  watcher->resumed_ = watcher->had_.has_value();
  // An idle view may hold an older snapshot than this client saw elsewhere: revisions never go
  // back.
  uint64_t& least = watcher->options_.min_revision;
  least = std::max(least, watcher->scene_->State()->revision);
  return watcher;
}

Watcher::~Watcher() {
  DropUpdate();
  if (active_) view_->RemoveActive();
}

absl::Status Watcher::UseView(const WatchView& asked) {
  LATTICED_RETURN_IF_ERROR(CheckMaxPoints(asked, *scene_->State()->plan));
  LATTICED_ASSIGN_OR_RETURN(auto view, scene_->AcquireView(asked.key));
  if (active_) view_->RemoveActive();
  active_ = false;
  full_view_ = view_ = std::move(view);
  asked_ = asked;
  detail_ = LevelOfDetail(asked);
  UpdateActivity();
  return absl::OkStatus();
}

void Watcher::SwitchTo(const ViewKey& key) {
  if (key == view_->key()) return;
  auto view = key == full_view_->key() ? full_view_ : scene_->AcquireView(key).value_or(nullptr);
  if (view == nullptr) return;
  if (active_) {
    view->AddActive();
    view_->RemoveActive();
    scene_->RequestWork();
  }
  view_ = std::move(view);
}

void Watcher::ChooseDetail(absl::Time now) {
  if (options_.only_full_detail) return SwitchTo(full_view_->key());
  const auto state = scene_->State();
  const bool same_grid = had_.has_value() && had_->structure_id == state->structure_id &&
                         had_->quantisation_id == state->box.id;
  SwitchTo(detail_.Choose(*state, same_grid ? &had_->view : nullptr, now));
  const absl::Time change = LevelOfDetail::ChangesAt(*state);
  if (view_ != full_view_ && change > now) wake_at_ = change;
}

bool Watcher::GivesWay(const Snapshot& snapshot, absl::Time now) {
  const int segments = full_view_->key().spec.segments;
  if (options_.only_full_detail || snapshot.view.spec.segments != segments) return false;
  const auto state = scene_->State();
  if (state->revision == snapshot.revision) return false;
  uint64_t left = 0;
  for (size_t i = current_->sent; i < current_->chunks.size(); ++i) {
    left += snapshot.chunks[current_->chunks[i]].data.size;
  }
  return detail_.GivesWay(*state, left, now);
}

void Watcher::UpdateActivity() {
  const bool wanted = !paused_ && !silent_;
  if (wanted == active_) return;
  active_ = wanted;
  active_ ? view_->AddActive() : view_->RemoveActive();
  if (active_) scene_->RequestWork();
}

void Watcher::DropUpdate() {
  if (!current_.has_value()) return;
  current_view_->Unpin(current_->number);
  current_view_ = nullptr;
  restart_ = restart_ || current_->begun;
  // Nobody will acknowledge what did not end.
  std::erase(unacked_, current_->id);
  current_.reset();
}

absl::Status Watcher::CheckAck(uint64_t update_id) const {
  if (update_id <= last_update_id_) return absl::OkStatus();
  return error::OutOfRange("acked_update_id", static_cast<double>(update_id), 0,
                           static_cast<double>(last_update_id_));
}

absl::Status Watcher::Ack(uint64_t update_id) {
  LATTICED_RETURN_IF_ERROR(CheckAck(update_id));
  std::erase_if(unacked_, [update_id](uint64_t id) { return id <= update_id; });
  // Where no update is under way, BeginUpdate asks for what it may take.
  if (!active_ || !current_.has_value() || current_view_ != view_) return absl::OkStatus();
  const size_t with_next = current_->begun ? 1 : 2;
  if (AcksAllow(with_next) && view_->TakeNext(current_->number)) scene_->RequestWork();
  return absl::OkStatus();
}

absl::Status Watcher::SetView(const WatchView& view) { return UseView(view); }

void Watcher::SetPaused(bool paused) {
  paused_ = paused;
  UpdateActivity();
}

void Watcher::SetSilent(bool silent) {
  silent_ = silent;
  if (silent_) DropUpdate();
  UpdateActivity();
}

bool Watcher::lattice_current() const {
  return lattice_revision_.has_value() && *lattice_revision_ >= scene_->State()->revision;
}

absl::StatusOr<std::optional<WatcherEvent>> Watcher::Next(absl::Time now) {
  wake_at_ = absl::InfiniteFuture();
  if (scene_->deleted()) return error::NotFound("scene", scene_->id());
  if (auto event = NextLattice(); event.has_value()) return event;
  if (active_) {
    if (auto s = view_->failure(); !s.ok()) {
      if (view_ == full_view_) return s;
      WantFullDetail();
    }
  }
  std::shared_ptr<const Snapshot> snapshot;
  if (current_.has_value()) {
    snapshot = current_view_->Find(current_->number);
    if (snapshot != nullptr && GivesWay(*snapshot, now)) {
      if (current_->begun) ++scene_->counts().updates_superseded;
      snapshot = nullptr;
    }
    if (snapshot == nullptr) DropUpdate();
  }
  if (!current_.has_value()) {
    if (!MayBegin()) return std::nullopt;
    BeginUpdate(now);
    if (!current_.has_value()) return std::nullopt;
    snapshot = current_view_->Find(current_->number);
    // Retired between the two calls: the newer snapshot wakes this watcher again.
    if (snapshot == nullptr) return std::nullopt;
  }
  return NextOfUpdate(snapshot, now);
}

std::optional<WatcherEvent> Watcher::NextLattice() {
  if (lattice_revision_.has_value()) {
    const EditLog::Deltas news = scene_->DeltasAfter(*lattice_revision_);
    if (news.complete && news.deltas.empty()) return std::nullopt;
    if (news.complete && news.deltas.front()->structure_id == lattice_structure_) {
      lattice_revision_ = news.deltas.front()->revision;
      return news.deltas.front();
    }
  }
  auto state = scene_->State();
  lattice_revision_ = state->revision;
  lattice_structure_ = state->structure_id;
  return LatticeWhole{std::move(state)};
}

bool Watcher::AcksAllow(size_t updates) const {
  const size_t most = options_.max_unacked_updates;
  return most == 0 || unacked_.size() + updates <= most;
}

bool Watcher::MayBegin() const { return active_ && AcksAllow(1); }

bool Watcher::Comparable(const Snapshot& snapshot) const {
  return had_.has_value() && had_->view == snapshot.view &&
         had_->structure_id == snapshot.structure_id && had_->quantisation_id == snapshot.box.id;
}

bool Watcher::HasNothingNew(const Snapshot& newest) const {
  return covered_ == newest.revision && !restart_ && Comparable(newest);
}

void Watcher::BeginUpdate(absl::Time now) {
  ChooseDetail(now);
  if (const auto newest = view_->newest(); newest != nullptr && HasNothingNew(*newest)) {
    if (view_->WaitForNewer(newest->number, AcksAllow(2))) scene_->RequestWork();
    return;
  }
  uint64_t at_least = std::max(options_.min_revision, covered_.value_or(0));
  if (had_.has_value()) at_least = std::max(at_least, had_->revision);
  // Nothing in other detail of what it has, where there is something newer.
  if (covered_.has_value() && had_->view != view_->key()) {
    at_least = std::max(at_least, std::min(*covered_ + 1, scene_->State()->revision));
  }
  const auto snapshot = view_->PinNewest(at_least, /*takes_next=*/AcksAllow(2));
  scene_->RequestWork();
  if (snapshot == nullptr) return;
  if (ceiling_.has_value() && snapshot->revision > *ceiling_) {
    view_->Unpin(snapshot->number);
    return;
  }

  detail_.Learn(*snapshot);
  current_view_ = view_;
  current_.emplace();
  current_->number = snapshot->number;
  current_->topology_id = TopologyOf(*snapshot);
  if (Comparable(*snapshot)) {
    current_->chunks = snapshot->chunks.ChangedAfter(had_->revision);
  } else {
    current_->chunks.resize(snapshot->chunks.size());
    std::iota(current_->chunks.begin(), current_->chunks.end(), 0u);
  }
}

const std::string& Watcher::TopologyOf(const Snapshot& snapshot) {
  const std::pair of(snapshot.structure_id, snapshot.view.spec.segments);
  if (std::exchange(named_, of) != of) {
    name_ = TopologyId(scene_->config().mesh_id, snapshot.plan->structure, of.second);
  }
  return name_;
}

std::optional<WatcherEvent> Watcher::NextOfUpdate(const std::shared_ptr<const Snapshot>& snapshot,
                                                  absl::Time now) {
  if (topology_id_ != current_->topology_id) {
    topology_id_ = current_->topology_id;
    return TopologyNews{topology_id_, snapshot};
  }
  const std::pair quantisation(snapshot->box.id, snapshot->view);
  if (quantisation_ != quantisation) {
    quantisation_ = quantisation;
    return QuantisationNews{snapshot};
  }
  if (!current_->begun) return MakeBegin(*snapshot, now);
  if (current_->sent == current_->chunks.size()) return MakeEnd(*snapshot, now);
  if (now < next_batch_time_) {
    wake_at_ = next_batch_time_;
    return std::nullopt;
  }
  return MakeBatch(snapshot, now);
}

WatcherEvent Watcher::MakeBegin(const Snapshot& snapshot, absl::Time now) {
  current_->id = ++last_update_id_;
  current_->begun = true;
  current_->begin_time = now;
  ++scene_->counts().updates_begun;
  if (restart_) ++scene_->counts().updates_restarted;
  if (options_.max_unacked_updates > 0) unacked_.push_back(current_->id);
  WatchView in_force = asked_;
  in_force.key = snapshot.view;
  return UpdateBegins{.update_id = current_->id,
                      .revision = snapshot.revision,
                      .chunk_count = current_->chunks.size(),
                      .restart = std::exchange(restart_, false),
                      .view = in_force};
}

WatcherEvent Watcher::MakeBatch(const std::shared_ptr<const Snapshot>& snapshot, absl::Time now) {
  ChunkBatch batch{
      .update_id = current_->id, .topology_id = current_->topology_id, .snapshot = snapshot};
  const size_t enough = current_->sent == 0 ? kFirstBatchBytes : limits::kMinChunkBatchBytes;
  while (current_->sent < current_->chunks.size() && batch.bytes < enough) {
    const uint32_t chunk = current_->chunks[current_->sent];
    const size_t bytes = snapshot->chunks[chunk].data.size;
    if (!batch.chunks.empty() && batch.bytes + bytes > limits::kMaxChunkBatchBytes) break;
    batch.chunks.push_back(chunk);
    batch.bytes += bytes;
    ++current_->sent;
  }
  scene_->counts().chunk_bytes += batch.bytes;
  if (asked_.max_bytes_per_second > 0) {
    const double seconds =
        static_cast<double>(batch.bytes) / static_cast<double>(asked_.max_bytes_per_second);
    next_batch_time_ = std::max(next_batch_time_, now - kBurst) + absl::Seconds(seconds);
  }
  return batch;
}

void Watcher::CountEnd(const Snapshot& snapshot, absl::Time now) const {
  EngineCounts& counts = scene_->counts();
  ++counts.updates_finished;
  if (covered_.has_value()) counts.queue.Observe(current_->begin_time - snapshot.edit_time);
  counts.send.Observe(now - current_->begin_time);
}

WatcherEvent Watcher::MakeEnd(const Snapshot& snapshot, absl::Time now) {
  CountEnd(snapshot, now);
  had_ = Had{.view = snapshot.view,
             .structure_id = snapshot.structure_id,
             .quantisation_id = snapshot.box.id,
             .revision = snapshot.revision};
  covered_ = snapshot.revision;
  if (!options_.editor_id.empty()) {
    applied_sequence_ =
        std::max(applied_sequence_, scene_->AppliedSequence(options_.editor_id, snapshot.revision));
  }
  UpdateEnds end{.update_id = current_->id,
                 .revision = snapshot.revision,
                 .head_revision = scene_->State()->revision,
                 .applied_sequence = applied_sequence_,
                 .full_detail = snapshot.view == full_view_->key(),
                 .resume_token = MakeToken(),
                 .queue_time = current_->begin_time - snapshot.edit_time,
                 .evaluate_time = snapshot.evaluate_time,
                 .encode_time = snapshot.encode_time,
                 .send_time = now - current_->begin_time};
  current_view_->Unpin(current_->number);
  current_view_ = nullptr;
  current_.reset();
  return end;
}

std::string Watcher::MakeToken() const {
  // Structures and revisions begin anew in a scene that is created again under the id of a deleted
  // one.
  return fmt::format("{}/{}/{}/{}/{}/{}/{}", options_.boot_id, scene_->id(), scene_->incarnation(),
                     had_->structure_id, had_->quantisation_id, had_->revision,
                     KeyText(had_->view));
}

std::optional<Watcher::Had> Watcher::ParseToken(std::string_view token) const {
  const std::vector<std::string> parts = absl::StrSplit(std::string(token), '/');
  Had had;
  uint64_t incarnation = 0;
  if (parts.size() != 7 || parts[0] != options_.boot_id || parts[1] != scene_->id() ||
      !absl::SimpleAtoi(parts[2], &incarnation) || incarnation != scene_->incarnation() ||
      !absl::SimpleAtoi(parts[3], &had.structure_id) ||
      !absl::SimpleAtoi(parts[4], &had.quantisation_id) ||
      !absl::SimpleAtoi(parts[5], &had.revision) || parts[6] != KeyText(view_->key())) {
    return std::nullopt;
  }
  const auto state = scene_->State();
  if (had.structure_id != state->structure_id || had.quantisation_id != state->box.id ||
      had.revision > state->revision) {
    return std::nullopt;
  }
  had.view = view_->key();
  return had;
}

}  // namespace latticed
