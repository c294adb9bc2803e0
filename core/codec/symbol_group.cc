// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/symbol_group.h"

#include <algorithm>
#include <utility>

#include "core/codec/rans_model.h"

namespace latticed {
namespace {

using draco_kernel::kLanes;
using draco_kernel::kPadding;

// Numbers of the format.
constexpr uint32_t kPlain = 0, kCoded = 1, kSchemeRaw = 1;
// With fewer chunks than this, one after the other is faster.
constexpr size_t kFewestLanes = 3;

size_t RoundUp(size_t count, size_t step) { return (count + step - 1) / step * step; }

template <class T>
void GrowTo(std::vector<T>& values, size_t size) {
  if (values.size() < size) values.resize(size);
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
  GrowTo(histograms_, components * most_symbols_);
}

void SymbolGroup::Tabulate(size_t lane, size_t end) {
  for (size_t c = 0; c < components_; ++c) {
    uint32_t* histogram = histograms_.data() + c * most_symbols_;
    for (const uint16_t symbol : std::as_const(*this).plane(lane, c)) ++histogram[symbol];
  }
  lane_[lane].table.Build(histograms_, components_, most_symbols_, end);
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
  positions.CodeOneByOne();
  if (normals != nullptr) normals->CodeOneByOne();
}

void SymbolGroup::CodeOneByOne() {
  coded_stride_ = MostRansBytes(components_ * points_, kMostRansPrecision);
  GrowTo(coded_, lanes_ * coded_stride_);
  for (size_t lane = 0; lane < lanes_; ++lane) CodeLane(lane);
}

void SymbolGroup::CodeLane(size_t lane) {
  const RansTable& table = lane_[lane].table;
  if (table.bit_length() == 0) return;
  GrowTo(entries_, most_symbols_);
  table.ForEach([&](uint32_t symbol, uint32_t probability, uint32_t cumulative) {
    entries_[symbol] = MakeRansEntry(probability, cumulative);
  });
  uint8_t* out = coded_.data() + lane * coded_stride_;
  RansEncoder encoder(table.precision(), out);
  const uint16_t* symbols = plane(lane, 0);
  for (size_t i = points_; i-- > 0;) {
    for (size_t c = components_; c-- > 0;) encoder.Put(entries_[symbols[c * stride_ + i]]);
  }
  lane_[lane].coded_bytes = static_cast<size_t>(encoder.Finish() - out);
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
  return 3 + std::max(lane_[lane].table.MostBytes() + kMostVarintBytes + lane_[lane].coded_bytes,
                      components_ * points_ * sizeof(uint16_t));
}

void SymbolGroup::Write(size_t lane, ByteWriter& out) const {
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
