// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/patch_point_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/measure/patch_point_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway requires this include to follow foreach_target.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::patch_points {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

struct V3 {
  V x, y, z;
};
HWY_INLINE V LoadAt(const BlockArray& from, size_t i) { return hn::LoadU(D(), from.data() + i); }
HWY_INLINE V3 LoadAt(const BlockVec& from, size_t i) {
  return {LoadAt(from[0], i), LoadAt(from[1], i), LoadAt(from[2], i)};
}
HWY_INLINE void StoreAt(V v, BlockArray& to, size_t i) { hn::StoreU(v, D(), to.data() + i); }
HWY_INLINE void StoreAt(const V3& v, BlockVec& to, size_t i) {
  StoreAt(v.x, to[0], i);
  StoreAt(v.y, to[1], i);
  StoreAt(v.z, to[2], i);
}
HWY_INLINE V3 Subtract(const V3& a, const V3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE V3 Scale(V f, const V3& a) {
  return {hn::Mul(f, a.x), hn::Mul(f, a.y), hn::Mul(f, a.z)};
}
HWY_INLINE V3 ScaleAdd(V f, const V3& a, const V3& b) {
  return {hn::MulAdd(f, a.x, b.x), hn::MulAdd(f, a.y, b.y), hn::MulAdd(f, a.z, b.z)};
}
HWY_INLINE V DotOf(const V3& a, const V3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE V3 CrossOf(const V3& a, const V3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}

struct Rows {
  V3 row[3];

  HWY_INLINE explicit Rows(const LocalMap& map) {
    const D d;
    for (size_t a = 0; a < 3; ++a) {
      row[a] = {hn::Set(d, map.scale[a].x), hn::Set(d, map.scale[a].y), hn::Set(d, map.scale[a].z)};
    }
  }
};

void AddMovesImpl(const LocalMap& map, const Jet& rest, const BlockVec& values,
                  const BlockSlopes& slopes, size_t count, Jet& moves) {
  const Rows rows(map);
  const V one = hn::Set(D(), 1.0);
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 move = Subtract(LoadAt(values, i), LoadAt(rest[0], i));
    StoreAt(ScaleAdd(one, move, LoadAt(moves[0], i)), moves[0], i);
    const V3 by_l = LoadAt(slopes[0], i), by_m = LoadAt(slopes[1], i), by_n = LoadAt(slopes[2], i);
    for (size_t k = 1; k < 3; ++k) {
      const V3 along = LoadAt(rest[k], i);
      V3 slope = Scale(DotOf(rows.row[0], along), by_l);
      slope = ScaleAdd(DotOf(rows.row[1], along), by_m, slope);
      slope = ScaleAdd(DotOf(rows.row[2], along), by_n, slope);
      StoreAt(ScaleAdd(one, Subtract(slope, along), LoadAt(moves[k], i)), moves[k], i);
    }
  }
}

void WeighImpl(const Jet& rest, const ScalarJet& weight, const Jet& moves, size_t count,
               Jet& points) {
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V w = LoadAt(weight[0], i);
    const V3 move = LoadAt(moves[0], i);
    StoreAt(ScaleAdd(w, move, LoadAt(rest[0], i)), points[0], i);
    for (size_t k = 1; k < 3; ++k) {
      const V3 slope = ScaleAdd(w, LoadAt(moves[k], i), LoadAt(rest[k], i));
      StoreAt(ScaleAdd(LoadAt(weight[k], i), move, slope), points[k], i);
    }
  }
}

void VolumeForcesImpl(const Jet& points, const BlockArray& weight, const BlockArray& h,
                      size_t count, BlockVec& force, BlockArray& across) {
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 directed = Scale(LoadAt(h, i), CrossOf(LoadAt(points[1], i), LoadAt(points[2], i)));
    StoreAt(Scale(LoadAt(weight, i), directed), force, i);
    StoreAt(DotOf(LoadAt(points[0], i), directed), across, i);
  }
}

void AreaLengthsImpl(const Jet& points, size_t count, BlockArray& length) {
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 normal = CrossOf(LoadAt(points[1], i), LoadAt(points[2], i));
    StoreAt(hn::Sqrt(DotOf(normal, normal)), length, i);
  }
}

void AreaForcesImpl(const Jet& points, const ScalarJet& weight, const BlockArray& h, size_t count,
                    Jet& forces) {
  const V zero = hn::Zero(D());
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 s = LoadAt(points[1], i), t = LoadAt(points[2], i);
    const V3 normal = CrossOf(s, t);
    const V length = hn::Sqrt(DotOf(normal, normal));
    const auto has_direction = hn::Gt(length, zero);
    const V factor = hn::IfThenElseZero(has_direction, hn::Div(LoadAt(h, i), length));
    const V3 unit = Scale(factor, normal);
    const V3 by_s = CrossOf(t, unit), by_t = CrossOf(unit, s);
    const V w = LoadAt(weight[0], i);
    StoreAt(ScaleAdd(LoadAt(weight[1], i), by_s, Scale(LoadAt(weight[2], i), by_t)), forces[0], i);
    StoreAt(Scale(w, by_s), forces[1], i);
    StoreAt(Scale(w, by_t), forces[2], i);
  }
}

void SlopeForcesImpl(const LocalMap& map, const Jet& rest, const Jet& forces, size_t count,
                     BlockSlopes& by_local) {
  const Rows rows(map);
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 s = LoadAt(rest[1], i), t = LoadAt(rest[2], i);
    const V3 by_s = LoadAt(forces[1], i), by_t = LoadAt(forces[2], i);
    for (size_t a = 0; a < 3; ++a) {
      StoreAt(ScaleAdd(DotOf(rows.row[a], s), by_s, Scale(DotOf(rows.row[a], t), by_t)),
              by_local[a], i);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::patch_points
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::patch_points {

HWY_EXPORT(AddMovesImpl);
HWY_EXPORT(WeighImpl);
HWY_EXPORT(VolumeForcesImpl);
HWY_EXPORT(AreaLengthsImpl);
HWY_EXPORT(AreaForcesImpl);
HWY_EXPORT(SlopeForcesImpl);

void AddMoves(const LocalMap& map, const Jet& rest, const BlockVec& values,
              const BlockSlopes& slopes, size_t count, Jet& moves) {
  HWY_DYNAMIC_DISPATCH(AddMovesImpl)(map, rest, values, slopes, count, moves);
}
void Weigh(const Jet& rest, const ScalarJet& weight, const Jet& moves, size_t count, Jet& points) {
  HWY_DYNAMIC_DISPATCH(WeighImpl)(rest, weight, moves, count, points);
}
void VolumeForces(const Jet& points, const BlockArray& weight, const BlockArray& h, size_t count,
                  BlockVec& force, BlockArray& across) {
  HWY_DYNAMIC_DISPATCH(VolumeForcesImpl)(points, weight, h, count, force, across);
}
void AreaLengths(const Jet& points, size_t count, BlockArray& length) {
  HWY_DYNAMIC_DISPATCH(AreaLengthsImpl)(points, count, length);
}
void AreaForces(const Jet& points, const ScalarJet& weight, const BlockArray& h, size_t count,
                Jet& forces) {
  HWY_DYNAMIC_DISPATCH(AreaForcesImpl)(points, weight, h, count, forces);
}
void SlopeForces(const LocalMap& map, const Jet& rest, const Jet& forces, size_t count,
                 BlockSlopes& by_local) {
  HWY_DYNAMIC_DISPATCH(SlopeForcesImpl)(map, rest, forces, count, by_local);
}

}  // namespace latticed::patch_points
#endif  // HWY_ONCE
