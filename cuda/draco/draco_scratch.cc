// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/draco/draco_scratch.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"

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

// `ranked`: what ranked chunks need.
uint32_t UsualEntries(const DracoWork& work, uint64_t ranked, uint32_t others) {
  const uint32_t span = kUsualSpan << std::max(0, work.position_bits - kUsualBits);
  const uint64_t usual = std::min(span, Values(work.position_bits)) + Values(work.normal_bits) +
                         kernels::TagEntries(work);
  const uint64_t all = uint64_t{others} * MostEntries(work);
  return static_cast<uint32_t>(
      ranked + std::max(std::min(others * usual, kManyEntries), std::min(all, kFewEntries)));
}

// Places the streams of each chunk, and finds which are ranked. Returns the groups of all streams and the usual entries.
struct Sizes {
  size_t groups;
  uint32_t entries;
};
Sizes Measure(std::span<kernels::DracoChunk> chunks, DracoWork& work) {
  size_t groups = 0;
  uint64_t ranked_entries = 0;
  uint32_t others = 0;
  work.most_ranked = 0;
  for (kernels::DracoChunk& chunk : chunks) {
    chunk.first_group = static_cast<uint32_t>(groups);
    groups += ChunkWords(work, chunk.points) / kernels::kSymbolsAWord;
    if (IsRanked(work, chunk.points)) {
      work.most_ranked = std::max(work.most_ranked, chunk.points);
      ranked_entries += RankedEntries(work, chunk.points);
    } else {
      ++others;
    }
  }
  work.all_ranked = others == 0;
  return {groups, UsualEntries(work, ranked_entries, others)};
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

size_t Divide(uint8_t* block, bool digests, size_t groups, DracoWork& work,
              kernels::DracoPlace*& places) {
  const size_t chunks = work.count, words = groups * kernels::kSymbolsAWord;
  Parts parts(block);
  work.control = parts.Take<kernels::DracoControl>(1);
  work.streams = parts.Take<kernels::DracoStream>(kernels::kDracoKinds * chunks);
  work.entries = parts.Take<uint2>(work.entry_room);
  work.tables = parts.Take<uint8_t>(work.entry_room * size_t{kernels::kTableBytes});
  work.symbols = parts.Take<uint16_t>(words);
  work.ranks = parts.Take<uint16_t>(work.sparse ? words : 0);
  work.leaving = parts.Take<uint16_t>(words);
  work.leaving_bytes = parts.Take<uint32_t>(groups);
  const size_t coordinates = size_t{1} << work.position_bits;
  const bool wide = coordinates > kernels::kSharedCounts && !work.all_ranked;
  work.wide_counts = parts.Take<uint32_t>(wide ? kernels::kWideSlots * coordinates : 0);
  work.chunks = parts.Take<kernels::DracoChunk>(chunks);
  work.digests = digests ? parts.Take<kernels::DracoDigest>(2 * chunks) : nullptr;
  places = parts.Take<kernels::DracoPlace>(chunks);
  return parts.bytes();
}
static_assert(sizeof(kernels::DracoChunk) == 16 && sizeof(kernels::DracoDigest) == 16,
              "parts lie one after the other, without gaps");

}  // namespace

absl::StatusOr<DracoScratch> MakeDracoScratch(CudaContext& context, cudaStream_t stream,
                                              uint32_t entry_room, bool digests,
                                              std::span<kernels::DracoChunk> chunks,
                                              DracoWork& work) {
  const Sizes sizes = Measure(chunks, work);
  work.entry_room = std::max(entry_room == 0 ? sizes.entries : entry_room, MostEntries(work));
  kernels::DracoPlace* places = nullptr;
  LATTICED_ASSIGN_OR_RETURN(
      auto block,
      DeviceBuffer<uint8_t>::Create(context.memory(), "draco",
                                    Divide(nullptr, digests, sizes.groups, work, places), stream));
  Divide(block.data(), digests, sizes.groups, work, places);
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaMemsetAsync(work.control, 0, sizeof(*work.control), stream), "the encoding"));
  return DracoScratch{std::move(block), places};
}

}  // namespace latticed
