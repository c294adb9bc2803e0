// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Stores rows of lanes as vertices in wire layout. It transposes four rows at a time: it interleaves them
// into 16-byte pieces, one per lane, and copies the pieces to the lanes' patches.
// Included once per instruction set by fused_kernel.cc.
#if defined(LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_STORE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_STORE_INL_H_
#undef LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_STORE_INL_H_
#else
#define LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_STORE_INL_H_
#endif

#include <cstring>

#include "core/base/limits.h"
#include "core/cpu/fused/kernel/fused_quantise-inl.h"
#include "core/ffd/tessellation_pattern.h"
#include "hwy/cache_control.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

// Interleaves rows[0..3] (each kLanes values of 4 bytes): 16 bytes per lane, at pieces + 16 lane.
template <class T>
HWY_INLINE void InterleaveRows(const T* const rows[4], uint8_t* pieces) {
  const hn::CappedTag<T, kLanes> d;
  for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(d)) {
    hn::StoreInterleaved4(hn::Load(d, rows[0] + lane), hn::Load(d, rows[1] + lane),
                          hn::Load(d, rows[2] + lane), hn::Load(d, rows[3] + lane), d,
                          reinterpret_cast<T*>(pieces) + 4 * lane);
  }
}

// Copies at most 15 bytes without a call into the C library.
HWY_INLINE void CopyTail(uint8_t* to, const uint8_t* from, size_t bytes) {
  size_t done = 0;
  if (bytes & 8) std::memcpy(to, from, 8), done = 8;
  if (bytes & 4) std::memcpy(to + done, from + done, 4), done += 4;
  if (bytes & 2) std::memcpy(to + done, from + done, 2), done += 2;
  if (bytes & 1) to[done] = from[done];
}

// Copies `rows` rows of 4-byte words to the lanes: word r of lane l to destination[l] + 4 r, but no
// more than `bytes` per lane.
template <class T, class RowAt>
HWY_INLINE void StoreTransposed(size_t rows, size_t bytes, size_t lanes, const RowAt& row_at,
                                uint8_t* const* destination) {
  HWY_ALIGN uint8_t pieces[16 * kLanes];
  for (size_t r = 0; r < rows; r += 4) {
    const T* four[4];
    for (size_t i = 0; i < 4; ++i) four[i] = row_at(r + i < rows ? r + i : rows - 1);
    InterleaveRows<T>(four, pieces);
    const size_t offset = 4 * r;
    if (offset + 16 <= bytes && lanes == kLanes) {  // nearly always: unrolled
      for (size_t l = 0; l < kLanes; ++l) {
        std::memcpy(destination[l] + offset, pieces + 16 * l, 16);
      }
    } else if (offset + 16 <= bytes) {
      for (size_t l = 0; l < lanes; ++l) std::memcpy(destination[l] + offset, pieces + 16 * l, 16);
    } else {
      for (size_t l = 0; l < lanes; ++l) {
        CopyTail(destination[l] + offset, pieces + 16 * l, bytes - offset);
      }
    }
  }
}

constexpr size_t kMaxPoints = static_cast<size_t>(PointsPerPatch(limits::kMaxSegments));

// Planes of one group, consecutive points packed into words of 32 bits, little endian.
struct alignas(64) WordScratch {
  int32_t words[2][(kMaxPoints + 1) / 2 * kLanes];
};

HWY_INLINE void StorePlane(const int32_t* words, size_t points, size_t per_word, size_t lanes,
                           uint8_t* const* destination) {
  StoreTransposed<int32_t>((points + per_word - 1) / per_word, points * (4 / per_word), lanes,
                           [&](size_t r) HWY_ATTR { return words + r * kLanes; }, destination);
}

