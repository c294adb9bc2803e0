// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/fused/polynomial_memory.h"

#include <array>

namespace latticed {
namespace {

size_t CoefficientCount(const DeformPlan& plan) {
  const std::array<int, 3>& d = plan.structure.degree;  // in any order
  return plan.boxes.size() * 3 * static_cast<size_t>(kernels::CoefficientStride(d[0], d[1], d[2]));
}

// A box at rest: three components of four numbers.
constexpr size_t kRestFloats = 12;

size_t FloatCount(const DeformPlan& plan) {
  return CoefficientCount(plan) + plan.boxes.size() * (plan.is_weighted() ? kRestFloats + 2 : 1);
}

}  // namespace

uint64_t PolynomialMemory::BytesFor(const DeformPlan& plan) {
  return FloatCount(plan) * sizeof(float);
}

absl::StatusOr<PolynomialMemory> PolynomialMemory::Create(const DeformPlan& plan,
                                                          DeviceReservation& from,
                                                          cudaStream_t stream) {
  LATTICED_ASSIGN_OR_RETURN(
      auto floats, DeviceBuffer<float>::Create(from, "box_polynomials", FloatCount(plan), stream));
  return PolynomialMemory(plan, std::move(floats));
}

PolynomialMemory::PolynomialMemory(const DeformPlan& plan, DeviceBuffer<float> floats)
    : boxes_(plan.boxes.size()),
      coefficients_(CoefficientCount(plan)),
      weighted_(plan.is_weighted()),
      floats_(std::move(floats)) {}

kernels::BoxPolynomials PolynomialMemory::polynomials(double scale, Vec3d offset) const {
  float* const next = floats_.data() + coefficients_;
  float* const lengths = next + kRestFloats * boxes_;
  return {.scale = scale,
          .offset = offset,
          .coefficients = floats_.data(),
          .rest = weighted_ ? next : nullptr,
          .cofactor_bounds = weighted_ ? lengths + boxes_ : next,
          .length_bounds = weighted_ ? lengths : nullptr};
}

}  // namespace latticed
