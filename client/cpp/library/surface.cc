// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/surface.h"

#include <utility>

#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

size_t ChunkCount(const v1::Topology& topology) {
  size_t count = 0;
  for (const auto& run : topology.chunk_runs()) count += run.chunk_count();
  return count;
}

}  // namespace

absl::StatusOr<std::optional<CompleteUpdate>> Surface::Apply(v1::SceneEvent event) {
  absl::Status status;
  switch (event.event_case()) {
    case v1::SceneEvent::kLatticeState:
      lattice_.Swap(event.mutable_lattice_state());
      break;
    case v1::SceneEvent::kLatticeDelta:
      status = TakeDelta(event.lattice_delta());
      break;
    case v1::SceneEvent::kTopology:
      announced_[event.topology().topology_id()] = event.topology();
      break;
    case v1::SceneEvent::kQuantisation:
      quantisation_ = std::make_shared<const v1::Quantisation>(event.quantisation());
      break;
    case v1::SceneEvent::kUpdateBegin:
      DropPartialUpdate();
      begin_ = event.update_begin();
      break;
    case v1::SceneEvent::kChunks:
      status = TakeChunks(std::move(*event.mutable_chunks()));
      break;
    case v1::SceneEvent::kUpdateEnd:
      return TakeEnd(event.update_end());
    default:
      break;  // the stream handles hello, results and heartbeats; later versions may add events
  }
  LATTICED_RETURN_IF_ERROR(status);
  return std::nullopt;
}

void Surface::DropPartialUpdate() {
  begin_.reset();
  begun_topology_.clear();
  begun_chunks_.clear();
  begun_bytes_ = 0;
}

double Surface::progress() const {
  if (!begin_.has_value() || begin_->chunk_count() == 0) return begin_.has_value() ? 0.0 : 1.0;
  return static_cast<double>(begun_chunks_.size()) / begin_->chunk_count();
}

uint64_t Surface::bytes() const {
  uint64_t sum = 0;
  for (const HeldChunk& chunk : chunks_) sum += chunk.data.size();
  return sum;
}

absl::Status Surface::TakeDelta(const v1::LatticeDelta& delta) {
  if (delta.structure_id() != lattice_.structure_id()) return absl::OkStatus();  // a state follows
  auto* points = lattice_.mutable_lattice()->mutable_control_points();
  if (delta.positions_size() != 3 * delta.indices_size()) {
    return absl::DataLossError("a lattice_delta must have three numbers per index");
  }
  for (int i = 0; i < delta.indices_size(); ++i) {
    const int64_t first = 3 * int64_t{delta.indices(i)};
    if (first + 3 > points->size()) {
      return absl::DataLossError("a lattice_delta names a control point that does not exist");
    }
    for (int c = 0; c < 3; ++c) {
      points->Set(static_cast<int>(first) + c, delta.positions(3 * i + c));
    }
  }
  lattice_.set_revision(delta.revision());
  return absl::OkStatus();
}

absl::Status Surface::TakeChunks(v1::Chunks chunks) {
  if (!begin_.has_value() || begin_->update_id() != chunks.update_id()) {
    return absl::DataLossError("chunks came outside of their update");
  }
  if (quantisation_ == nullptr || quantisation_->quantisation_id() != chunks.quantisation_id()) {
    return absl::DataLossError("chunks name a quantisation that was not sent");
  }
  begun_topology_ = chunks.topology_id();
  for (v1::Chunk& chunk : *chunks.mutable_chunks()) {
    begun_bytes_ += chunk.data().size();
    HeldChunk& held = begun_chunks_[chunk.index()];
    held.data = std::move(*chunk.mutable_data());
    held.quantisation = quantisation_;
  }
  return absl::OkStatus();
}

absl::StatusOr<CompleteUpdate> Surface::TakeEnd(v1::UpdateEnd end) {
  if (!begin_.has_value() || begin_->update_id() != end.update_id()) {
    return absl::DataLossError("update_end came without its update_begin");
  }
  if (begun_chunks_.size() != begin_->chunk_count()) {
    return absl::DataLossError(fmt::format("an update of {} chunks ended after {}",
                                           begin_->chunk_count(), begun_chunks_.size()));
  }
  if (!begun_topology_.empty() && begun_topology_ != topology_.topology_id()) {
    const auto announced = announced_.find(begun_topology_);
    if (announced == announced_.end()) {
      return absl::DataLossError("chunks name a topology that was not sent");
    }
    topology_ = announced->second;
    announced_.clear();
    chunks_.assign(ChunkCount(topology_), HeldChunk{});
  }
  CompleteUpdate update{
      .end = std::move(end), .chunk_count = begun_chunks_.size(), .bytes = begun_bytes_};
  for (auto& [index, chunk] : begun_chunks_) {
    if (index >= chunks_.size()) {
      return absl::DataLossError(fmt::format("chunk {} of {}", index, chunks_.size()));
    }
    chunks_[index] = std::move(chunk);
  }
  view_ = begin_->view();
  revision_ = update.end.revision();
  complete_ = true;
  DropPartialUpdate();
  return update;
}

const v1::Quantisation& Surface::quantisation() const {
  return quantisation_ == nullptr ? v1::Quantisation::default_instance() : *quantisation_;
}

Surface::PatchRange Surface::PatchesOf(size_t chunk) const {
  uint64_t first = 0;
  for (const auto& run : topology_.chunk_runs()) {
    if (chunk < run.chunk_count()) {
      return {first + chunk * run.patches_per_chunk(), run.patches_per_chunk()};
    }
    chunk -= run.chunk_count();
    first += uint64_t{run.chunk_count()} * run.patches_per_chunk();
  }
  return {first, 0};
}

absl::StatusOr<DecodedPoints> Surface::Decode() const {
  if (!complete_) return absl::FailedPreconditionError("no complete update has come yet");
  DecodedPoints points;
  points.positions.reserve(topology_.point_count());
  if (view_.normals() != v1::NORMAL_MODE_NONE) points.normals.reserve(topology_.point_count());
  size_t index = 0;
  for (const auto& run : topology_.chunk_runs()) {
    for (uint32_t i = 0; i < run.chunk_count(); ++i, ++index) {
      LATTICED_RETURN_IF_ERROR(DecodeOnto(index, run.patches_per_chunk(), &points));
    }
  }
  return points;
}

absl::StatusOr<DecodedPoints> Surface::Decode(size_t chunk) const {
  if (!complete_) return absl::FailedPreconditionError("no complete update has come yet");
  if (chunk >= chunks_.size()) {
    return absl::InvalidArgumentError(fmt::format("chunk {} of {}", chunk, chunks_.size()));
  }
  DecodedPoints points;
  LATTICED_RETURN_IF_ERROR(DecodeOnto(chunk, PatchesOf(chunk).count, &points));
  return points;
}

absl::Status Surface::DecodeOnto(size_t chunk, uint64_t patches, DecodedPoints* points) const {
  const HeldChunk& held = chunks_[chunk];
  if (held.quantisation == nullptr) {
    return absl::DataLossError(fmt::format("chunk {} never came", chunk));
  }
  const size_t points_per_patch = static_cast<size_t>(topology_.pattern().points_size()) / 3;
  return DecodeChunk(held.data, patches * points_per_patch, view_, *held.quantisation, points);
}

}  // namespace latticed::client
