// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/symbol_stream.h"

#include <algorithm>

#include "core/codec/rans_model.h"

namespace latticed {
namespace {

constexpr size_t kPadding = 64;
// Numbers of the format.
constexpr uint32_t kPlain = 0, kCoded = 1, kSchemeRaw = 1;

}  // namespace

SymbolStream::SymbolStream(size_t points, size_t components, int bits)
    : points_(points),
      components_(components),
      stride_((points + kPadding - 1) / kPadding * kPadding),
      symbols_(components * stride_),
      counts_(size_t{1} << bits),
      entries_(size_t{1} << bits) {}

void SymbolStream::Tabulate() {
  uint32_t largest = 0;
  for (size_t c = 0; c < components_; ++c) {
    for (const uint16_t symbol : plane(c).first(points_)) {
      ++counts_[symbol];
      largest = std::max(largest, uint32_t{symbol});
    }
  }
  table_.Build(std::span(counts_).first(largest + size_t{1}));
}

void SymbolStream::Code() {
  if (table_.bit_length() == 0) return;
  for (const RansTable::Symbol& s : table_.symbols()) {
    entries_[s.symbol] = MakeRansEntry(s.probability, s.cumulative);
  }
  // A symbol of the least probability takes `precision` bits, and what waits in the state four
  // bytes.
  const auto precision = static_cast<size_t>(table_.precision());
  states_.resize(components_ * points_ * ((precision + 7) / 8) + 4);
  RansEncoder encoder(table_.precision(), states_.data());
  for (size_t i = points_; i-- > 0;) {
    for (size_t c = components_; c-- > 0;) encoder.Put(entries_[symbols_[c * stride_ + i]]);
  }
  states_.resize(static_cast<size_t>(encoder.Finish() - states_.data()));
}

size_t SymbolStream::MostBytes() const {
  return 3 + std::max(table_.MostBytes() + kMostVarintBytes + states_.size(),
                      components_ * points_ * sizeof(uint16_t));
}

void SymbolStream::Write(ByteWriter& out) const {
  const ByteWriter start = out;
  const uint32_t largest = table_.symbols().back().symbol;
  if (table_.bit_length() != 0) {
    out.Byte(kCoded);
    out.Byte(kSchemeRaw);
    out.Byte(static_cast<uint32_t>(table_.bit_length()));
    table_.Write(out);
    out.Varint(states_.size());
    out.Bytes(states_);
    const auto coded = static_cast<size_t>(out.at() - start.at());
    if (!StorePlainly(coded, components_ * points_, largest)) return;
  }
  out = start;
  WritePlainly(largest, out);
}

void SymbolStream::WritePlainly(uint32_t largest, ByteWriter& out) const {
  const uint32_t width = PlainSymbolBytes(largest);
  out.Byte(kPlain);
  out.Byte(width);
  for (size_t i = 0; i < points_; ++i) {
    for (size_t c = 0; c < components_; ++c) {
      const uint16_t symbol = symbols_[c * stride_ + i];
      out.Byte(symbol);
      if (width == 2) out.Byte(symbol >> 8);
    }
  }
}

}  // namespace latticed
