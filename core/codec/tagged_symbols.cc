// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/codec/tagged_symbols.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/codec/draco_kernel.h"
#include "core/codec/rans_encoder.h"
#include "core/codec/rans_model.h"

namespace latticed {
namespace {

constexpr size_t kTags = 17;  // bit lengths of 16-bit symbols, and 0

}  // namespace

TaggedSymbols::TaggedSymbols() : histogram_(kTags + draco_kernel::kPadding) {
  table_.Reserve(kTags);
}

void TaggedSymbols::Code(std::span<const uint16_t* const> planes, size_t points) {
  tags_.resize(points);
  bits_.clear();
  uint64_t word = 0;
  int filled = 0;
  for (size_t i = 0; i < points; ++i) {
    uint16_t any = 1;
    for (const uint16_t* plane : planes) any |= plane[i];
    const int tag = std::bit_width(any);
    tags_[i] = static_cast<uint8_t>(tag);
    ++histogram_[static_cast<size_t>(tag)];
    for (const uint16_t* plane : planes) {
      word |= uint64_t{plane[i]} << filled;
      filled += tag;
      for (; filled >= 8; filled -= 8, word >>= 8) bits_.push_back(static_cast<uint8_t>(word));
    }
  }
  if (filled > 0) bits_.push_back(static_cast<uint8_t>(word));
  CodeTags();
}

void TaggedSymbols::CodeTags() {
  table_.Build(histogram_, 1, kTags, kTags);
  std::array<RansEntry, kTags> entries{};
  table_.ForEach([&](uint32_t tag, uint32_t probability, uint32_t cumulative) {
    entries[tag] = MakeRansEntry(probability, cumulative);
  });
  states_.resize(MostRansBytes(tags_.size(), table_.precision()));
  RansEncoder encoder(table_.precision(), states_.data());
  for (size_t i = tags_.size(); i-- > 0;) encoder.Put(entries[tags_[i]]);
  states_.resize(static_cast<size_t>(encoder.Finish() - states_.data()));

  head_.resize(1 + table_.MostBytes() + kMostVarintBytes + states_.size());
  ByteWriter out(head_.data());
  out.Byte(kSchemeTagged);
  table_.Write(out);
  out.Varint(states_.size());
  out.Bytes(states_);
  head_.resize(static_cast<size_t>(out.at() - head_.data()));
}

size_t TaggedSymbols::MostBytes(size_t components, size_t points) {
  return 1 + 4 * kTags + 2 * kMostVarintBytes + MostRansBytes(points, kLeastRansPrecision) +
         components * points * sizeof(uint16_t);
}

size_t TaggedSymbols::MemoryBytes() const {
  return table_.MemoryBytes() + histogram_.capacity() * sizeof(uint32_t) + tags_.capacity() +
         states_.capacity() + head_.capacity() + bits_.capacity();
}

}  // namespace latticed
