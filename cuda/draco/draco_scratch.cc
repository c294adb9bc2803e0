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

uint32_t MostEntries(const DracoWork& work) {
  return (1u << work.position_bits) + (work.normal_bits == 0 ? 0 : 1u << work.normal_bits);
}

uint32_t UsualEntries(const DracoWork& work) {
  const uint32_t span = kUsualSpan << std::max(0, work.position_bits - kUsualBits);
  const uint64_t usual = std::min(span, 1u << work.position_bits) +
                         (work.normal_bits == 0 ? 0 : 1u << work.normal_bits);
  const uint64_t all = uint64_t{work.count} * MostEntries(work);
  return static_cast<uint32_t>(
      std::max(std::min(work.count * usual, kManyEntries), std::min(all, kFewEntries)));
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

size_t Divide(uint8_t* block, bool digests, DracoWork& work, kernels::DracoPlace*& places) {
  const size_t chunks = work.count;
  const size_t words = chunks * kernels::ChunkWords(work.points, work.normal_bits > 0);
  Parts parts(block);
  work.control = parts.Take<kernels::DracoControl>(1);
  work.streams = parts.Take<kernels::DracoStream>(2 * chunks);
  work.entries = parts.Take<uint2>(work.entry_room);
  work.tables = parts.Take<uint8_t>(work.entry_room * size_t{kernels::kTableBytes});
  work.symbols = parts.Take<uint16_t>(words);
  work.leaving = parts.Take<uint16_t>(words);
  work.leaving_bytes = parts.Take<uint32_t>(words / kernels::kSymbolsAWord);
  const size_t coordinates = size_t{1} << work.position_bits;
  const bool wide = coordinates > kernels::kSharedCounts;
  work.wide_counts = parts.Take<uint32_t>(wide ? kernels::kWideSlots * coordinates : 0);
  work.digests = digests ? parts.Take<kernels::DracoDigest>(2 * chunks) : nullptr;
  places = parts.Take<kernels::DracoPlace>(chunks);
  return parts.bytes();
}

}  // namespace

absl::StatusOr<DracoScratch> MakeDracoScratch(CudaContext& context, cudaStream_t stream,
                                              uint32_t entry_room, bool digests, DracoWork& work) {
  if (entry_room == 0) entry_room = UsualEntries(work);
  work.entry_room = std::max(entry_room, MostEntries(work));
  kernels::DracoPlace* places = nullptr;
  LATTICED_ASSIGN_OR_RETURN(
      auto block, DeviceBuffer<uint8_t>::Create(context.memory(), "draco",
                                                Divide(nullptr, digests, work, places), stream));
  Divide(block.data(), digests, work, places);
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(cudaMemsetAsync(work.control, 0, sizeof(*work.control), stream), "the encoding"));
  return DracoScratch{std::move(block), places};
}

}  // namespace latticed
