// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates R and its Jacobian at points of a run, 16 at a time, whichever patches they belong to.
// Included once per instruction set by adaptive_kernel.cc.
#if defined(LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_
#undef LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_
#else
#define LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_
#endif

#include "core/cpu/adaptive/kernel/adaptive_kernel.h"
#include "core/cpu/fused/kernel/fused_point-inl.h"
#include "core/cpu/fused/kernel/fused_vertices-inl.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

template <int D0, int D1, int D2, NormalMode kNormals>
class RunKernel {
  using DI = hn::RebindToSigned<D>;
  using VI = hn::Vec<DI>;
  static constexpr bool kHasNormals = kNormals != NormalMode::kNone;

 public:
  RunKernel(RunArguments& arguments, GroupArguments& output, size_t lane)
      : args_(arguments), lane_(lane), vertices_(output, lane, hn::Set(D(), 1.0f)) {}

  void Run() {
    for (size_t vector = 0; vector < args_.scratch.points; ++vector) Evaluate(vector);
  }

 private:
  // Entries of the point's corners a, b, c in the rows of an axis, and its place between them.
  struct Place {
    VI a, b, c;
    V along, up;
  };

  HWY_INLINE Place Load(size_t vector) const {
    const DI di;
    const size_t i = vector * kLanes + lane_;
    const VI patch = hn::LoadU(di, args_.points.patch + i);
    const VI code = hn::LoadU(di, args_.points.code + i);
    const auto entry = [&](VI corner) HWY_ATTR {
      const VI row = hn::And(corner, hn::Set(di, 3));
      return hn::Add(hn::Mul(row, hn::Set(di, int32_t{kRunPatches})), patch);
    };
    return {entry(code), entry(hn::ShiftRight<2>(code)), entry(hn::ShiftRight<4>(code)),
            hn::LoadU(D(), args_.points.along + i), hn::LoadU(D(), args_.points.up + i)};
  }

  // m + along d + up (c - m)
  static HWY_INLINE V Between(const float* rows, const Place& place) {
    const V va = hn::GatherIndex(D(), rows, place.a), vb = hn::GatherIndex(D(), rows, place.b);
    const V vc = hn::GatherIndex(D(), rows, place.c);
    const V middle = hn::Mul(hn::Set(D(), 0.5f), hn::Add(va, vb));
    const V on_edge = hn::MulAdd(hn::Sub(vb, va), place.along, middle);
    return hn::MulAdd(hn::Sub(vc, middle), place.up, on_edge);
  }

  HWY_NOINLINE void Evaluate(size_t vector) {
    const Place place = Load(vector);
    V l[3];
    for (size_t a = 0; a < 3; ++a) {
      l[a] = Between(args_.patches->corners[a][0].data(), place);
    }
    V jet[3][kHasNormals ? 4 : 1];
    for (int c = 0; c < 3; ++c) {
      EvaluatePoint<D0, D1, D2, kHasNormals>(*args_.box, l, c, jet[c]);
      vertices_.Store(static_cast<size_t>(c), vector, jet[c][0]);
    }
    if constexpr (kHasNormals) {
      vertices_.StoreNormal(
          CofactorTimes(jet, Conormal(0, place), Conormal(1, place), Conormal(2, place)), vector);
    }
  }

  HWY_INLINE V Conormal(size_t axis, const Place& place) const {
    const float* rows = args_.patches->conormals[axis][0].data();
    if constexpr (kNormals == NormalMode::kSmooth) {
      return Between(rows, place);
    } else {
      const VI patch = hn::And(place.a, hn::Set(DI(), int32_t{kRunPatches - 1}));
      return hn::GatherIndex(D(), rows, patch);
    }
  }

  RunArguments& args_;
  const size_t lane_;
  GroupVertices vertices_;
};

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_
