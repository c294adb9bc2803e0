// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the next place for each chunk's stream, and writes its bytes there, part by part:
//
//   head | positions | least, most | prediction of normals | normals | end
//
// positions and normals are a table and the bytes that left the state, or plain symbols when these are
// shorter; of sparse chunks also tags, coded in the same way, and the bits of the symbols, when these are shorter still.
#include "cuda/draco/draco_leaving.cuh"
#include "cuda/draco/draco_symbols.cuh"
#include "cuda/streams/stream_places.cuh"

namespace latticed::kernels {
namespace {

// Threads that pack a chunk. Of sparse chunks a multiprocessor holds twice as many then.
constexpr unsigned kUsualThreads = 128, kSparseThreads = 64;
// That a multiprocessor must hold at once; the compiler limits the registers to that.
constexpr unsigned kMultiprocessorThreads = 1792;
// Constants of the Draco format.
constexpr uint32_t kPlain = 0, kCoded = 1;

struct Arguments {
  DracoWork work;
  DracoFrame frame;
  StreamPlaces known;
  StreamRoom room;
};

__device__ uint32_t VarintBytes(uint32_t value) {
  uint32_t bytes = 1;
  for (; value >= 0x80; value >>= 7) ++bytes;
  return bytes;
}

// What a table, a length and the bytes that left the state take.
__device__ uint32_t CodedBytes(const DracoStream& stream) {
  return stream.table_bytes + VarintBytes(stream.coded_bytes) + stream.coded_bytes;
}

// The part of a chunk that holds an attribute's symbols.
struct Part {
  enum class Form { kPlain, kRaw, kTagged };
  DracoStream stream;  // of the symbols, or of their tags
  uint32_t symbols, size, width;
  Form form;

  __device__ Part(const DracoWork& work, uint32_t chunk, DracoKind kind)
      : stream(work.Stream(chunk, kind)),
        symbols(work.Points(chunk) * ValuesOf(kind)),
        size(3 + CodedBytes(stream)),
        width(PlainSymbolBytes(stream.largest)),
        form(Form::kRaw) {
    if (!stream.left_out && StorePlainly(size, symbols, stream.largest)) {
      form = Form::kPlain;
      size = 2 + symbols * width;
    }
    if (!work.sparse) return;
    const DracoStream& tags = work.Stream(chunk, TagsOf(kind));
    if (tags.left_out) return;
    const uint32_t tagged = 2 + CodedBytes(tags) + (tags.tagged_bits + 7) / 8;
    if (!stream.left_out && tagged >= size) return;
    form = Form::kTagged;
    size = tagged;
    stream = tags;
  }
};

__device__ const DracoFrame::Head& HeadOf(const Arguments& arguments, uint32_t chunk) {
  const DracoFrame& frame = arguments.frame;
  return frame.heads[arguments.work.Points(chunk) == frame.head_points ? 0 : 1];
}

// 0 for a chunk that was not coded.
__device__ uint32_t StreamBytes(const Arguments& arguments, uint32_t chunk) {
  const DracoWork& work = arguments.work;
  if (work.Stream(chunk, DracoKind::kPositions).skipped) return 0;
  const DracoFrame::Head& head = HeadOf(arguments, chunk);
  uint32_t size = head.size + Part(work, chunk, DracoKind::kPositions).size + 2 * sizeof(int32_t) +
                  arguments.frame.end_size;
  if (work.has_normals()) {
    size += sizeof(arguments.frame.normal_prediction) + Part(work, chunk, DracoKind::kNormals).size;
  }
  return max(size, head.least_stream);
}

// Appends bytes; all kThreads threads of the block call it together.
template <unsigned kThreads>
class Packer {
 public:
  __device__ explicit Packer(uint8_t* at) : at_(at) {}

