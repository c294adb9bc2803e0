// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A warp writes the bytes of a block of 256 vertices, one byte of the vertices after the other.
#ifndef LATTICED_CUDA_MESHOPT_MESHOPT_BLOCK_CUH_
#define LATTICED_CUDA_MESHOPT_MESHOPT_BLOCK_CUH_

#include <cstdint>

#include "core/codec/meshopt/meshopt_format.h"
#include "cuda/meshopt/meshopt_differences.h"
#include "cuda/meshopt/meshopt_numbers.cuh"

namespace latticed::kernels {

__device__ __forceinline__ bool IsFirstOfGroup() { return Lane() % kGroupLanes == 0; }

// The ways to code this lane's group of a byte of the vertices, which has differences other than 0. Marks are those of the
// lane's own differences.
struct MeshoptChoices {
  uint32_t marks_1, marks_2, marks_4;  // of those that do not fit in so many bits
  // How many the group's other lane marks, if it comes first: a byte for each of the above.
  uint32_t marked_before;
  uint32_t few, few_bytes, many, many_bytes;  // by control: the place in kGroupBits, and the bytes
};

// Called by all lanes. `used`: the lane's group has vertices.
__device__ __forceinline__ MeshoptChoices ChoicesOf(EightBytes differences, bool used) {
  MeshoptChoices its;
  its.marks_1 = MarkFrom(differences, 1);
  its.marks_2 = MarkFrom(differences, 3);
  its.marks_4 = MarkFrom(differences, 15);
  const auto count = [](uint32_t marks) { return static_cast<uint32_t>(__popc(marks)); };
  const uint32_t mine = count(its.marks_1) | count(its.marks_2) << 8 | count(its.marks_4) << 16;
  const uint32_t others = __shfl_xor_sync(kAllLanes, mine, 1);
  its.marked_before = IsFirstOfGroup() ? 0 : others;
  const uint32_t marked = mine + others;
  const uint32_t bytes_1 = 2 + (marked & 0xff), bytes_2 = 4 + (marked >> 8 & 0xff),
                 bytes_4 = 8 + (marked >> 16);
  const uint32_t least = min(bytes_1, min(bytes_2, bytes_4));
  const uint32_t place = bytes_1 == least ? 0 : bytes_2 == least ? 1 : 2;
  const bool zeros = (marked & 0xff) == 0;
  its.few = zeros ? 0 : place + 1;
  its.few_bytes = zeros ? 0 : least;
  its.many = least <= meshopt_format::kGroupVertices ? place : 3;
  its.many_bytes = used ? min(least, meshopt_format::kGroupVertices) : 0;
  return its;
}

// Writes the bytes of a block, one byte of its vertices after the other. All lanes call it together.
class MeshoptBlock {
 public:
  // `out`: shared memory. `count`: the vertices of the block.
  __device__ MeshoptBlock(uint8_t* out, uint32_t count)
      : out_(out), count_(count), groups_(meshopt_format::Groups(count)) {}

  // `differences`: the lane's, of one byte of the vertices. Bytes are put in ascending order.
  __device__ __forceinline__ void Put(uint32_t byte, EightBytes differences) {
    if (!__any_sync(kAllLanes, (differences.lower | differences.upper) != 0)) {
      return PutZeros(byte);
    }
    const MeshoptChoices choices = ChoicesOf(differences, Lane() / kGroupLanes < groups_);
    const uint32_t sums = __reduce_add_sync(
        kAllLanes, IsFirstOfGroup() ? choices.few_bytes | choices.many_bytes << 16 : 0);
    const uint32_t header_bytes = meshopt_format::GroupHeaderBytes(groups_);
    const uint32_t few = (sums & 0xffff) + header_bytes, many = (sums >> 16) + header_bytes;
    uint8_t* const out = out_ + at_;
    if (count_ <= min(few, many)) {
      controls_ |= uint32_t{meshopt_format::kPlain} << (2 * byte);
      at_ += count_;
      const uint32_t first = Lane() * kLaneVertices;
      return PutBytes(differences, min(kLaneVertices, count_ - min(first, count_)), out + first);
    }
    const bool is_few = few <= many;
    controls_ |= uint32_t{is_few ? meshopt_format::kFewBits : meshopt_format::kManyBits}
                 << (2 * byte);
    at_ += min(few, many);
    PutGroup(differences, choices, is_few, out);
  }
  // All differences of this byte are 0.
  __device__ void PutZeros(uint32_t byte) {
    controls_ |= uint32_t{meshopt_format::kZeros} << (2 * byte);
  }

