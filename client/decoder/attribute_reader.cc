// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/decoder/attribute_reader.h"

#include <algorithm>

#include "client/decoder/lanes/position_step.h"
#include "client/decoder/symbol_stream.h"
#include "core/codec/draco_container.h"
#include "core/codec/rans_model.h"

namespace latticed::decoder {
namespace {

using lane_kernel::kLanes;
using lane_kernel::SymbolLane;

constexpr uint32_t kEndSymbol = 1u << 16;
constexpr uint32_t kTags = 17;  // bit lengths of 16-bit symbols, and 0

// A column of rows, from its first number on.
class Column {
 public:
  explicit Column(uint16_t* at) : at_(at) {}
  void Put(uint32_t symbol) {
    *at_ = static_cast<uint16_t>(symbol);
    at_ += kLanes;
    largest_ = std::max(largest_, symbol);
  }
  uint32_t largest() const { return largest_; }

 private:
  uint16_t* at_;
  uint32_t largest_ = 0;
};

bool ReadPlain(ByteReader& in, uint32_t count, Column& column) {
  const uint32_t width = in.Byte();
  if (width != 1 && width != 2) return false;
  const uint8_t* bytes = in.Skip(uint64_t{width} * count);
  if (bytes == nullptr) return false;
  for (uint32_t i = 0; i < count; ++i, bytes += width) {
    column.Put(width == 1 ? *bytes : uint32_t{bytes[0]} | uint32_t{bytes[1]} << 8);
  }
  return true;
}

// Numbers of several bits each, low bits first.
class BitReader {
 public:
  explicit BitReader(ByteReader* in) : in_(in) {}
  uint32_t Read(uint32_t bits) {
    for (; held_ < bits; held_ += 8) word_ |= in_->Byte() << held_;
    const uint32_t value = word_ & ((1u << bits) - 1);
    word_ >>= bits;
    held_ -= bits;
    return value;
  }

 private:
  ByteReader* const in_;
  uint32_t word_ = 0, held_ = 0;
};

bool ReadTagged(ByteReader& in, uint32_t components, uint32_t points, WideTable* table,
                Column& column) {
  const CodedSymbols tags = ReadCoded(in, kNarrowPrecision, kTags, nullptr, table);
  if (tags.kind != TableKind::kWide) return false;
  BitReader bits(&in);
  return DecodeWideStates(tags.begin, tags.end, points, *table, [&](uint32_t tag) {
    for (uint32_t c = 0; c < components; ++c) column.Put(bits.Read(tag));
    return in.ok();
  });
}

bool ReadRaw(ByteReader& in, uint32_t count, NarrowTable* narrow, WideTable* wide, SymbolLane* lane,
             Column& column, uint32_t* largest) {
  const CodedSymbols coded = ReadRawCoded(in, kEndSymbol, narrow, wide);
  if (coded.kind == TableKind::kBad) return false;
  *largest = coded.largest;
  if (coded.kind == TableKind::kWide) {
    return DecodeWideStates(coded.begin, coded.end, count, *wide, [&](uint32_t symbol) {
      column.Put(symbol);
      return true;
    });
  }
  RansStart start;
  if (!StartRans(coded.begin, coded.end, kNarrowPrecision, &start)) return false;
  lane->word = uint64_t{start.state} << kStateShift;
  lane->at = start.at;
  lane->begin = coded.begin;
  lane->table = narrow;
  lane->symbols = count;
  lane->done = 0;
  return true;
}

}  // namespace

bool ReadSymbols(ByteReader& in, uint32_t components, uint32_t points, NarrowTable* narrow,
                 WideTable* wide, SymbolLane* lane, uint32_t* largest) {
  Column column(lane->out);
  lane->table = nullptr;
  const uint32_t coded = in.Byte();
  if (coded == draco_format::kCoded) {
    const uint32_t scheme = in.Byte();
    if (scheme == kSchemeRaw) {
      return ReadRaw(in, components * points, narrow, wide, lane, column, largest);
    }
    if (scheme != kSchemeTagged || !ReadTagged(in, components, points, wide, column)) return false;
  } else if (coded != draco_format::kPlain || !ReadPlain(in, components * points, column)) {
    return false;
  }
  *largest = column.largest();
  return true;
}

void Unwrap(uint16_t* column, uint32_t points, uint32_t span) {
  constexpr size_t kRow = 3 * kLanes;
  for (uint32_t c = 0; c < 3; ++c, column += kLanes) {
    int32_t value = 0;
    for (uint32_t i = 0; i < points; ++i) {
      uint16_t& symbol = column[i * kRow];
      const int32_t before = value;
      value = NextPosition(value, symbol, static_cast<int32_t>(span));
      const auto step = static_cast<int16_t>(value - before);
      symbol = static_cast<uint16_t>(step < 0 ? -2 * step - 1 : 2 * step);
    }
  }
}

}  // namespace latticed::decoder
