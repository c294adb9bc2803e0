// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The symbols of one attribute of up to 16 chunks with the same number of points, and their coding.
//
// Layout   a plane of uint16 for each lane and component, padded so that vectors may go past its
//          last point; a stream's order is point by point, components within a point
// Threads  used by one thread at a time; memory is kept from one use to the next
#ifndef LATTICED_CORE_CODEC_SYMBOL_GROUP_H_
#define LATTICED_CORE_CODEC_SYMBOL_GROUP_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/codec/byte_writer.h"
#include "core/codec/draco_kernel.h"
#include "core/codec/rans_encoder.h"
#include "core/codec/rans_table.h"
#include "core/codec/tagged_symbols.h"

namespace latticed {

class SymbolGroup {
 public:
  // Starts over. All symbols that follow are below `most_symbols`.
  void Begin(size_t lanes, size_t points, size_t components, size_t most_symbols);

  uint16_t* plane(size_t lane, size_t component) {
    return symbols_.data() + (lane * components_ + component) * stride_;
  }
  // Counts the symbols of a lane, all below `end`, and makes its table of probabilities.
  void Tabulate(size_t lane, size_t end);

  // Codes all lanes of both groups side by side. `normals` may be null.
  static void Code(SymbolGroup& positions, SymbolGroup* normals);

  // After Code: writes the table and the states of a lane, or its plain symbols, whichever is
  // shorter. `tagged`, which may be null, is tried too.
  void Write(size_t lane, TaggedSymbols* tagged, ByteWriter& out) const;
  size_t MostBytes(size_t lane) const;

  size_t MemoryBytes() const;

 private:
  struct Lane {
    RansTable table;
    size_t coded_bytes = 0;
  };

  bool SuitsLanes() const;
  void CodeByChains();
  template <size_t kCount>
  void CodeChains(size_t first);
  draco_kernel::LaneStreams BeginLanes();
  void FinishLanes(const draco_kernel::LaneStreams& streams);
  void WriteRaw(size_t lane, ByteWriter& out) const;
  void WritePlainly(size_t lane, uint32_t largest, ByteWriter& out) const;
  const uint16_t* plane(size_t lane, size_t component) const {
    return symbols_.data() + (lane * components_ + component) * stride_;
  }

  size_t lanes_ = 0, points_ = 0, components_ = 0, stride_ = 0, most_symbols_ = 0,
         coded_stride_ = 0, entry_stride_ = 0;
  std::vector<uint16_t> symbols_;
  std::vector<uint32_t> histograms_;    // kHistograms; zero except while counting
  std::vector<RansEntry> entries_;      // by symbol, of each chain
  std::vector<uint32_t> lane_entries_;  // the same as words, of each lane
  std::vector<uint8_t> coded_;          // bytes that left the states, by lane
  std::array<Lane, draco_kernel::kLanes> lane_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_SYMBOL_GROUP_H_
