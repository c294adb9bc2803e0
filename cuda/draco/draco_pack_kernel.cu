// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the place of each chunk's stream among all streams, and writes its bytes there, part by part:
//
//   head | positions | least, most | prediction of normals | normals | end
//
// positions and normals are a table and the bytes that left the state, or plain symbols when these are
// shorter.
#include "cuda/draco/draco_leaving.cuh"
#include "cuda/draco/draco_table.cuh"

namespace latticed::kernels {
namespace {

constexpr unsigned kThreads = 128;        // that pack a chunk
constexpr unsigned kPlaceThreads = 1024;  // that add up sizes
// Constants of the Draco format.
constexpr uint32_t kPlain = 0, kCoded = 1, kSchemeRaw = 1;

struct Arguments {
  DracoWork work;
  DracoFrame frame;
  DracoPlace* places;
  uint8_t* out;
};

__device__ uint32_t VarintBytes(uint32_t value) {
  uint32_t bytes = 1;
  for (; value >= 0x80; value >>= 7) ++bytes;
  return bytes;
}

// The part of a stream that holds an attribute's symbols.
struct Part {
  DracoStream stream;
  uint32_t symbols, size;
  bool plain;

  __device__ Part(const DracoWork& work, uint32_t chunk, bool normals)
      : stream(work.streams[2 * chunk + (normals ? 1 : 0)]),
        symbols(work.Points(chunk) * (normals ? kNormalValues : kPositionValues)) {
    const uint32_t coded =
        3 + stream.table_bytes + VarintBytes(stream.coded_bytes) + stream.coded_bytes;
    plain = StorePlainly(coded, symbols, stream.largest);
    size = plain ? 2 + symbols * PlainSymbolBytes(stream.largest) : coded;
  }
};

__device__ const DracoFrame::Head& HeadOf(const Arguments& arguments, uint32_t chunk) {
  return arguments.frame.heads[arguments.work.IsLast(chunk) ? 1 : 0];
}

// 0 for a chunk that was not coded.
__device__ uint32_t StreamBytes(const Arguments& arguments, uint32_t chunk) {
  const Part positions(arguments.work, chunk, false);
  if (!IsCoded(positions.stream)) return 0;
  const DracoFrame::Head& head = HeadOf(arguments, chunk);
  uint32_t size = head.size + positions.size + 2 * sizeof(int32_t) + arguments.frame.end_size;
  if (arguments.work.normal_bits > 0) {
    size += sizeof(arguments.frame.normal_prediction) + Part(arguments.work, chunk, true).size;
  }
  return max(size, head.least_stream);
}

__global__ void __launch_bounds__(kPlaceThreads)
    PlacesKernel(const __grid_constant__ Arguments arguments) {
  __shared__ uint32_t sums[kPlaceThreads / kWarp];
  const unsigned warp = threadIdx.x / kWarp;
  uint32_t before = 0;
  for (uint32_t base = 0; base < arguments.work.count; base += kPlaceThreads) {
    const uint32_t chunk = base + threadIdx.x;
    const uint32_t size = chunk < arguments.work.count ? StreamBytes(arguments, chunk) : 0;
    const auto room = static_cast<uint32_t>(RoundUpTo16(size));
    const uint32_t in_warp = SumUpTo(room);
    if (Lane() == kWarp - 1) sums[warp] = in_warp;
    __syncthreads();
    const uint32_t warps = SumUpTo(sums[Lane()]);  // by every warp
    const uint32_t warps_before =
        warp == 0 ? 0 : __shfl_sync(kAllLanes, warps, (warp + 31) % kWarp);
    if (chunk < arguments.work.count) {
      arguments.places[chunk] = {before + warps_before + in_warp - room, size};
    }
    before += __shfl_sync(kAllLanes, warps, kWarp - 1);
    __syncthreads();
  }
}
static_assert(kPlaceThreads / kWarp == kWarp, "a warp adds up the sums of all warps");

// Appends bytes; all threads of the block call it together.
class Packer {
 public:
  __device__ explicit Packer(uint8_t* at) : at_(at) {}

