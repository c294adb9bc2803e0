// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The polynomials of a plan's boxes and their bounds in device memory, one block of floats:
//
//   coefficients as BoxPolynomials has them | with weights: points at rest, bounds of lengths | bounds of cofactors
//
// Errors   those of device_buffer.h
// Threads  one at a time; Create enqueues on the stream and does not wait
#ifndef LATTICED_CUDA_FUSED_POLYNOMIAL_MEMORY_H_
#define LATTICED_CUDA_FUSED_POLYNOMIAL_MEMORY_H_

#include <utility>

#include "core/ffd/plan/deform_plan.h"
#include "cuda/device/device_buffer.h"
#include "cuda/fused/fused_kernels.h"

namespace latticed {

class PolynomialMemory {
 public:
  static uint64_t BytesFor(const DeformPlan& plan);
  [[nodiscard]] static absl::StatusOr<PolynomialMemory> Create(const DeformPlan& plan,
                                                               DeviceReservation& from,
                                                               cudaStream_t stream);

  kernels::BoxPolynomials polynomials(double scale, Vec3d offset) const;
  size_t size_bytes() const { return floats_.size_bytes(); }

 private:
  PolynomialMemory(const DeformPlan& plan, DeviceBuffer<float> floats);

  size_t boxes_, coefficients_;
  bool weighted_;
  DeviceBuffer<float> floats_;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_FUSED_POLYNOMIAL_MEMORY_H_
