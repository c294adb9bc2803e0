// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compiled once per instruction set (AVX-512, AVX2, and the compiler's baseline); Highway picks one at run time.
#include "core/points/normal_kernel.h"

#include "core/ffd/carried_normal.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/points/normal_kernel.cc"
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// Highway requires these includes to follow foreach_target.
#include "core/points/lane_vectors-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::points {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using namespace lanes;  // NOLINT(google-build-using-namespace)

struct Columns {
  V3 a, b, c;
};

// d/d(x, y, z) from d/d(l, m, n).
HWY_INLINE Columns ToWorld(const LocalMap& map, const BlockSlopes& slopes, size_t i) {
  const D d;
  Columns columns{Zero3(), Zero3(), Zero3()};
  for (size_t axis = 0; axis < 3; ++axis) {
    const V3 slope = Load3(slopes[axis], i);
    columns.a = AddTimes(hn::Set(d, map.scale[axis].x), slope, columns.a);
    columns.b = AddTimes(hn::Set(d, map.scale[axis].y), slope, columns.b);
    columns.c = AddTimes(hn::Set(d, map.scale[axis].z), slope, columns.c);
  }
  return columns;
}

HWY_INLINE Columns LoadColumns(const BlockNormals& normals, size_t i) {
  return {Load3(normals.jacobian[0], i), Load3(normals.jacobian[1], i),
          Load3(normals.jacobian[2], i)};
}

// What of v changes the direction; zero where the normal is undefined. This map is its own transpose.
HWY_INLINE V3 Along(const BlockNormals& normals, V3 v, size_t i) {
  const V3 n = Load3(normals.value, i);
  const V inverse = hn::LoadU(D(), normals.inverse_length.data() + i);
  return Times(inverse, AddTimes(hn::Neg(Dot(n, v)), n, v));
}

// Zero in the lanes from `count` on.
HWY_INLINE V LoadUpTo(const double* values, size_t count) {
  const D d;
  if (count >= hn::Lanes(d)) return hn::LoadU(d, values);
  HWY_ALIGN double some[hn::MaxLanes(D())] = {};
  for (size_t i = 0; i < count; ++i) some[i] = values[i];
  return hn::Load(d, some);
}

void MakeNormalsImpl(const LocalMap& map, const BlockSlopes& slopes,
                     const std::array<const double*, 3>& rest, size_t count,
                     BlockNormals& normals) {
  const D d;
  const V largest2 = hn::Set(d, kMaxNormalCondition * kMaxNormalCondition);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Columns j = ToWorld(map, slopes, i);
    const V3 n{LoadUpTo(rest[0] + i, count - i), LoadUpTo(rest[1] + i, count - i),
               LoadUpTo(rest[2] + i, count - i)};
    const V3 x = Cross(j.b, j.c), y = Cross(j.c, j.a), z = Cross(j.a, j.b);
    const V3 carried = AddTimes(n.x, x, AddTimes(n.y, y, Times(n.z, z)));
    // The rules of CarryNormal, squared: this saves most of its roots and quotients.
    const V cofactor2 = hn::Add(Dot(x, x), hn::Add(Dot(y, y), Dot(z, z)));
    const V length2 = Dot(carried, carried);
    const V size2 = hn::Add(Dot(j.a, j.a), hn::Add(Dot(j.b, j.b), Dot(j.c, j.c)));
    const V rank = hn::Mul(hn::Set(d, kRankTolerance), size2);
    const auto defined =
        hn::And(hn::Le(cofactor2, hn::Mul(largest2, length2)),
                hn::And(hn::Gt(length2, hn::Zero(d)), hn::Gt(cofactor2, hn::Mul(rank, rank))));
    const V inverse = hn::IfThenElseZero(defined, hn::Div(hn::Set(d, 1.0), hn::Sqrt(length2)));
    hn::StoreU(inverse, d, normals.inverse_length.data() + i);
    Store3(n, normals.rest, i);
    Store3({hn::IfThenElseZero(defined, hn::Mul(inverse, carried.x)),
            hn::IfThenElseZero(defined, hn::Mul(inverse, carried.y)),
            hn::IfThenElseZero(defined, hn::Mul(inverse, carried.z))},
           normals.value, i);
    Store3(j.a, normals.jacobian[0], i);
    Store3(j.b, normals.jacobian[1], i);
    Store3(j.c, normals.jacobian[2], i);
  }
}

void NormalVelocitiesImpl(const LocalMap& map, const BlockNormals& normals,
                          const BlockSlopes& rates, size_t count, BlockVec& velocities) {
  for (size_t i = 0; i < count; i += hn::Lanes(D())) {
    const Columns j = LoadColumns(normals, i), rate = ToWorld(map, rates, i);
    const V3 n = Load3(normals.rest, i);
    const V3 by_x = Sum(Cross(rate.b, j.c), Cross(j.b, rate.c));
    const V3 by_y = Sum(Cross(rate.c, j.a), Cross(j.c, rate.a));
    const V3 by_z = Sum(Cross(rate.a, j.b), Cross(j.a, rate.b));
    const V3 carried = AddTimes(n.x, by_x, AddTimes(n.y, by_y, Times(n.z, by_z)));
    Store3(Along(normals, carried, i), velocities, i);
  }
}

void NormalCotangentsImpl(const LocalMap& map, const BlockNormals& normals,
                          const BlockVec& cotangents, size_t count, BlockSlopes& slopes) {
  const D d;
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const Columns j = LoadColumns(normals, i);
    const V3 n = Load3(normals.rest, i), h = Along(normals, Load3(cotangents, i), i);
    const V3 ha = Cross(h, j.a), hb = Cross(h, j.b), hc = Cross(h, j.c);
    const V3 by_a = AddTimes(n.y, hc, Times(hn::Neg(n.z), hb));
    const V3 by_b = AddTimes(n.z, ha, Times(hn::Neg(n.x), hc));
    const V3 by_c = AddTimes(n.x, hb, Times(hn::Neg(n.y), ha));
    for (size_t axis = 0; axis < 3; ++axis) {
      const Vec3d& scale = map.scale[axis];
      Store3(AddTimes(hn::Set(d, scale.x), by_a,
                      AddTimes(hn::Set(d, scale.y), by_b, Times(hn::Set(d, scale.z), by_c))),
             slopes[axis], i);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace latticed::points
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace latticed::points {

HWY_EXPORT(MakeNormalsImpl);
HWY_EXPORT(NormalVelocitiesImpl);
HWY_EXPORT(NormalCotangentsImpl);

void MakeNormals(const LocalMap& map, const BlockSlopes& slopes,
                 const std::array<const double*, 3>& rest, size_t count, BlockNormals& normals) {
  HWY_DYNAMIC_DISPATCH(MakeNormalsImpl)(map, slopes, rest, count, normals);
}

void NormalVelocities(const LocalMap& map, const BlockNormals& normals, const BlockSlopes& rates,
                      size_t count, BlockVec& velocities) {
  HWY_DYNAMIC_DISPATCH(NormalVelocitiesImpl)(map, normals, rates, count, velocities);
}

void NormalCotangents(const LocalMap& map, const BlockNormals& normals, const BlockVec& cotangents,
                      size_t count, BlockSlopes& slopes) {
  HWY_DYNAMIC_DISPATCH(NormalCotangentsImpl)(map, normals, cotangents, count, slopes);
}

}  // namespace latticed::points
#endif  // HWY_ONCE
