// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// From the differences of a block's bytes to its vertices.
// Included once per instruction set by meshopt_kernel.cc.
#if defined(LATTICED_CLIENT_DECODER_MESHOPT_VERTICES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CLIENT_DECODER_MESHOPT_VERTICES_INL_H_
#undef LATTICED_CLIENT_DECODER_MESHOPT_VERTICES_INL_H_
#else
#define LATTICED_CLIENT_DECODER_MESHOPT_VERTICES_INL_H_
#endif

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "client/decoder/meshopt/meshopt_kernel.h"
#include "core/codec/meshopt/meshopt_format.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::decoder::meshopt_kernel {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using meshopt_format::kBlockVertices;
using meshopt_format::kVertexBytes;

// The differences of a block, by byte of a vertex.
struct alignas(16) BlockDifferences {
  uint8_t bytes[kVertexBytes][kBlockVertices];
};

#if HWY_TARGET == HWY_SCALAR

class VertexSum {
 public:
  explicit VertexSum(const Blocks& blocks) : byte_differences_(blocks.byte_differences) {
    std::copy_n(blocks.before, kNumbers, sum_);
    std::fill_n(least_, kNumbers, uint16_t{0xffff});
  }

  // Adds the differences of the block's `count` vertices one after the other, and writes the sums.
  void Write(const BlockDifferences& differences, uint32_t count, uint16_t* out, bool /*is_last*/) {
    for (uint32_t i = 0; i < count; ++i) {
      for (uint32_t c = 0; c < kNumbers; ++c, ++out) {
        const uint32_t zigzag =
            differences.bytes[2 * c][i] | uint32_t{differences.bytes[2 * c + 1][i]} << 8;
        sum_[c] = static_cast<uint16_t>(sum_[c] + (zigzag >> 1 ^ (0 - (zigzag & 1))));
        if (c > 3 && byte_differences_) sum_[c] &= 0xff;
        least_[c] = std::min(least_[c], sum_[c]);
        most_[c] = std::max(most_[c], sum_[c]);
        *out = sum_[c];
      }
    }
  }
  void Finish(Blocks& blocks) const {
    std::copy_n(least_, kNumbers, blocks.least);
    std::copy_n(most_, kNumbers, blocks.most);
  }

 private:
  const bool byte_differences_;
  uint16_t sum_[kNumbers], least_[kNumbers], most_[kNumbers] = {};
};

#else

// The vertex before the next one, in the lanes x y z 0 s t, and the least and most of all so far.
class VertexSum {
  static constexpr size_t kVertices = 8;  // that are turned at once
  using D = hn::FixedTag<uint16_t, kVertices>;
  using V = hn::Vec<D>;

 public:
  explicit VertexSum(const Blocks& blocks) : sum_(Load(blocks.before)) {
    const uint16_t normal = blocks.byte_differences ? 0xff : 0xffff;
    const uint16_t mask[kNumbers] = {0xffff, 0xffff, 0xffff, 0xffff, normal, normal};
    mask_ = Load(mask);
  }

  void Write(const BlockDifferences& differences, uint32_t count, uint16_t* out, bool is_last) {
    V vertices[kVertices];
    for (uint32_t i = 0; i < count; i += kVertices, out += kVertices * kNumbers) {
      Turn(differences, i, vertices);
      // A vertex is stored with four bytes more, which the next one replaces. The last of all has no next one.
      uint16_t ends[kVertices * kNumbers + 2];
      const uint32_t left = count - i;
      const bool ends_here = is_last && left <= kVertices;
      uint16_t* const to = ends_here ? ends : out;
      for (uint32_t k = 0; k < kVertices && k < left; ++k) {
        Add(vertices[k]);
        hn::StoreU(sum_, D(), to + k * kNumbers);
      }
      if (ends_here) std::memcpy(out, ends, left * kVertexBytes);
    }
  }
  void Finish(Blocks& blocks) const {
    Store(least_, blocks.least);
    Store(most_, blocks.most);
  }

