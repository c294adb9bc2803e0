// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A thread a stream: the state takes the symbols, last one first, and bytes leave it. A step waits
// for the one before it, 40 cycles; its symbol and entry do not, so they are loaded ahead, eight at
// a time. Streams share a warp, positions with positions, only where there are more of them than
// schedulers: every lane loads from lines of its own.
#include <utility>

#include "cuda/draco_table.cuh"

namespace latticed::kernels {
namespace {

constexpr uint32_t kAhead = 8;  // symbols in 16 bytes
static_assert(sizeof(uint4) == kAhead * sizeof(uint16_t));

// Bytes to memory, four at a time, up to `room`.
class ByteSink {
 public:
  __device__ ByteSink(uint8_t* to, uint32_t room)
      : to_(reinterpret_cast<uint32_t*>(to)), room_(room) {}

  // The low `count` bytes, up to three; Flush at least after every fourth byte.
  __device__ __forceinline__ void Put(uint32_t bytes, uint32_t count) {
    const uint32_t kept = bytes & ((1u << (8 * count)) - 1);
    held_ |= static_cast<uint64_t>(kept) << (8 * held_bytes_);
    held_bytes_ += count;
  }
  __device__ __forceinline__ void Flush() {
    if (held_bytes_ < 4) return;
    if (stored_ + 4 <= room_) to_[stored_ / 4] = static_cast<uint32_t>(held_);
    stored_ += 4;
    held_ >>= 32;
    held_bytes_ -= 4;
  }
  // All that was put; how many bytes.
  __device__ uint32_t Finish() {
    if (stored_ + 4 <= room_) to_[stored_ / 4] = static_cast<uint32_t>(held_);
    return stored_ + held_bytes_;
  }

 private:
  uint32_t* to_;
  uint32_t room_, stored_ = 0, held_bytes_ = 0;
  uint64_t held_ = 0;
};

// A state at 12 bits.
class ShortState {
 public:
  __device__ explicit ShortState(int) {}
  __device__ __forceinline__ void Take(uint2 entry, ByteSink& sink) {
    const uint32_t limit = ShortProbability(entry) << 10;
    const uint32_t leaving = (x_ >= limit ? 1u : 0u) + (x_ >> 8 >= limit ? 1u : 0u);
    sink.Put(x_, leaving);
    x_ = ShortStep(x_ >> (8 * leaving), entry);
  }
  static constexpr bool kFlushAlways = false;  // two bytes a symbol at most: every second one
  __device__ uint32_t value() const { return x_; }

 private:
  uint32_t x_ = 4 * kShortM;
};

class LongState {
 public:
  __device__ explicit LongState(int precision) : precision_(precision), x_(4u << precision) {}
  __device__ __forceinline__ void Take(uint2 entry, ByteSink& sink) {
    const uint32_t limit = entry.x << 10;
    const uint32_t leaving =
        (x_ >= limit ? 1u : 0u) + (x_ >> 8 >= limit ? 1u : 0u) + (x_ >> 16 >= limit ? 1u : 0u);
    sink.Put(x_, leaving);
    x_ = LongStep(x_ >> (8 * leaving), entry, precision_);
  }
  static constexpr bool kFlushAlways = true;
  __device__ uint32_t value() const { return x_; }

