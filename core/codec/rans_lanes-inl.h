// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// RansEncoder for 16 streams side by side, a chunk in each lane, with positions and normals in turns. One stream is a
// chain of dependent steps; the other streams use the time in which it waits.
//
// At most two bytes leave the state in a step. They are collected in a word of each lane, which is stored after two
// steps at the latest.
// Included once per instruction set by draco_kernel.cc.
#if defined(LATTICED_CORE_CODEC_RANS_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CODEC_RANS_LANES_INL_H_
#undef LATTICED_CORE_CODEC_RANS_LANES_INL_H_
#else
#define LATTICED_CORE_CODEC_RANS_LANES_INL_H_
#endif

#include "core/codec/draco_kernel.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::draco_kernel {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using DI32 = hn::CappedTag<int32_t, kLanes>;
using DF32 = hn::RebindToFloat<DI32>;
using DU32 = hn::RebindToUnsigned<DI32>;
using VI32 = hn::Vec<DI32>;

// The lanes of one vector.
class LaneCoder {
 public:
  HWY_INLINE LaneCoder(const LaneStreams& streams, size_t first_lane)
      : streams_(streams), first_lane_(first_lane) {
    const DI32 d;
    const VI32 lane = hn::Iota(d, static_cast<int32_t>(first_lane));
    symbols_at_ = hn::LoadU(d, streams.symbols_at + first_lane);
    entries_at_ = hn::LoadU(d, streams.entries_at + first_lane);
    out_at_ = hn::Mul(lane, hn::Set(d, static_cast<int32_t>(streams.out_stride)));
    const VI32 precision =
        hn::LoadU(d, reinterpret_cast<const int32_t*>(streams.precision) + first_lane);
    all_ = hn::Shl(hn::Set(d, 1), precision);
    state_ = hn::ShiftLeft<2>(all_);
    leaving_ = leaving_bits_ = hn::Zero(d);
  }

  // Symbols of the component at points 2 * pair and 2 * pair + 1, in the halves of words.
  HWY_INLINE VI32 SymbolPair(size_t component, size_t pair) const {
    const uint16_t* base = streams_.symbols + component * streams_.plane_stride + 2 * pair;
    return hn::GatherOffset(DI32(), reinterpret_cast<const int32_t*>(base), symbols_at_);
  }

  HWY_INLINE void Put(VI32 symbol) {
    const DI32 d;
    const DF32 df;
    const VI32 entry = hn::GatherIndex(d, reinterpret_cast<const int32_t*>(streams_.entries),
                                       hn::Add(entries_at_, symbol));
    const VI32 probability = hn::And(entry, hn::Set(d, 0xFFFF));
    const VI32 cumulative = hn::BitCast(d, hn::ShiftRight<16>(hn::BitCast(DU32(), entry)));
    const VI32 limit = hn::ShiftLeft<10>(probability), byte = hn::Set(d, 8);
    // Lanes in which no byte leaves, and lanes in which at most one does.
    const auto none = hn::Lt(state_, limit), one = hn::Lt(hn::ShiftRight<8>(state_), limit);
    const VI32 bits = hn::Add(hn::IfThenZeroElse(none, byte), hn::IfThenZeroElse(one, byte));
    const VI32 rest = hn::Shr(state_, bits);
    leaving_ = hn::Or(leaving_, hn::Shl(hn::Xor(state_, hn::Shl(rest, bits)), leaving_bits_));
    leaving_bits_ = hn::Add(leaving_bits_, bits);
    const VI32 quotient =
        hn::ConvertTo(d, hn::Div(hn::ConvertTo(df, rest), hn::ConvertTo(df, probability)));
    state_ = hn::Add(hn::Add(rest, cumulative), hn::Mul(quotient, hn::Sub(all_, probability)));
  }

