// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Evaluates R and its Jacobian at points of a run, 16 at a time, whichever patches they belong to. With weights the box has
// the polynomial of the offset, and points and slopes are those of fused_weights-inl.h.
// Included once per instruction set by adaptive_kernel.cc and weighted_run_kernel.cc.
#if defined(LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_
#undef LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_
#else
#define LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_
#endif

#include "core/cpu/adaptive/kernel/adaptive_kernel.h"
#include "core/cpu/fused/kernel/fused_point-inl.h"
#include "core/cpu/fused/kernel/fused_vertices-inl.h"
#include "core/cpu/fused/kernel/fused_weights-inl.h"

HWY_BEFORE_NAMESPACE();
namespace latticed::fused {
namespace HWY_NAMESPACE {

template <int D0, int D1, int D2, NormalMode kNormals, bool kWeighted = false>
class RunKernel {
  using DI = hn::RebindToSigned<D>;
  using VI = hn::Vec<DI>;
  static constexpr bool kHasNormals = kNormals != NormalMode::kNone;

 public:
  RunKernel(RunArguments& arguments, GroupArguments& output, size_t lane)
      : args_(arguments),
        output_(output),
        lane_(lane),
        vertices_(output, lane, hn::Set(D(), 1.0f)) {}

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
    V rest[3];
    if constexpr (kWeighted) RestAt(*args_.box, l, rest);
    V jet[3][kHasNormals ? 4 : 1];
    for (int c = 0; c < 3; ++c) {
      EvaluatePoint<D0, D1, D2, kHasNormals>(*args_.box, l, c, jet[c]);
      if constexpr (kWeighted) Weigh(place, static_cast<size_t>(c), rest, jet[c]);
      vertices_.Store(static_cast<size_t>(c), vector, jet[c][0]);
    }
    if constexpr (kHasNormals) {
      const V3 carried =
          CofactorTimes(jet, Conormal(0, place), Conormal(1, place), Conormal(2, place));
      if constexpr (kWeighted) {
        GroupVertices(output_, lane_, hn::Set(D(), 1.0f), CofactorBound(place))
            .StoreNormal(carried, vector);
      } else {
        vertices_.StoreNormal(carried, vector);
      }
    }
  }

  // The entry of the point's patch in a row that has one for each patch.
  static HWY_INLINE V OfPatch(const RunPatches::Row& row, const Place& place) {
    const VI patch = hn::And(place.a, hn::Set(DI(), int32_t{kRunPatches - 1}));
    return hn::GatherIndex(D(), row.data(), patch);
  }

  // Turns the jet of the offset's component c into that of the position.
  HWY_INLINE void Weigh(const Place& place, size_t c, const V* rest, V* jet) const {
    const RunWeights& weights = *args_.weights;
    const V offset = jet[0], weight = Between(weights.weight[0].data(), place);
    jet[0] = hn::MulAdd(weight, offset, rest[c]);
    if constexpr (kHasNormals) {
      for (size_t l = 0; l < 3; ++l) {
        const V slope = hn::MulAdd(OfPatch(weights.by_local[l], place), offset,
                                   hn::Set(D(), args_.box->rest[1 + l][c]));
        jet[3 - l] = hn::MulAdd(weight, jet[3 - l], slope);
      }
    }
  }

  // As Weights::CofactorBound.
  HWY_INLINE V CofactorBound(const Place& place) const {
    const D d;
    const V norm =
        hn::MulAdd(OfPatch(args_.weights->steepness, place), hn::Set(d, args_.box->offset_bound),
                   hn::Set(d, 1.7320508f + args_.box->slope_bound));
    return hn::Mul(hn::Set(d, 0.5f), hn::Mul(norm, norm));
  }

  HWY_INLINE V Conormal(size_t axis, const Place& place) const {
    const auto& rows = args_.patches->conormals[axis];
    if constexpr (kNormals == NormalMode::kSmooth) {
      return Between(rows[0].data(), place);
    } else {
      return OfPatch(rows[0], place);
    }
  }

  RunArguments& args_;
  GroupArguments& output_;
  const size_t lane_;
  GroupVertices vertices_;
};

template <int D0, int D1, int D2, bool kWeighted>
class RunInstance {
 public:
  static void Run(RunArguments& arguments) {
    switch (arguments.normals) {
      case NormalMode::kNone:
        return RunOf<NormalMode::kNone>(arguments);
      case NormalMode::kFacet:
        return RunOf<NormalMode::kFacet>(arguments);
      case NormalMode::kSmooth:
        return RunOf<NormalMode::kSmooth>(arguments);
    }
  }

 private:
  template <NormalMode kNormals>
  static void RunOf(RunArguments& arguments) {
    GroupArguments output{};
    output.box = arguments.box;
    output.scratch = arguments.scratch;
    output.weak = arguments.weak;
    for (size_t lane = 0; lane < kLanes; lane += hn::Lanes(D())) {
      RunKernel<D0, D1, D2, kNormals, kWeighted>(arguments, output, lane).Run();
    }
    arguments.weak_count = output.weak_count;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace latticed::fused
HWY_AFTER_NAMESPACE();

#endif  // LATTICED_CORE_CPU_ADAPTIVE_KERNEL_ADAPTIVE_RUN_INL_H_