  // Returns the bytes of the block. They are complete when the warp has passed a barrier.
  __device__ uint32_t Finish() {
    if (Lane() < meshopt_format::kChannels) {
      out_[Lane()] = static_cast<uint8_t>(controls_ >> (8 * Lane()));
    }
    return at_;
  }

 private:
  // Writes the header of all groups, and this lane's half of its group.
  __device__ __forceinline__ void PutGroup(EightBytes differences, const MeshoptChoices& choices,
                                           bool is_few, uint8_t* out) const {
    const uint32_t place = is_few ? choices.few : choices.many;
    const uint32_t bytes = is_few ? choices.few_bytes : choices.many_bytes;
    const uint32_t bits = is_few ? 1u << place >> 1 : 1u << place;  // kGroupBits
    const uint32_t up_to = SumUpTo(IsFirstOfGroup() ? bytes : 0);
    // The first lane of a group votes the lower bit of its place, and the second one the upper bit.
    const uint32_t half = Lane() % kGroupLanes;
    const uint32_t header = __ballot_sync(kAllLanes, (place >> half & 1) != 0);
    const uint32_t header_bytes = meshopt_format::GroupHeaderBytes(groups_);
    if (Lane() < header_bytes) out[Lane()] = static_cast<uint8_t>(header >> (8 * Lane()));
    if (bytes == 0) return;
    uint8_t* const its = out + header_bytes + up_to - bytes;
    const uint32_t marks = bits == 1   ? choices.marks_1
                           : bits == 2 ? choices.marks_2
                           : bits == 4 ? choices.marks_4
                                       : 0;
    EightBytes codes = differences;
    if (bits == 1) codes.lower = OneBitEach(marks);
    if (bits == 2) codes.lower = TwoBitsEach(differences, marks);
    if (bits == 4) codes.lower = FourBitsEach(differences, marks);
    PutBytes(codes, bits, its + half * bits);
    const uint32_t before = choices.marked_before >> (bits == 1 ? 0 : bits == 2 ? 8 : 16) & 0xff;
    PutMarked(differences, marks, its + 2 * bits + before);
  }

  static __device__ __forceinline__ uint8_t ByteOf(EightBytes bytes, uint32_t k) {
    return static_cast<uint8_t>((k < 4 ? bytes.lower : bytes.upper) >> (8 * (k % 4)));
  }
  static __device__ __forceinline__ void PutBytes(EightBytes bytes, uint32_t count, uint8_t* out) {
    constexpr uint32_t kUsual = kLaneVertices / 2;
#pragma unroll
    for (uint32_t k = 0; k < kUsual; ++k) {
      if (k < count) out[k] = ByteOf(bytes, k);
    }
    if (count <= kUsual) return;
#pragma unroll
    for (uint32_t k = kUsual; k < kLaneVertices; ++k) {
      if (k < count) out[k] = ByteOf(bytes, k);
    }
  }
  static __device__ __forceinline__ void PutMarked(EightBytes bytes, uint32_t marks, uint8_t* out) {
    if (marks == 0) return;
#pragma unroll
    for (uint32_t k = 0; k < kLaneVertices; ++k) {
      if ((marks & MarkOf(k)) != 0) *out++ = ByteOf(bytes, k);
    }
  }

  uint8_t* out_;
  uint32_t count_, groups_;
  uint32_t at_ = meshopt_format::kChannels;  // of the next byte
  uint32_t controls_ = 0;
};

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_MESHOPT_MESHOPT_BLOCK_CUH_
