// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/draco_writer.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/codec/chunk_connectivity.h"
#include "core/codec/draco_container.h"
#include "core/codec/draco_kernel.h"
#include "core/codec/octahedral.h"
#include "core/codec/symbol_group.h"
#include "core/codec/tagged_symbols.h"

namespace latticed {
namespace {

using draco_kernel::kLanes;
using draco_kernel::ValueSpan;

// Memory for 16 chunks. A point takes 160 bytes of symbols, up to 240 coded bytes, and its part of
// a finished stream with its connectivity. Each value that a coordinate may have takes its part of
// tables and histograms. Padding is constant.
constexpr uint64_t kBytesPerPoint = 448, kBytesPerValue = 352, kPaddingBytes = 65'536;

}  // namespace

// Encodes up to 16 chunks with the same number of points and bits.
class DracoWriter::Group {
 public:
  void Encode(std::span<const QuantisedVertices> chunks, float range,
              const ChunkConnectivity* connectivity, std::span<std::vector<uint8_t>> streams) {
    const QuantisedVertices& first = chunks.front();
    size_t widest = 0;
    for (size_t lane = 0; lane < chunks.size(); ++lane) {
      spans_[lane] = SpanOf(chunks[lane]);
      widest = std::max(widest, SymbolCount(spans_[lane]));
    }
    positions_.Begin(chunks.size(), first.point_count, 3, widest);
    if (first.normal_bits > 0) {
      normals_.Begin(chunks.size(), first.point_count, 2, NormalSymbolCount(first.normal_bits));
    }
    for (size_t lane = 0; lane < chunks.size(); ++lane) Predict(chunks[lane], lane);
    SymbolGroup::Code(positions_, first.normal_bits > 0 ? &normals_ : nullptr);
    for (size_t lane = 0; lane < chunks.size(); ++lane) {
      Write(chunks[lane], lane, range, connectivity, streams[lane]);
    }
  }

  size_t MemoryBytes() const {
    return positions_.MemoryBytes() + normals_.MemoryBytes() + tagged_.MemoryBytes() +
           stream_.capacity();
  }

 private:
  static ValueSpan SpanOf(const QuantisedVertices& chunk) {
    ValueSpan span{0xFFFF, 0};
    for (const uint16_t* plane : {chunk.x, chunk.y, chunk.z}) {
      const ValueSpan part = draco_kernel::SpanOf(plane, chunk.point_count);
      span = {std::min(span.least, part.least), std::max(span.most, part.most)};
    }
    return span;
  }
  static size_t SymbolCount(ValueSpan span) { return span.most - span.least + size_t{1}; }
  static size_t NormalSymbolCount(int bits) { return static_cast<size_t>(OctahedralMax(bits)) + 1; }

  void Predict(const QuantisedVertices& chunk, size_t lane) {
    const size_t points = chunk.point_count;
    const std::array<const uint16_t*, 3> planes{chunk.x, chunk.y, chunk.z};
    for (size_t c = 0; c < 3; ++c) {
      draco_kernel::PositionSymbols(planes[c], points, spans_[lane], positions_.plane(lane, c));
    }
    positions_.Tabulate(lane, SymbolCount(spans_[lane]));
    if (chunk.normal_bits == 0) return;
    draco_kernel::NormalSymbols(chunk.s, chunk.t, points, chunk.normal_bits,
                                normals_.plane(lane, 0), normals_.plane(lane, 1));
    normals_.Tabulate(lane, NormalSymbolCount(chunk.normal_bits));
  }

  void Write(const QuantisedVertices& chunk, size_t lane, float range,
             const ChunkConnectivity* connectivity, std::vector<uint8_t>& stream) {
    size_t most_bytes = kMostContainerBytes + positions_.MostBytes(lane);
    if (chunk.normal_bits > 0) most_bytes += normals_.MostBytes(lane);
    if (connectivity != nullptr) most_bytes += connectivity->bytes().size();
    if (stream_.size() < most_bytes) {
      stream_.reserve(most_bytes);
      stream_.resize(most_bytes);
    }
    ByteWriter out(stream_.data());
    TaggedSymbols* const tagged = chunk.is_sparse ? &tagged_ : nullptr;
    if (connectivity == nullptr) {
      WriteCloudHead(chunk.point_count, chunk.normal_bits, out);
    } else {
      WriteMeshHead(connectivity->bytes(), chunk.normal_bits, out);
    }
    WritePrediction(DracoAttribute::kPosition, out);
    positions_.Write(lane, tagged, out);
    WritePositionBounds(spans_[lane].least, spans_[lane].most, out);
    if (chunk.normal_bits > 0) {
      WritePrediction(DracoAttribute::kNormal, out);
      normals_.Write(lane, tagged, out);
      WriteNormalBounds(chunk.normal_bits, out);
    }
    WriteDequantisation(chunk.position_bits, chunk.normal_bits, range, out);
    stream.assign(stream_.data(), out.at());
    if (connectivity != nullptr && stream.size() < connectivity->LeastStreamBytes()) {
      stream.resize(connectivity->LeastStreamBytes());
    }
  }

  SymbolGroup positions_, normals_;
  TaggedSymbols tagged_;
  std::array<ValueSpan, kLanes> spans_;
  std::vector<uint8_t> stream_;  // with room to spare
};

DracoWriter::DracoWriter() = default;
DracoWriter::~DracoWriter() = default;

size_t DracoWriter::batch() const { return kLanes; }

absl::Status DracoWriter::Encode(std::span<const QuantisedVertices> chunks, double range,
                                 const ChunkConnectivity* connectivity,
                                 std::span<std::vector<uint8_t>> streams) const {
  // The group is kept for the next call. Fresh pages for every call would take a third of the time.
  std::unique_ptr<Group> group = TakeGroup();
  while (!chunks.empty()) {
    size_t count = 1;
    while (count < std::min(chunks.size(), kLanes) && chunks[count].SameShape(chunks.front())) {
      ++count;
    }
    group->Encode(chunks.first(count), static_cast<float>(range), connectivity,
                  streams.first(count));
    chunks = chunks.subspan(count);
    streams = streams.subspan(count);
  }
  const MutexLock lock(&mutex_);
  idle_.push_back(std::move(group));
  return absl::OkStatus();
}

std::unique_ptr<DracoWriter::Group> DracoWriter::TakeGroup() const {
  {
    const MutexLock lock(&mutex_);
    if (!idle_.empty()) {
      auto group = std::move(idle_.back());
      idle_.pop_back();
      return group;
    }
  }
  return std::make_unique<Group>();
}

uint64_t DracoWriter::WorkingBytes(size_t points, int position_bits, int normal_bits) const {
  const uint64_t values =
      (uint64_t{1} << position_bits) + (normal_bits > 0 ? uint64_t{1} << normal_bits : 0);
  return points * kBytesPerPoint + values * kBytesPerValue + kPaddingBytes;
}

uint64_t DracoWriter::MemoryBytes() const {
  const MutexLock lock(&mutex_);
  uint64_t bytes = 0;
  for (const auto& group : idle_) bytes += group->MemoryBytes();
  return bytes;
}

}  // namespace latticed
