// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/draco/draco_scratch.h"

#include <algorithm>
#include <limits>

namespace latticed {
namespace {

using kernels::DracoWork;

// When a surface has many chunks, each spans a few hundred steps at 12 bits, and twice as many with every
// further bit. When it has few, each may span all of them.
constexpr uint32_t kUsualSpan = 1024;
constexpr int kUsualBits = 12;
constexpr uint64_t kFewEntries = 1 << 22, kManyEntries = 1 << 24;

uint32_t Values(int bits) { return bits == 0 ? 0 : 1u << bits; }

// Of one chunk.
uint32_t MostEntries(const DracoWork& work) {
  const uint32_t all =
      Values(work.position_bits) + Values(work.normal_bits) + kernels::TagEntries(work);
  return work.most_ranked == 0 ? all : std::max(all, RankedEntries(work, work.most_ranked));
}

// No less than what so many ranked chunks need, which have so many points: a sum of lesser numbers is at most the lesser
// of two sums.
uint64_t RankedEntriesOfAll(const DracoWork& work, uint64_t chunks, uint64_t points) {
  const auto attribute = [&](uint32_t values, int32_t bits) {
    return std::min(chunks * kernels::RankedEntries(std::numeric_limits<uint32_t>::max(), bits),
                    chunks * kernels::RankedEntries(0, bits) + values * points);
  };
  return attribute(kernels::kPositionValues, work.position_bits) +
         (work.has_normals() ? attribute(kernels::kNormalValues, work.normal_bits) : 0) +
         chunks * kernels::TagEntries(work);
}

// `ranked`: what ranked chunks need.
uint32_t UsualEntries(const DracoWork& work, uint64_t ranked, uint64_t others) {
  const uint32_t span = kUsualSpan << std::max(0, work.position_bits - kUsualBits);
  const uint64_t usual = std::min(span, Values(work.position_bits)) + Values(work.normal_bits) +
                         kernels::TagEntries(work);
  const uint64_t all = others * MostEntries(work);
  return static_cast<uint32_t>(
      ranked + std::max(std::min(others * usual, kManyEntries), std::min(all, kFewEntries)));
}

// Hands out parts of a block. A first pass without memory finds the size of the block.
class Parts {
 public:
  explicit Parts(uint8_t* block) : block_(block) {}
  template <class T>
  T* Take(size_t count) {
    T* const part = block_ == nullptr ? nullptr : reinterpret_cast<T*>(block_ + at_);
    at_ += kernels::RoundUpTo16(count * sizeof(T));
    return part;
  }
  size_t bytes() const { return at_; }

 private:
  uint8_t* block_;
  size_t at_ = 0;
};

}  // namespace

DracoSizes::DracoSizes(const kernels::DracoWork& work)
    : room_(work.Kinds() * (kernels::kSymbolsAWord - 1)) {
  for (uint32_t k = 0; k < work.Kinds(); ++k) values_ += ValuesOf(work.KindOf(k));
}

void DracoSizes::SetSizes(uint32_t entry_room, DracoWork& work) const {
  work.count = chunks_;
  work.most_ranked = work.sparse ? most_of_others_ : 0;
  work.all_ranked = work.sparse && large_ == 0;
  const uint32_t others = work.sparse ? large_ : chunks_;
  const uint64_t ranked_points = work.sparse ? points_ - large_points_ : 0;
  const uint64_t ranked = RankedEntriesOfAll(work, chunks_ - others, ranked_points);
  const uint32_t usual = UsualEntries(work, ranked, others);
  work.entry_room = std::max(entry_room == 0 ? usual : entry_room, MostEntries(work));
}

size_t DivideDracoScratch(uint8_t* block, size_t groups, DracoWork& work) {
  const size_t words = groups * kernels::kSymbolsAWord;
  Parts parts(block);
  work.streams = parts.Take<kernels::DracoStream>(size_t{kernels::kDracoKinds} * work.count);
  work.entries = parts.Take<uint2>(work.entry_room);
  work.tables = parts.Take<uint8_t>(work.entry_room * size_t{kernels::kTableBytes});
  work.symbols = parts.Take<uint16_t>(words);
  work.ranks = parts.Take<uint16_t>(work.sparse ? words : 0);
  work.leaving = parts.Take<uint16_t>(words);
  work.leaving_bytes = parts.Take<uint32_t>(groups);
  const size_t coordinates = size_t{1} << work.position_bits;
  const bool wide = coordinates > kernels::kSharedCounts && !work.all_ranked;
  work.wide_counts = parts.Take<uint32_t>(wide ? kernels::kWideSlots * coordinates : 0);
  return parts.bytes();
}

}  // namespace latticed
