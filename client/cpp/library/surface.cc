// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/surface.h"

#include <algorithm>
#include <numeric>
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

// The codes of Chunk.levels, which are little endian.
size_t CodeCount(std::string_view levels) { return levels.size() / 2; }
uint32_t CodeAt(std::string_view levels, size_t patch) {
  const auto byte = [&](size_t i) { return uint32_t{static_cast<uint8_t>(levels[i])}; };
  return byte(2 * patch) | byte(2 * patch + 1) << 8;
}

template <typename Pattern>
absl::StatusOr<PatchLayout> LayoutOf(const Pattern& pattern, double denominator) {
  const auto span_of = [](const auto& numbers) {
    return std::span<const uint32_t>(numbers.data(), static_cast<size_t>(numbers.size()));
  };
  const PatchLayout layout{denominator, span_of(pattern.points()), span_of(pattern.triangles())};
  const bool whole = layout.points.size() % 3 == 0 && layout.triangles.size() % 3 == 0;
  const bool inside = std::ranges::all_of(
      layout.triangles, [&](uint32_t point) { return point < layout.point_count(); });
  if (!(denominator > 0) || !whole || !inside) {
    return absl::DataLossError("a pattern contradicts itself");
  }
  return layout;
}

}  // namespace

absl::StatusOr<std::optional<CompleteUpdate>> Surface::Apply(v1::SceneEvent event) {
  absl::Status status;
  switch (event.event_case()) {
    case v1::SceneEvent::kLatticeState:
      lattices_.Take(std::move(*event.mutable_lattice_state()));
      break;
    case v1::SceneEvent::kLatticeDelta:
      status = lattices_.Take(event.lattice_delta());
      break;
    case v1::SceneEvent::kTopology:
      announced_[event.topology().topology_id()] = event.topology();
      break;
    case v1::SceneEvent::kPatterns:
      status = TakePatterns(std::move(*event.mutable_patterns()));
      break;
    case v1::SceneEvent::kQuantisation:
      quantisation_ = std::make_shared<const v1::Quantisation>(event.quantisation());
      break;
    case v1::SceneEvent::kUpdateBegin:
      DropPartialUpdate();
      begin_ = event.update_begin();
      break;
    case v1::SceneEvent::kPatchLattice:
      status = TakeSum(std::move(*event.mutable_patch_lattice()));
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
  begun_bounds_.clear();
  begun_bytes_ = 0;
  begun_sum_ = false;
}

double Surface::progress() const {
  if (!begin_.has_value() || begin_->chunk_count() == 0) return begin_.has_value() ? 0.0 : 1.0;
  return static_cast<double>(begun_chunks_.size()) / begin_->chunk_count();
}

uint64_t Surface::bytes() const {
  uint64_t sum = HasPatches() ? edge_bounds_.size() : 0;
  for (const HeldChunk& chunk : chunks_) sum += chunk.data.size() + chunk.levels.size();
  return sum;
}

absl::Status Surface::TakeSum(v1::PatchLattice news) {
  if (!begin_.has_value()) {
    return absl::DataLossError("a patch_lattice came outside of an update");
  }
  begun_sum_ = true;
  if (news.has_delta()) return sum_.Take(news.delta());
  sum_.Take(std::move(*news.mutable_state()));
  return absl::OkStatus();
}

absl::Status Surface::TakePatterns(v1::Patterns patterns) {
  for (v1::PatchPattern& pattern : *patterns.mutable_patterns()) {
    LATTICED_RETURN_IF_ERROR(LayoutOf(pattern, pattern.denominator()).status());
    // A pattern that is here already stays, because layouts may refer to it.
    patterns_.try_emplace(pattern.code(), std::move(pattern));
  }
  return absl::OkStatus();
}

absl::StatusOr<uint64_t> Surface::PointsOf(const v1::Chunk& chunk) const {
  uint64_t points = 0;
  for (size_t i = 0; i < CodeCount(chunk.levels()); ++i) {
    const auto pattern = patterns_.find(CodeAt(chunk.levels(), i));
    if (pattern == patterns_.end()) {
      return absl::DataLossError("chunks name a pattern that was not sent");
    }
    points += static_cast<uint64_t>(pattern->second.points_size()) / 3;
  }
  return points;
}

absl::Status Surface::TakeChunks(v1::Chunks chunks) {
  if (!begin_.has_value() || begin_->update_id() != chunks.update_id()) {
    return absl::DataLossError("chunks came outside of their update");
  }
  begun_topology_ = chunks.topology_id();
  if (begin_->view().encoding() == v1::ENCODING_PATCHES) return TakeBounds(std::move(chunks));
  if (quantisation_ == nullptr || quantisation_->quantisation_id() != chunks.quantisation_id()) {
    return absl::DataLossError("chunks name a quantisation that was not sent");
  }
  for (v1::Chunk& chunk : *chunks.mutable_chunks()) {
    LATTICED_ASSIGN_OR_RETURN(const uint64_t level_points, PointsOf(chunk));
    begun_bytes_ += chunk.data().size() + chunk.levels().size();
    HeldChunk& held = begun_chunks_[chunk.index()];
    held.data = std::move(*chunk.mutable_data());
    held.levels = std::move(*chunk.mutable_levels());
    held.level_points = level_points;
    held.quantisation = quantisation_;
  }
  return absl::OkStatus();
}

absl::Status Surface::TakeBounds(v1::Chunks chunks) {
  const auto no_grid = std::make_shared<const v1::Quantisation>();
  for (v1::Chunk& chunk : *chunks.mutable_chunks()) {
    const uint32_t count = std::max(chunk.chunk_count(), 1u);
    if (count > begin_->chunk_count()) {
      return absl::DataLossError(
          fmt::format("{} chunks came in an update of {}", count, begin_->chunk_count()));
    }
    for (uint32_t i = 0; i < count; ++i) {
      begun_chunks_[chunk.index() + i].quantisation = no_grid;
    }
    begun_bytes_ += chunk.data().size();
    begun_bounds_.push_back(std::move(chunk));
  }
  return absl::OkStatus();
}

absl::Status Surface::KeepBounds() {
  for (const v1::Chunk& chunk : begun_bounds_) {
    const size_t first = chunk.first_edge(), end = first + chunk.data().size();
    if (end > 3 * topology_.patch_count()) {
      return absl::DataLossError(
          fmt::format("chunk {} has bounds of edges up to {}, {} patches "
                      "have fewer",
                      chunk.index(), end, topology_.patch_count()));
    }
    edge_bounds_.resize(std::max(edge_bounds_.size(), end));
    std::ranges::copy(chunk.data(), edge_bounds_.begin() + static_cast<ptrdiff_t>(first));
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
    edge_bounds_.clear();
  }
  LATTICED_RETURN_IF_ERROR(KeepBounds());
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
  certified_error_ = update.end.certified_error();
  lattices_.EndUpdate(revision_);
  shows_sum_ = begun_sum_;
  if (shows_sum_) sum_.EndUpdate(revision_);
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

absl::StatusOr<std::vector<PatchLayout>> Surface::Layouts() const {
  std::vector<PatchLayout> layouts;
  layouts.reserve(topology_.patch_count());
  for (size_t chunk = 0; chunk < chunks_.size(); ++chunk) {
    LATTICED_RETURN_IF_ERROR(LayoutOnto(chunk, PatchesOf(chunk).count, &layouts));
  }
  return layouts;
}

absl::StatusOr<std::vector<PatchLayout>> Surface::Layouts(size_t chunk) const {
  if (chunk >= chunks_.size()) {
    return absl::InvalidArgumentError(fmt::format("chunk {} of {}", chunk, chunks_.size()));
  }
  std::vector<PatchLayout> layouts;
  LATTICED_RETURN_IF_ERROR(LayoutOnto(chunk, PatchesOf(chunk).count, &layouts));
  return layouts;
}

absl::Status Surface::LayoutOnto(size_t chunk, uint64_t patches,
                                 std::vector<PatchLayout>* layouts) const {
  LATTICED_RETURN_IF_ERROR(CheckHasPoints());
  if (topology_.has_pattern()) {
    LATTICED_ASSIGN_OR_RETURN(const auto layout,
                              LayoutOf(topology_.pattern(), topology_.segments()));
    layouts->insert(layouts->end(), patches, layout);
    return absl::OkStatus();
  }
  LATTICED_RETURN_IF_ERROR(CheckLevelCount(chunks_[chunk], patches));
  for (uint64_t i = 0; i < patches; ++i) {
    const v1::PatchPattern& pattern = patterns_.at(CodeAt(chunks_[chunk].levels, i));
    LATTICED_ASSIGN_OR_RETURN(layouts->emplace_back(), LayoutOf(pattern, pattern.denominator()));
  }
  return absl::OkStatus();
}

absl::Status Surface::CheckHasPoints() const {
  if (!HasPatches()) return absl::OkStatus();
  return absl::FailedPreconditionError("ENCODING_PATCHES sends no points: use PatchEvaluator");
}

absl::Status Surface::CheckLevelCount(const HeldChunk& chunk, uint64_t patches) {
  const size_t codes = CodeCount(chunk.levels);
  if (codes == patches) return absl::OkStatus();
  return absl::DataLossError(fmt::format("a chunk of {} patches has levels of {}", patches, codes));
}

uint64_t Surface::PointCount() const {
  if (topology_.has_pattern()) return topology_.point_count();
  uint64_t count = 0;
  for (const HeldChunk& chunk : chunks_) count += chunk.level_points;
  return count;
}

absl::StatusOr<std::vector<uint8_t>> Surface::EdgeBounds() const {
  if (!complete_ || !HasPatches()) {
    return absl::FailedPreconditionError("no complete update of ENCODING_PATCHES has come");
  }
  for (size_t index = 0; index < chunks_.size(); ++index) {
    if (chunks_[index].quantisation == nullptr) {
      return absl::DataLossError(fmt::format("chunk {} never came", index));
    }
  }
  return edge_bounds_;
}

absl::StatusOr<DecodedPoints> Surface::Decode() const {
  std::vector<uint32_t> chunks(chunks_.size());
  std::iota(chunks.begin(), chunks.end(), 0u);
  return Decode(chunks);
}

absl::StatusOr<DecodedPoints> Surface::Decode(std::span<const uint32_t> chunks) const {
  LATTICED_ASSIGN_OR_RETURN(const auto encoded, Encoded(chunks));
  DecodedPoints points;
  LATTICED_RETURN_IF_ERROR(VertexDecoder().Decode(encoded, view_, &points));
  return points;
}

absl::StatusOr<uint64_t> Surface::PointCount(std::span<const uint32_t> chunks) const {
  LATTICED_ASSIGN_OR_RETURN(const auto encoded, Encoded(chunks));
  uint64_t count = 0;
  for (const EncodedChunk& chunk : encoded) count += chunk.point_count;
  return count;
}

absl::Status Surface::Decode(std::span<const uint32_t> chunks, VertexDecoder* decoder,
                             std::span<GridVertex> vertices) const {
  LATTICED_ASSIGN_OR_RETURN(const auto encoded, Encoded(chunks));
  return decoder->Decode(encoded, view_, vertices);
}

absl::Status Surface::Decode(std::span<const uint32_t> chunks, VertexDecoder* decoder,
                             std::span<WorldVertex> vertices) const {
  LATTICED_ASSIGN_OR_RETURN(const auto encoded, Encoded(chunks));
  return decoder->Decode(encoded, view_, vertices);
}

absl::StatusOr<std::vector<EncodedChunk>> Surface::Encoded(std::span<const uint32_t> chunks) const {
  if (!complete_) return absl::FailedPreconditionError("no complete update has come yet");
  LATTICED_RETURN_IF_ERROR(CheckHasPoints());
  size_t pattern_points = 0;
  if (topology_.has_pattern()) {
    LATTICED_ASSIGN_OR_RETURN(const auto layout,
                              LayoutOf(topology_.pattern(), topology_.segments()));
    pattern_points = layout.point_count();
  }
  std::vector<EncodedChunk> encoded;
  encoded.reserve(chunks.size());
  for (const uint32_t chunk : chunks) {
    if (chunk >= chunks_.size()) {
      return absl::InvalidArgumentError(fmt::format("chunk {} of {}", chunk, chunks_.size()));
    }
    const HeldChunk& held = chunks_[chunk];
    if (held.quantisation == nullptr) {
      return absl::DataLossError(fmt::format("chunk {} never came", chunk));
    }
    const uint64_t patches = PatchesOf(chunk).count;
    size_t points = patches * pattern_points;
    if (!topology_.has_pattern()) {
      LATTICED_RETURN_IF_ERROR(CheckLevelCount(held, patches));
      points = held.level_points;
    }
    encoded.push_back(
        {.data = held.data, .point_count = points, .quantisation = held.quantisation.get()});
  }
  return encoded;
}

}  // namespace latticed::client
