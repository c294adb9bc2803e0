// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/symbol_group.h"

#include <algorithm>
#include <cstring>

#include "core/codec/draco_container.h"
#include "core/codec/rans_model.h"

namespace latticed {
namespace {

using draco_format::kCoded;
using draco_format::kPlain;
using draco_kernel::kLanes;
using draco_kernel::kPadding;

constexpr size_t kHistograms = 4;
// Without vectors, this many states are coded in turns: one waits for its multiplication while the next begins.
constexpr size_t kChains = 4;
constexpr int kMostChainPrecision = 16;
// With fewer chunks than this, coding in turns is as fast: vectors take as long for one chunk as for 16.
constexpr size_t kFewestLanes = 7;

size_t RoundUp(size_t count, size_t step) { return (count + step - 1) / step * step; }

template <class T>
void GrowTo(std::vector<T>& values, size_t size) {
  if (values.size() >= size) return;
  values.reserve(size);  // resize alone might take more
  values.resize(size);
}

template <class T>
size_t BytesHeld(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace

void SymbolGroup::Begin(size_t lanes, size_t points, size_t components, size_t most_symbols) {
  lanes_ = lanes;
  points_ = points;
  components_ = components;
  // Odd multiples of a cache line: lanes do not compete for the same places of the cache.
  stride_ = RoundUp(points + 1, 32) | 32;
  most_symbols_ = RoundUp(most_symbols, kPadding) + kPadding;
  GrowTo(symbols_, lanes * components * stride_);
  GrowTo(histograms_, kHistograms * most_symbols_);
  // Reserved here, so that nothing throws while the histograms are not zero.
  for (size_t lane = 0; lane < lanes; ++lane) lane_[lane].table.Reserve(most_symbols);
}

void SymbolGroup::Tabulate(size_t lane, size_t end) {
  // Neighbours are often equal, and a count that was just stored is slow to load: they are counted
  // in different histograms.
  uint32_t* const h = histograms_.data();
  for (size_t c = 0; c < components_; ++c) {
    const uint16_t* symbols = plane(lane, c);
    size_t i = 0;
    for (; i + kHistograms <= points_; i += kHistograms) {
      uint64_t four = 0;
      std::memcpy(&four, symbols + i, sizeof(four));
      ++h[four & 0xFFFF];
      ++h[most_symbols_ + (four >> 16 & 0xFFFF)];
      ++h[2 * most_symbols_ + (four >> 32 & 0xFFFF)];
      ++h[3 * most_symbols_ + (four >> 48)];
    }
    for (; i < points_; ++i) ++h[symbols[i]];
  }
  lane_[lane].table.Build(histograms_, kHistograms, most_symbols_, end);
}

void SymbolGroup::Code(SymbolGroup& positions, SymbolGroup* normals) {
  if (positions.SuitsLanes() && (normals == nullptr || normals->SuitsLanes())) {
    draco_kernel::LaneStreams position_streams = positions.BeginLanes();
    if (normals == nullptr) {
      draco_kernel::CodeLanes(positions.points_, position_streams, nullptr);
    } else {
      draco_kernel::LaneStreams normal_streams = normals->BeginLanes();
      draco_kernel::CodeLanes(positions.points_, position_streams, &normal_streams);
      normals->FinishLanes(normal_streams);
    }
    positions.FinishLanes(position_streams);
    return;
  }
  positions.CodeByChains();
  if (normals != nullptr) normals->CodeByChains();
}

void SymbolGroup::CodeByChains() {
  coded_stride_ = MostRansBytes(components_ * points_, kMostRansPrecision);
  entry_stride_ = most_symbols_;
  GrowTo(coded_, lanes_ * coded_stride_);
  GrowTo(entries_, kChains * entry_stride_);
  const auto suits = [&](size_t lane) {
    return lane_[lane].table.bit_length() != 0 &&
           lane_[lane].table.precision() <= kMostChainPrecision;
  };
  for (size_t lane = 0; lane < lanes_;) {
    size_t count = 0;
    while (count < kChains && lane + count < lanes_ && suits(lane + count)) ++count;
    if (count == kChains) {
      CodeChains<kChains>(lane);
      lane += kChains;
    } else if (count >= 2) {
      CodeChains<2>(lane);
      lane += 2;
    } else {
      if (lane_[lane].table.bit_length() != 0) CodeChains<1>(lane);
      ++lane;
    }
  }
}

template <size_t kCount>
void SymbolGroup::CodeChains(size_t first) {
  std::array<RansEncoder, kCount> encoders;
  std::array<const uint16_t*, kCount> symbols;
  for (size_t k = 0; k < kCount; ++k) {
    const RansTable& table = lane_[first + k].table;
    RansEntry* entries = entries_.data() + k * entry_stride_;
    table.ForEach([&](uint32_t symbol, uint32_t probability, uint32_t cumulative) {
      entries[symbol] = MakeRansEntry(probability, cumulative);
    });
    encoders[k] = RansEncoder(table.precision(), coded_.data() + (first + k) * coded_stride_);
    symbols[k] = plane(first + k, 0);
  }
  for (size_t i = points_; i-- > 0;) {
    for (size_t c = components_; c-- > 0;) {
      for (size_t k = 0; k < kCount; ++k) {
        const RansEntry& entry = entries_[k * entry_stride_ + symbols[k][c * stride_ + i]];
        if constexpr (kCount > 1) {
          encoders[k].PutShort(entry);
        } else {
          encoders[k].Put(entry);
        }
      }
    }
  }
  for (size_t k = 0; k < kCount; ++k) {
    lane_[first + k].coded_bytes =
        static_cast<size_t>(encoders[k].Finish() - (coded_.data() + (first + k) * coded_stride_));
  }
}

bool SymbolGroup::SuitsLanes() const {
  if (lanes_ < kFewestLanes || !draco_kernel::HasLanes()) return false;
  return std::all_of(lane_.begin(), lane_.begin() + static_cast<ptrdiff_t>(lanes_),
                     [](const Lane& lane) {
                       return lane.table.bit_length() != 0 &&
                              lane.table.precision() <= draco_kernel::kMostLanePrecision;
                     });
}

draco_kernel::LaneStreams SymbolGroup::BeginLanes() {
  coded_stride_ = RoundUp(components_ * points_ * 2 + 8, 64) | 64;
  GrowTo(coded_, kLanes * coded_stride_);
  GrowTo(lane_entries_, lanes_ * most_symbols_);
  draco_kernel::LaneStreams streams{.symbols = symbols_.data(),
                                    .plane_stride = stride_,
                                    .entries = lane_entries_.data(),
                                    .out = coded_.data(),
                                    .out_stride = coded_stride_};
  for (size_t lane = 0; lane < lanes_; ++lane) {
    uint32_t* entries = lane_entries_.data() + lane * most_symbols_;
    lane_[lane].table.ForEach([&](uint32_t symbol, uint32_t probability, uint32_t cumulative) {
      entries[symbol] = probability | cumulative << 16;
    });
  }
  for (size_t l = 0; l < kLanes; ++l) {
    const size_t lane = std::min(l, lanes_ - 1);  // lanes without a chunk repeat the last one's
    streams.symbols_at[l] = static_cast<int32_t>(sizeof(uint16_t) * lane * components_ * stride_);
    streams.entries_at[l] = static_cast<int32_t>(lane * most_symbols_);
    streams.precision[l] = static_cast<uint32_t>(lane_[lane].table.precision());
  }
  return streams;
}

void SymbolGroup::FinishLanes(const draco_kernel::LaneStreams& streams) {
  for (size_t lane = 0; lane < lanes_; ++lane) {
    uint8_t* out = coded_.data() + lane * coded_stride_;
    const uint8_t* end = FinishRans(streams.state[lane], static_cast<int>(streams.precision[lane]),
                                    out + streams.bytes[lane]);
    lane_[lane].coded_bytes = static_cast<size_t>(end - out);
  }
}

size_t SymbolGroup::MostBytes(size_t lane) const {
  return 3 + std::max({lane_[lane].table.MostBytes() + kMostVarintBytes + lane_[lane].coded_bytes,
                       components_ * points_ * sizeof(uint16_t),
                       TaggedSymbols::MostBytes(components_, points_)});
}

size_t SymbolGroup::MemoryBytes() const {
  size_t bytes = BytesHeld(symbols_) + BytesHeld(histograms_) + BytesHeld(entries_) +
                 BytesHeld(lane_entries_) + BytesHeld(coded_);
  for (const Lane& lane : lane_) bytes += lane.table.MemoryBytes();
  return bytes;
}

void SymbolGroup::Write(size_t lane, TaggedSymbols* tagged, ByteWriter& out) const {
  const ByteWriter start = out;
  WriteRaw(lane, out);
  if (tagged == nullptr) return;
  std::array<const uint16_t*, 3> planes;
  for (size_t c = 0; c < components_; ++c) planes[c] = plane(lane, c);
  tagged->Code(std::span(planes).first(components_), points_);
  if (1 + tagged->Bytes() >= static_cast<size_t>(out.at() - start.at())) return;
  out = start;
  out.Byte(kCoded);
  tagged->Write(out);
}

void SymbolGroup::WriteRaw(size_t lane, ByteWriter& out) const {
  const ByteWriter start = out;
  const auto& [table, coded_bytes] = lane_[lane];
  if (table.bit_length() != 0) {
    out.Byte(kCoded);
    out.Byte(kSchemeRaw);
    out.Byte(static_cast<uint32_t>(table.bit_length()));
    table.Write(out);
    out.Varint(coded_bytes);
    out.Bytes(std::span(coded_).subspan(lane * coded_stride_, coded_bytes));
    const auto coded = static_cast<size_t>(out.at() - start.at());
    if (!StorePlainly(coded, components_ * points_, table.largest())) return;
  }
  out = start;
  WritePlainly(lane, table.largest(), out);
}

void SymbolGroup::WritePlainly(size_t lane, uint32_t largest, ByteWriter& out) const {
  const uint32_t width = PlainSymbolBytes(largest);
  out.Byte(kPlain);
  out.Byte(width);
  for (size_t i = 0; i < points_; ++i) {
    for (size_t c = 0; c < components_; ++c) {
      const uint16_t symbol = plane(lane, c)[i];
      out.Byte(symbol);
      if (width == 2) out.Byte(symbol >> 8);
    }
  }
}

}  // namespace latticed