HWY_INLINE void PackPositions(const QuantiseArguments& a, size_t component, int32_t* words) {
  const DF df;
  const DI di;
  const size_t points = a.scratch.points;
  const VI top = hn::Set(di, (1 << a.position_bits) - 1);
  const VF scale = hn::Set(df, a.scale[component]), offset = hn::Set(df, a.offset[component]);
  for (size_t point = 0; point < points; point += 2, words += kLanes) {
    const float* first = a.scratch.Row(component, point);
    const float* second = point + 1 < points ? first + kLanes : first;
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(df)) {
      const VI low = QuantisePosition(hn::Load(df, first + lane), scale, offset, top);
      const VI high = QuantisePosition(hn::Load(df, second + lane), scale, offset, top);
      hn::Store(hn::Or(low, hn::ShiftLeft<16>(high)), di, words + lane);
    }
  }
}

// s and t of kPerWord points in each word: 4 of 8 bits or 2 of 16.
template <size_t kPerWord>
HWY_INLINE void PackNormals(const QuantiseArguments& a, int32_t* s_words, int32_t* t_words) {
  const DF df;
  const DI di;
  constexpr int kBits = 32 / kPerWord;
  const size_t points = a.scratch.points;
  for (size_t point = 0; point < points; point += kPerWord, s_words += kLanes, t_words += kLanes) {
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(df)) {
      VI s_word = hn::Zero(di), t_word = s_word;
      // Runs backwards, so that each step shifts the word by a constant.
      for (size_t i = kPerWord; i-- > 0;) {
        const size_t p = point + i < points ? point + i : points - 1;
        VI s, t;
        QuantiseNormalLanes(hn::Load(df, a.scratch.Row(3, p) + lane),
                            hn::Load(df, a.scratch.Row(4, p) + lane),
                            hn::Load(df, a.scratch.Row(5, p) + lane), a.normal_bits, s, t);
        s_word = hn::Or(hn::ShiftLeft<kBits>(s_word), s);
        t_word = hn::Or(hn::ShiftLeft<kBits>(t_word), t);
      }
      hn::Store(s_word, di, s_words + lane);
      hn::Store(t_word, di, t_words + lane);
    }
  }
}

void StoreQuantisedImpl(const QuantiseArguments& a) {
  static thread_local WordScratch scratch;
  const size_t points = a.scratch.points;
  uint8_t* destination[kLanes] = {};
  const auto aim = [&](size_t plane) HWY_ATTR {
    for (size_t l = 0; l < a.lanes; ++l) destination[l] = a.destination[l][plane];
  };
  for (size_t c = 0; c < 3; ++c) {
    PackPositions(a, c, scratch.words[0]);
    aim(c);
    StorePlane(scratch.words[0], points, 2, a.lanes, destination);
  }
  if (a.normal_bits == 0) return;
  const size_t per_word = a.normal_bits <= 8 ? 4 : 2;
  if (per_word == 4) {
    PackNormals<4>(a, scratch.words[0], scratch.words[1]);
  } else {
    PackNormals<2>(a, scratch.words[0], scratch.words[1]);
  }
  for (size_t plane = 0; plane < 2; ++plane) {
    aim(3 + plane);
    StorePlane(scratch.words[plane], points, per_word, a.lanes, destination);
  }
}

void StoreFloatsImpl(const GroupScratch& scratch, size_t components, size_t lanes,
                     const std::array<float*, kLanes>& destination) {
  uint8_t* bytes[kLanes];
  for (size_t l = 0; l < lanes; ++l) bytes[l] = reinterpret_cast<uint8_t*>(destination[l]);
  const size_t rows = scratch.points * components;
  StoreTransposed<float>(
      rows, rows * sizeof(float), lanes,
      [&](size_t r) HWY_ATTR { return scratch.Row(r % components, r / components); }, bytes);
}

// Uses streaming stores: the vertices are not read soon, and whole cache lines are written.
void StoreLaneOrderImpl(const GroupScratch& scratch, size_t components, float* to) {
  const DF d;
  for (size_t point = 0; point < scratch.points; ++point) {
    for (size_t c = 0; c < components; ++c) {
      const float* row = scratch.Row(c, point);
      for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(d), to += hn::Lanes(d)) {
        hn::Stream(hn::Load(d, row + lane), d, to);
      }
    }
  }
  hwy::FlushStream();
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_FUSED_KERNEL_FUSED_STORE_INL_H_