  __device__ void Copy(const uint8_t* bytes, uint32_t count) {
    for (uint32_t i = threadIdx.x; i < count; i += kThreads) at_[i] = bytes[i];
    at_ += count;
  }
  // The lowest first.
  __device__ void Word(uint64_t word, uint32_t count) {
    if (threadIdx.x < count) at_[threadIdx.x] = static_cast<uint8_t>(word >> (8 * threadIdx.x));
    at_ += count;
  }
  __device__ void Varint(uint32_t value) {
    const uint32_t count = VarintBytes(value);
    if (threadIdx.x < count) {
      const uint32_t seven = value >> (7 * threadIdx.x) & 127;
      at_[threadIdx.x] = static_cast<uint8_t>(threadIdx.x + 1 < count ? seven | 128 : seven);
    }
    at_ += count;
  }
  __device__ void PlainSymbols(const uint16_t* symbols, uint32_t count, uint32_t width) {
    for (uint32_t i = threadIdx.x; i < count; i += kThreads) {
      at_[width * i] = static_cast<uint8_t>(symbols[i]);
      if (width == 2) at_[2 * i + 1] = static_cast<uint8_t>(symbols[i] >> 8);
    }
    at_ += count * width;
  }
  __device__ void Zeros(const uint8_t* end) {
    for (uint8_t* at = at_ + threadIdx.x; at < end; at += kThreads) *at = 0;
  }

 private:
  uint8_t* at_;
};

// Appends bytes to words of shared memory that were set to zero. It may begin at any byte of a word.
class WordSink {
 public:
  __device__ WordSink(uint32_t* words, uint32_t byte)
      : at_(words + byte / 4), held_bits_(byte % 4 * 8) {}
  __device__ void Put(uint32_t bytes, uint32_t bits) {
    held_ |= static_cast<uint64_t>(bytes) << held_bits_;
    held_bits_ += bits;
  }
  // Called after at most four bytes. Threads share the first and the last word, so it uses atomicOr.
  __device__ void Flush() {
    if (held_bits_ < 32) return;
    atomicOr(at_++, static_cast<uint32_t>(held_));
    held_ >>= 32;
    held_bits_ -= 32;
  }
  __device__ void Finish() {
    if (held_bits_ > 0) atomicOr(at_, static_cast<uint32_t>(held_));
  }

