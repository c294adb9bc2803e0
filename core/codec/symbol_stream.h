// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The symbols of one attribute of one chunk, and how they become bytes.
//
// Layout   a plane of uint16 for each component, padded so that vectors may read and write past
//          the last point; the stream's order is point by point, components within a point
// Threads  used by one thread at a time
#ifndef LATTICED_CORE_CODEC_SYMBOL_STREAM_H_
#define LATTICED_CORE_CODEC_SYMBOL_STREAM_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/codec/byte_writer.h"
#include "core/codec/rans_encoder.h"
#include "core/codec/rans_table.h"

namespace latticed {

class SymbolStream {
 public:
  // Symbols that can occur are those below 2^bits.
  SymbolStream(size_t points, size_t components, int bits);

  size_t points() const { return points_; }
  size_t components() const { return components_; }
  std::span<uint16_t> plane(size_t component) {
    return std::span(symbols_).subspan(component * stride_, stride_);
  }
  std::span<const uint16_t> plane(size_t component) const {
    return std::span(symbols_).subspan(component * stride_, stride_);
  }

  // Counts the symbols and shares out probabilities.
  void Tabulate();
  // Codes them all, where they have probabilities.
  void Code();

  // After those two: scheme, table and states, or the plain symbols, whichever is less.
  void Write(ByteWriter& out) const;
  size_t MostBytes() const;

 private:
  void WritePlainly(uint32_t largest, ByteWriter& out) const;

  size_t points_, components_, stride_;
  std::vector<uint16_t> symbols_;
  std::vector<uint32_t> counts_;  // zero but while counting
  RansTable table_;
  std::vector<RansEntry> entries_;  // by symbol
  std::vector<uint8_t> states_;     // what left the coder
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_SYMBOL_STREAM_H_
