// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Draco's scheme TAGGED for the symbols of an attribute:
//
//   0 | table of tags | varint bytes | states of the tags | components in as many bits as their tag says, low bits first
//
// The tag of a point is the bit length of its largest component, at least 1. Tags are coded like symbols of the scheme RAW,
// whose table has an entry for each symbol that occurs. Where points are few and far apart, nearly every symbol is another
// one, and such a table takes more than the symbols.
//
// Threads  used by one thread at a time; memory is kept from one use to the next
#ifndef LATTICED_CORE_CODEC_TAGGED_SYMBOLS_H_
#define LATTICED_CORE_CODEC_TAGGED_SYMBOLS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/codec/byte_writer.h"
#include "core/codec/rans_table.h"

namespace latticed {

class TaggedSymbols {
 public:
  TaggedSymbols();

  // Codes the symbols: a plane for each component, each of `points` symbols.
  void Code(std::span<const uint16_t* const> planes, size_t points);

  // After Code: what Write writes.
  size_t Bytes() const { return head_.size() + bits_.size(); }
  void Write(ByteWriter& out) const {
    out.Bytes(head_);
    out.Bytes(bits_);
  }
  // The most that `points` points of so many components take.
  static size_t MostBytes(size_t components, size_t points);
  size_t MemoryBytes() const;

 private:
  void CodeTags();

  RansTable table_;
  std::vector<uint32_t> histogram_;  // zero except while counting
  std::vector<uint8_t> tags_;        // by point
  std::vector<uint8_t> states_, head_, bits_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_TAGGED_SYMBOLS_H_
