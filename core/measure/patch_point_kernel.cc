// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/measure/patch_point_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/measure/patch_point_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway requires these includes to follow foreach_target.
#include "core/points/lane_vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::patch_points {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using namespace points::HWY_NAMESPACE::lanes;  // NOLINT(google-build-using-namespace)

HWY_INLINE V LoadAt(const BlockArray& from, size_t i) { return hn::LoadU(D(), from.data() + i); }
HWY_INLINE V3 LoadAt(const BlockVec& from, size_t i) { return Load3(from, i); }
HWY_INLINE void StoreAt(V v, BlockArray& to, size_t i) { hn::StoreU(v, D(), to.data() + i); }
HWY_INLINE void StoreAt(const V3& v, BlockVec& to, size_t i) { Store3(v, to, i); }

struct Rows {
  V3 row[3];

  HWY_INLINE explicit Rows(const LocalMap& map) {
    for (size_t a = 0; a < 3; ++a) {
      row[a] = Set3(map.scale[a].x, map.scale[a].y, map.scale[a].z);
    }
  }
};

void AddMovesImpl(const LocalMap& map, const Jet& rest, const BlockVec& values,
                  const BlockSlopes& slopes, size_t count, Jet& moves) {
  const Rows rows(map);
  const V one = hn::Set(D(), 1.0);
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 move = Difference(LoadAt(values, i), LoadAt(rest[0], i));
    StoreAt(AddTimes(one, move, LoadAt(moves[0], i)), moves[0], i);
    const V3 by_l = LoadAt(slopes[0], i), by_m = LoadAt(slopes[1], i), by_n = LoadAt(slopes[2], i);
    for (size_t k = 1; k < 3; ++k) {
      const V3 along = LoadAt(rest[k], i);
      V3 slope = Times(Dot(rows.row[0], along), by_l);
      slope = AddTimes(Dot(rows.row[1], along), by_m, slope);
      slope = AddTimes(Dot(rows.row[2], along), by_n, slope);
      StoreAt(AddTimes(one, Difference(slope, along), LoadAt(moves[k], i)), moves[k], i);
    }
  }
}

void WeighImpl(const Jet& rest, const ScalarJet& weight, const Jet& moves, size_t count,
               Jet& points) {
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V w = LoadAt(weight[0], i);
    const V3 move = LoadAt(moves[0], i);
    StoreAt(AddTimes(w, move, LoadAt(rest[0], i)), points[0], i);
    for (size_t k = 1; k < 3; ++k) {
      const V3 slope = AddTimes(w, LoadAt(moves[k], i), LoadAt(rest[k], i));
      StoreAt(AddTimes(LoadAt(weight[k], i), move, slope), points[k], i);
    }
  }
}

void VolumeForcesImpl(const Jet& points, const BlockArray& weight, const BlockArray& h,
                      size_t count, BlockVec& force, BlockArray& across) {
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 directed = Times(LoadAt(h, i), Cross(LoadAt(points[1], i), LoadAt(points[2], i)));
    StoreAt(Times(LoadAt(weight, i), directed), force, i);
    StoreAt(Dot(LoadAt(points[0], i), directed), across, i);
  }
}

void AreaLengthsImpl(const Jet& points, size_t count, BlockArray& length) {
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 normal = Cross(LoadAt(points[1], i), LoadAt(points[2], i));
    StoreAt(hn::Sqrt(Dot(normal, normal)), length, i);
  }
}

void AreaForcesImpl(const Jet& points, const ScalarJet& weight, const BlockArray& h, size_t count,
                    Jet& forces) {
  const V zero = hn::Zero(D());
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 s = LoadAt(points[1], i), t = LoadAt(points[2], i);
    const V3 normal = Cross(s, t);
    const V length = hn::Sqrt(Dot(normal, normal));
    const auto has_direction = hn::Gt(length, zero);
    const V factor = hn::IfThenElseZero(has_direction, hn::Div(LoadAt(h, i), length));
    const V3 unit = Times(factor, normal);
    const V3 by_s = Cross(t, unit), by_t = Cross(unit, s);
    const V w = LoadAt(weight[0], i);
    StoreAt(AddTimes(LoadAt(weight[1], i), by_s, Times(LoadAt(weight[2], i), by_t)), forces[0], i);
    StoreAt(Times(w, by_s), forces[1], i);
    StoreAt(Times(w, by_t), forces[2], i);
  }
}

void SlopeForcesImpl(const LocalMap& map, const Jet& rest, const Jet& forces, size_t count,
                     BlockSlopes& by_local) {
  const Rows rows(map);
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const V3 s = LoadAt(rest[1], i), t = LoadAt(rest[2], i);
    const V3 by_s = LoadAt(forces[1], i), by_t = LoadAt(forces[2], i);
    for (size_t a = 0; a < 3; ++a) {
      StoreAt(AddTimes(Dot(rows.row[a], s), by_s, Times(Dot(rows.row[a], t), by_t)), by_local[a],
              i);
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