  HWY_INLINE void Store() {
    const DI32 d;
    hn::ScatterOffset(leaving_, d, reinterpret_cast<int32_t*>(streams_.out), out_at_);
    out_at_ = hn::Add(out_at_, hn::ShiftRight<3>(leaving_bits_));
    leaving_ = leaving_bits_ = hn::Zero(d);
  }

  HWY_INLINE void Finish(LaneStreams& streams) const {
    const DI32 d;
    HWY_ALIGN int32_t out_at[hn::MaxLanes(d)];
    hn::Store(out_at_, d, out_at);
    hn::StoreU(state_, d, reinterpret_cast<int32_t*>(streams.state) + first_lane_);
    for (size_t i = 0; i < hn::Lanes(d); ++i) {
      const size_t lane = first_lane_ + i;
      streams.bytes[lane] =
          static_cast<uint32_t>(out_at[i]) - static_cast<uint32_t>(lane * streams.out_stride);
    }
  }

 private:
  const LaneStreams& streams_;
  size_t first_lane_;
  VI32 symbols_at_, entries_at_, out_at_;
  VI32 all_, state_, leaving_, leaving_bits_;
};

HWY_INLINE VI32 FirstOfPair(VI32 pair) { return hn::And(pair, hn::Set(DI32(), 0xFFFF)); }
HWY_INLINE VI32 SecondOfPair(VI32 pair) {
  return hn::BitCast(DI32(), hn::ShiftRight<16>(hn::BitCast(DU32(), pair)));
}

// The symbols of a pair of points in coding order, the last first: step 0 … 2 kComponents - 1.
template <size_t kComponents>
struct PairSteps {
  HWY_INLINE PairSteps(const LaneCoder& coder, size_t pair) {
    for (size_t c = 0; c < kComponents; ++c) {
      const VI32 symbols = coder.SymbolPair(c, pair);
      step[kComponents - 1 - c] = SecondOfPair(symbols);
      step[2 * kComponents - 1 - c] = FirstOfPair(symbols);
    }
  }
  VI32 step[2 * kComponents];
};

// Puts the last point of an odd number of points.
template <size_t kComponents>
HWY_INLINE void PutSingle(LaneCoder& coder, size_t pair) {
  const PairSteps<kComponents> steps(coder, pair);
  for (size_t i = kComponents; i < 2 * kComponents; ++i) {
    coder.Put(steps.step[i]);
    coder.Store();
  }
}

template <bool kNormals>
HWY_INLINE void CodeVector(size_t points, size_t lane, LaneStreams& positions,
                           LaneStreams* normals) {
  LaneCoder position(positions, lane), normal(kNormals ? *normals : positions, lane);
  if (points % 2 != 0) {
    PutSingle<3>(position, points / 2);
    if constexpr (kNormals) PutSingle<2>(normal, points / 2);
  }
  for (size_t pair = points / 2; pair-- > 0;) {
    const PairSteps<3> position_steps(position, pair);
    const PairSteps<2> normal_steps(normal, pair);
    for (size_t i = 0; i < 6; i += 2) {
      position.Put(position_steps.step[i]);
      if constexpr (kNormals) {
        if (i < 4) normal.Put(normal_steps.step[i]);
      }
      position.Put(position_steps.step[i + 1]);
      position.Store();
      if constexpr (kNormals) {
        if (i < 4) {
          normal.Put(normal_steps.step[i + 1]);
          normal.Store();
        }
      }
    }
  }
  position.Finish(positions);
  if constexpr (kNormals) normal.Finish(*normals);
}

void CodeLanesImpl(size_t points, LaneStreams& positions, LaneStreams* normals) {
  for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(DI32())) {
    if (normals == nullptr) {
      CodeVector<false>(points, lane, positions, normals);
    } else {
      CodeVector<true>(points, lane, positions, normals);
    }
  }
}

bool HasLanesImpl() { return hn::MaxLanes(DI32()) >= 8; }

}  // namespace HWY_NAMESPACE
}  // namespace latticed::draco_kernel
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CODEC_RANS_LANES_INL_H_
