// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where each chunk's stream lies among all, and its bytes there, part by part:
//
//   head | positions | least, most | prediction of normals | normals | end
//
// positions and normals are a table with the states' bytes, or plain symbols where these take less.
#include "cuda/draco_table.cuh"

namespace latticed::kernels {
namespace {

constexpr unsigned kThreads = 128;        // that pack a chunk
constexpr unsigned kPlaceThreads = 1024;  // that add up sizes
// Numbers of the format.
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

// 0 where the chunk was deferred.
__device__ uint32_t StreamBytes(const Arguments& arguments, uint32_t chunk) {
  const Part positions(arguments.work, chunk, false);
  if (positions.stream.deferred != 0) return 0;
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

// Appends bytes by all threads of the block.
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

__device__ void PackSymbols(const DracoWork& work, uint32_t chunk, bool normals, Packer& packer) {
  const Part part(work, chunk, normals);
  if (part.plain) {
    const uint32_t width = PlainSymbolBytes(part.stream.largest);
    packer.Word(kPlain | width << 8, 2);
    packer.PlainSymbols(SymbolsOf(work, chunk, normals), part.symbols, width);
    return;
  }
  const uint8_t* coded = CodedOf(work, chunk, normals);
  packer.Word(kCoded | kSchemeRaw << 8 | uint32_t{part.stream.bit_length} << 16, 3);
  packer.Copy(coded, part.stream.table_bytes);
  packer.Varint(part.stream.coded_bytes);
  packer.Copy(coded + StatesAt(part.stream.table_bytes), part.stream.coded_bytes);
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
  packer.Zeros(arguments.out + place.at + place.size);
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