 private:
  uint32_t* at_;
  uint64_t held_ = 0;
  uint32_t held_bits_;
};

// Appends the bytes of sixteen symbols, the last symbol first.
__device__ void PutLeaving(const uint16_t* leaving, uint32_t counts, WordSink sink) {
  const auto* blocks = reinterpret_cast<const uint4*>(leaving);
  const uint4 halves[] = {__ldg(blocks), __ldg(blocks + 1)};
#pragma unroll
  for (uint32_t pair = kSymbolsAWord / 2; pair-- > 0;) {
    const uint4 half = halves[pair / 4];
    const uint32_t both = pair % 4 == 0   ? half.x
                          : pair % 4 == 1 ? half.y
                          : pair % 4 == 2 ? half.z
                                          : half.w;
    const uint32_t upper = (counts >> (4 * pair + 2) & 3) * 8;
    const uint32_t lower = (counts >> (4 * pair) & 3) * 8;
    sink.Put(both >> 16 & ((1u << upper) - 1), upper);
    sink.Put(both & ((1u << lower) - 1), lower);
    sink.Flush();
  }
  sink.Finish();
}

// Packs the bytes that left a state at 12 bits, sixteen symbols a thread, the last symbols first. They are
// put together in shared memory, so that they are written in whole cache lines.
__device__ void PackLeaving(const uint16_t* leaving, const uint32_t* leaving_bytes,
                            uint32_t symbols, Packer& packer) {
  constexpr uint32_t kBytes = kThreads * kSymbolsAWord * 2;
  __shared__ uint32_t bytes[kBytes / 4 + 1];
  __shared__ uint32_t sums[kThreads / kWarp];
  const uint32_t words = (symbols + kSymbolsAWord - 1) / kSymbolsAWord;
  uint32_t filled = kBytes;  // of the last time
  for (uint32_t first = 0; first < words; first += kThreads) {
    for (uint32_t i = threadIdx.x; i <= filled / 4; i += kThreads) bytes[i] = 0;
    const uint32_t from_end = first + threadIdx.x;
    const uint32_t word = words - 1 - from_end;  // read where from_end < words only
    const uint32_t counts = from_end < words ? __ldg(leaving_bytes + word) : 0;
    const uint32_t count = SumOfBytes(counts);
    const uint32_t up_to = SumUpTo(count);
    if (Lane() == kWarp - 1) sums[threadIdx.x / kWarp] = up_to;
    __syncthreads();
    uint32_t before = 0;
    filled = 0;
    for (uint32_t w = 0; w < kThreads / kWarp; ++w) {
      if (w < threadIdx.x / kWarp) before += sums[w];
      filled += sums[w];
    }
    if (count > 0) {
      PutLeaving(leaving + word * size_t{kSymbolsAWord}, counts,
                 WordSink(bytes, before + up_to - count));
    }
    __syncthreads();
    packer.Copy(reinterpret_cast<const uint8_t*>(bytes), filled);
    __syncthreads();
  }
}

__device__ void PackSymbols(const DracoWork& work, uint32_t chunk, bool normals, Packer& packer) {
  const Part part(work, chunk, normals);
  const DracoStream& stream = part.stream;
  const size_t at = StreamAt(work, chunk, normals);
  if (part.plain) {
    const uint32_t width = PlainSymbolBytes(stream.largest);
    packer.Word(kPlain | width << 8, 2);
    packer.PlainSymbols(work.symbols + at, part.symbols, width);
    return;
  }
  packer.Word(kCoded | kSchemeRaw << 8 | uint32_t{stream.bit_length} << 16, 3);
  packer.Copy(work.tables + size_t{stream.first_entry} * kTableBytes, stream.table_bytes);
  packer.Varint(stream.coded_bytes);
  const uint32_t last_bytes = LastBytes(stream.last_word);
  if (RansPrecision(stream.bit_length) == kLeastRansPrecision) {
    PackLeaving(work.leaving + at, work.leaving_bytes + at / kSymbolsAWord, part.symbols, packer);
  } else {
    packer.Copy(reinterpret_cast<const uint8_t*>(work.leaving + at),
                stream.coded_bytes - last_bytes);
  }
  packer.Word(stream.last_word, last_bytes);
}

__global__ void __launch_bounds__(kThreads)
    PackKernel(const __grid_constant__ Arguments arguments) {
  const uint32_t chunk = blockIdx.x;
  const DracoPlace place = arguments.places[chunk];
  if (place.size == 0) return;
  const DracoFrame& frame = arguments.frame;
  const DracoFrame::Head& head = HeadOf(arguments, chunk);
  Packer packer(arguments.out + place.at);
  packer.Copy(head.bytes, head.size);
  PackSymbols(arguments.work, chunk, false, packer);
  const DracoStream& positions = arguments.work.streams[2 * chunk];
  packer.Word(positions.least | static_cast<uint64_t>(positions.most) << 32, 2 * sizeof(int32_t));
  if (arguments.work.normal_bits > 0) {
    packer.Copy(frame.normal_prediction, sizeof(frame.normal_prediction));
    PackSymbols(arguments.work, chunk, true, packer);
  }
  packer.Copy(frame.end, frame.end_size);
  packer.Zeros(arguments.out + place.at + RoundUpTo16(place.size));
}

}  // namespace

cudaError_t LaunchDracoPlaces(const DracoWork& work, const DracoFrame& frame, DracoPlace* places,
                              cudaStream_t stream) {
  if (work.count == 0) return cudaSuccess;
  PlacesKernel<<<1, kPlaceThreads, 0, stream>>>(Arguments{work, frame, places, nullptr});
  return cudaPeekAtLastError();
}

cudaError_t LaunchDracoPack(const DracoWork& work, const DracoFrame& frame,
                            const DracoPlace* places, uint8_t* out, cudaStream_t stream) {
  if (work.count == 0) return cudaSuccess;
  // The kernel reads places only.
  PackKernel<<<work.count, kThreads, 0, stream>>>(
      Arguments{work, frame, const_cast<DracoPlace*>(places), out});
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