 private:
  static V Load(const uint16_t (&numbers)[kNumbers]) {
    HWY_ALIGN uint16_t lanes[kVertices] = {};
    std::copy_n(numbers, kNumbers, lanes);
    return hn::Load(D(), lanes);
  }
  static void Store(V v, uint16_t (&numbers)[kNumbers]) {
    HWY_ALIGN uint16_t lanes[kVertices];
    hn::Store(v, D(), lanes);
    std::copy_n(lanes, kNumbers, numbers);
  }

  // Eight differences of a number.
  static HWY_INLINE V Number(const BlockDifferences& differences, uint32_t number, uint32_t first) {
    const D d;
    const hn::FixedTag<uint8_t, 16> d8;
    const hn::FixedTag<uint8_t, 8> half;
    const auto lower = hn::LoadU(half, differences.bytes[2 * number] + first);
    const auto upper = hn::LoadU(half, differences.bytes[2 * number + 1] + first);
    const V zigzag = hn::BitCast(d, hn::InterleaveLower(d8, hn::ZeroExtendVector(d8, lower),
                                                        hn::ZeroExtendVector(d8, upper)));
    const V sign = hn::Sub(hn::Zero(d), hn::And(zigzag, hn::Set(d, uint16_t{1})));
    return hn::Xor(hn::ShiftRight<1>(zigzag), sign);
  }

  // From numbers of eight vertices to vertices.
  static HWY_INLINE void Turn(const BlockDifferences& differences, uint32_t first,
                              V (&vertices)[kVertices]) {
    const D d;
    const hn::FixedTag<uint32_t, 4> d32;
    const hn::FixedTag<uint64_t, 2> d64;
    const V zero = hn::Zero(d);
    const V x = Number(differences, 0, first), y = Number(differences, 1, first),
            z = Number(differences, 2, first), s = Number(differences, 4, first),
            t = Number(differences, 5, first);
    const auto turn_four = [&](auto xy, auto z0, auto st, V* four) {
      const auto no = hn::Zero(d32);
      const auto p01 = hn::BitCast(d64, hn::InterleaveLower(d32, xy, z0)),
                 p23 = hn::BitCast(d64, hn::InterleaveUpper(d32, xy, z0)),
                 n01 = hn::BitCast(d64, hn::InterleaveLower(d32, st, no)),
                 n23 = hn::BitCast(d64, hn::InterleaveUpper(d32, st, no));
      four[0] = hn::BitCast(d, hn::InterleaveLower(d64, p01, n01));
      four[1] = hn::BitCast(d, hn::InterleaveUpper(d64, p01, n01));
      four[2] = hn::BitCast(d, hn::InterleaveLower(d64, p23, n23));
      four[3] = hn::BitCast(d, hn::InterleaveUpper(d64, p23, n23));
    };
    turn_four(hn::BitCast(d32, hn::InterleaveLower(d, x, y)),
              hn::BitCast(d32, hn::InterleaveLower(d, z, zero)),
              hn::BitCast(d32, hn::InterleaveLower(d, s, t)), vertices);
    turn_four(hn::BitCast(d32, hn::InterleaveUpper(d, x, y)),
              hn::BitCast(d32, hn::InterleaveUpper(d, z, zero)),
              hn::BitCast(d32, hn::InterleaveUpper(d, s, t)), vertices + 4);
  }

  HWY_INLINE void Add(V difference) {
    sum_ = hn::And(hn::Add(sum_, difference), mask_);
    least_ = hn::Min(least_, sum_);
    most_ = hn::Max(most_, sum_);
  }

  V sum_, mask_ = hn::Zero(D()), least_ = hn::Set(D(), uint16_t{0xffff}), most_ = hn::Zero(D());
};

#endif

}  // namespace HWY_NAMESPACE
}  // namespace latticed::decoder::meshopt_kernel
HWY_AFTER_NAMESPACE();

#endif