  __device__ void Copy(const uint8_t* bytes, uint32_t count) {
    for (uint32_t i = threadIdx.x; i < count; i += kThreads) at_[i] = bytes[i];
    at_ += count;
  }
  // Without `points_at`, the bytes as they are; else `points` in four bytes there, the lowest first.
  __device__ void Head(const DracoFrame::Head& head, uint32_t points_at, uint32_t points) {
    for (uint32_t i = threadIdx.x; i < head.size; i += kThreads) {
      const uint32_t byte = i - points_at;  // far above 3 before points_at
      at_[i] = points_at > 0 && byte < sizeof(points) ? static_cast<uint8_t>(points >> (8 * byte))
                                                      : head.bytes[i];
    }
    at_ += head.size;
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
  __device__ uint8_t* at() const { return at_; }

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
    const uint32_t upper = BytesAt(counts, 2 * pair + 1) * 8;
    const uint32_t lower = BytesAt(counts, 2 * pair) * 8;
    sink.Put(both >> 16 & ((1u << upper) - 1), upper);
    sink.Put(both & ((1u << lower) - 1), lower);
    sink.Flush();
  }
  sink.Finish();
}

// Packs the bytes that left a state at 12 bits, sixteen symbols a thread, the last symbols first. They are
// put together in shared memory, so that they are written in whole cache lines.
template <unsigned kThreads>
__device__ void PackLeaving(const uint16_t* leaving, const uint32_t* leaving_bytes,
                            uint32_t symbols, Packer<kThreads>& packer) {
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

// Appends up to 48 bits to words of shared memory that were set to zero, from any bit on. Threads share words.
__device__ void PutBits(uint32_t* words, uint32_t at, uint64_t bits) {
  uint32_t* to = words + at / 32;
  const uint32_t shift = at % 32;
  atomicOr(to, static_cast<uint32_t>(bits << shift));
  const uint64_t rest = bits >> (32 - shift);
  if (rest == 0) return;
  atomicOr(to + 1, static_cast<uint32_t>(rest));
  if (rest >> 32 != 0) atomicOr(to + 2, static_cast<uint32_t>(rest >> 32));
}

// Packs the symbols of each point, in as many bits as its tag says, a point a thread.
template <unsigned kThreads>
__device__ void PackTagged(const uint16_t* symbols, uint32_t points, DracoKind kind,
                           Packer<kThreads>& packer) {
  constexpr uint32_t kMostBits = kPositionValues * (kTags - 1);
  __shared__ uint32_t words[kThreads * kMostBits / 32 + 3];
  __shared__ uint32_t sums[kThreads / kWarp];
  uint32_t held = 0, held_bits = 0;  // of the last byte of the points before
  for (uint32_t first = 0; first < points; first += kThreads) {
    for (uint32_t i = threadIdx.x; i < sizeof(words) / 4; i += kThreads)
      words[i] = i == 0 ? held : 0;
    const uint32_t i = first + threadIdx.x;
    uint64_t bits = 0;
    uint32_t count = 0;
    if (i < points) {
      const uint16_t* its = symbols + ValuesOf(kind) * i;
      uint32_t any = 1;
      for (uint32_t k = 0; k < ValuesOf(kind); ++k) any |= its[k];
      const uint32_t tag = HighestBit(any) + 1;
      for (uint32_t k = 0; k < ValuesOf(kind); ++k, count += tag) {
        bits |= uint64_t{its[k]} << count;
      }
    }
    const uint32_t up_to = SumUpTo(count);
    if (Lane() == kWarp - 1) sums[threadIdx.x / kWarp] = up_to;
    __syncthreads();
    uint32_t at = held_bits + up_to - count, end = held_bits;
    for (uint32_t w = 0; w < kThreads / kWarp; ++w) {
      if (w < threadIdx.x / kWarp) at += sums[w];
      end += sums[w];
    }
    PutBits(words, at, bits);
    __syncthreads();
    const bool last = first + kThreads >= points;
    packer.Copy(reinterpret_cast<const uint8_t*>(words), last ? (end + 7) / 8 : end / 8);
    held = words[end / 32] >> (end / 8 % 4 * 8) & 0xff;
    held_bits = end % 8;
    __syncthreads();
  }
}

// Packs a table, a length and the bytes that left the state. `at`: where the stream's words are.
template <unsigned kThreads>
__device__ void PackCoded(const DracoWork& work, const DracoStream& stream, uint32_t symbols,
                          size_t at, Packer<kThreads>& packer) {
  packer.Copy(work.tables + size_t{stream.first_entry} * kTableBytes, stream.table_bytes);
  packer.Varint(stream.coded_bytes);
  const uint32_t last_bytes = LastBytes(stream.last_word);
  if (RansPrecision(stream.bit_length) == kLeastRansPrecision) {
    PackLeaving(work.leaving + at, work.leaving_bytes + at / kSymbolsAWord, symbols, packer);
  } else {
    packer.Copy(reinterpret_cast<const uint8_t*>(work.leaving + at),
                stream.coded_bytes - last_bytes);
  }
  packer.Word(stream.last_word, last_bytes);
}

template <unsigned kThreads>
__device__ void PackSymbols(const DracoWork& work, uint32_t chunk, DracoKind kind,
                            Packer<kThreads>& packer) {
  const Part part(work, chunk, kind);
  const DracoStream& stream = part.stream;
  const size_t at = StreamAt(work, chunk, kind);
  switch (part.form) {
    case Part::Form::kPlain:
      packer.Word(kPlain | part.width << 8, 2);
      return packer.PlainSymbols(work.symbols + at, part.symbols, part.width);
    case Part::Form::kRaw:
      packer.Word(kCoded | kSchemeRaw << 8 | uint32_t{stream.bit_length} << 16, 3);
      return PackCoded(work, stream, part.symbols, at, packer);
    case Part::Form::kTagged:
      break;
  }
  const uint32_t points = work.Points(chunk);
  packer.Word(kCoded | kSchemeTagged << 8, 2);
  PackCoded(work, stream, points, StreamAt(work, chunk, TagsOf(kind)), packer);
  PackTagged(work.symbols + at, points, kind, packer);
}

template <unsigned kThreads>
__global__ void __launch_bounds__(kThreads, kMultiprocessorThreads / kThreads)
    PackKernel(const __grid_constant__ Arguments arguments) {
  const uint32_t chunk = blockIdx.x;
  const DracoWork& work = arguments.work;
  const StreamRoom& room = arguments.room;
  const StreamPlace place = FindPlace<kThreads>(work, arguments.known, room, chunk,
                                                [&] { return StreamBytes(arguments, chunk); });
  if (!MustWrite<kThreads>(place, room)) return;
  const DracoFrame& frame = arguments.frame;
  Packer<kThreads> packer(room.bytes + place.at);
  packer.Head(HeadOf(arguments, chunk), frame.points_at, work.Points(chunk));
  PackSymbols(work, chunk, DracoKind::kPositions, packer);
  const DracoStream& positions = work.Stream(chunk, DracoKind::kPositions);
  packer.Word(positions.least | static_cast<uint64_t>(positions.most) << 32, 2 * sizeof(int32_t));
  if (work.has_normals()) {
    packer.Copy(frame.normal_prediction, sizeof(frame.normal_prediction));
    PackSymbols(work, chunk, DracoKind::kNormals, packer);
  }
  packer.Copy(frame.end, frame.end_size);
  ZeroBytes<kThreads>(packer.at(), room.bytes + EndOf(place));
}

}  // namespace

cudaError_t LaunchDracoPack(const DracoWork& work, const DracoFrame& frame, StreamPlaces known,
                            const StreamRoom& room, cudaStream_t stream) {
  if (work.count == 0) return cudaSuccess;
  const Arguments arguments{work, frame, known, room};
  if (work.sparse) {
    PackKernel<kSparseThreads><<<work.count, kSparseThreads, 0, stream>>>(arguments);
  } else {
    PackKernel<kUsualThreads><<<work.count, kUsualThreads, 0, stream>>>(arguments);
  }
  return cudaPeekAtLastError();
}

}  // namespace latticed::kernels