 private:
  int precision_;
  uint32_t x_;
};

struct Eight {
  uint2 entry[kAhead];
};

__device__ __forceinline__ Eight EntriesOf(const uint2* entries, uint4 symbols) {
  const uint32_t pairs[] = {symbols.x, symbols.y, symbols.z, symbols.w};
  Eight eight;
  for (uint32_t i = 0; i < kAhead; ++i) {
    eight.entry[i] = entries[i % 2 == 0 ? pairs[i / 2] & 0xffff : pairs[i / 2] >> 16];
  }
  return eight;
}

// The last state in one to four bytes, as FinishRans of core/codec/rans_encoder.h.
__device__ void PutState(uint32_t x, int precision, ByteSink& sink) {
  const uint32_t above = x - (4u << precision);
  const uint32_t more = above < 1u << 6 ? 0 : above < 1u << 14 ? 1 : above < 1u << 22 ? 2 : 3;
  const uint32_t word = above | more << (8 * more + 6);
  sink.Put(word, min(more + 1, 2u));
  sink.Flush();
  sink.Put(word >> 16, more < 2 ? 0 : more - 1);
  sink.Flush();
}

// Bytes of `count` symbols, which are put last one first.
template <class State>
__device__ uint32_t Code(const uint16_t* symbols, uint32_t count, const uint2* entries,
                         int precision, ByteSink sink) {
  State state(precision);
  const uint32_t whole = count / kAhead;
  for (uint32_t i = count; i > whole * kAhead; --i) {
    state.Take(entries[symbols[i - 1]], sink);
    sink.Flush();
  }
  const auto* blocks = reinterpret_cast<const uint4*>(symbols);
  // Behind the first block nothing is left to load ahead: it is loaded again.
  const auto block = [&](uint32_t i) { return blocks[static_cast<int32_t>(i) > 0 ? i : 0]; };
  if (whole > 0) {
    Eight next = EntriesOf(entries, block(whole - 1));
    uint4 after = block(whole - 2);
    for (uint32_t i = whole; i > 0; --i) {
      const Eight now = next;
      next = EntriesOf(entries, after);
      after = block(i - 3);
#pragma unroll
      for (uint32_t k = kAhead; k > 0; --k) {
        state.Take(now.entry[k - 1], sink);
        if (State::kFlushAlways || k % 2 != 0) sink.Flush();
      }
    }
  }
  PutState(state.value(), precision, sink);
  return sink.Finish();
}

struct Arguments {
  DracoWork work;
  uint32_t streams_per_warp;
};

__global__ void __launch_bounds__(kWarp) RansKernel(const __grid_constant__ Arguments arguments) {
  const DracoWork& work = arguments.work;
  const uint32_t lanes = arguments.streams_per_warp;
  const uint32_t warps = (work.count + lanes - 1) / lanes;  // of one attribute
  const bool normals = blockIdx.x >= warps;
  const uint32_t chunk = (blockIdx.x - (normals ? warps : 0)) * lanes + threadIdx.x;
  if (threadIdx.x >= lanes || chunk >= work.count) return;
  DracoStream& stream = work.streams[2 * chunk + (normals ? 1 : 0)];
  if (stream.deferred != 0) return;
  const uint32_t values = normals ? kNormalValues : kPositionValues;
  const uint32_t states_at = StatesAt(stream.table_bytes);
  const auto room = static_cast<uint32_t>(CodedBytes(work.points, values));
  const uint32_t count = work.Points(chunk) * values;
  if (states_at >= room) {  // the table alone is more than plain symbols take
    stream.coded_bytes = count;
    return;
  }
  const ByteSink sink(CodedOf(work, chunk, normals) + states_at, room - states_at);
  const uint16_t* symbols = SymbolsOf(work, chunk, normals);
  const uint2* entries = work.entries + stream.first_entry;
  const int precision = RansPrecision(stream.bit_length);
  stream.coded_bytes = precision == kLeastRansPrecision
                           ? Code<ShortState>(symbols, count, entries, precision, sink)
                           : Code<LongState>(symbols, count, entries, precision, sink);
}

}  // namespace

cudaError_t LaunchDracoRans(const DracoWork& work, unsigned streams_per_warp, cudaStream_t stream) {
  if (work.count == 0) return cudaSuccess;
  const unsigned warps = (work.count + streams_per_warp - 1) / streams_per_warp;
  RansKernel<<<work.normal_bits == 0 ? warps : 2 * warps, kWarp, 0, stream>>>(
      Arguments{work, streams_per_warp});
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
