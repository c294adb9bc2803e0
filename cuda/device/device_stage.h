// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The stage matrices of degree n and s segments on the device (core/ffd/stage_matrices.h), with the
// sample points and the tessellation pattern as kernels read them.
//
// Errors   those of StageMatrices::Get and device_buffer.h
// Threads  immutable; usable on every stream once it is made
#ifndef LATTICED_CUDA_DEVICE_DEVICE_STAGE_H_
#define LATTICED_CUDA_DEVICE_DEVICE_STAGE_H_

#include <memory>

#include "core/ffd/stage_matrices.h"
#include "cuda/device/cuda_device.h"
#include "cuda/device/device_buffer.h"

namespace latticed {

class DeviceStage {
 public:
  // Takes DeviceBytesFor from the reservation. Waits for the stream.
  [[nodiscard]] static absl::StatusOr<std::shared_ptr<const DeviceStage>> Create(
      int degree, int segments, DeviceReservation& from, const CudaStream& stream);
  static uint64_t DeviceBytesFor(int degree, int segments);

  int degree() const { return host_->degree; }
  int segments() const { return host_->segments; }
  size_t m() const { return host_->m; }
  size_t q() const { return host_->q; }
  const uchar4* samples() const { return samples_; }  // m
  const uchar4* pattern() const { return pattern_; }  // q
  DeviceMatrix<const float> stack() const { return Stack(stack_); }
  DeviceMatrix<const float> bernstein_f() const { return Stack(bernstein_f_); }
  DeviceMatrix<const double> bernstein() const { return Stack(bernstein_); }
  DeviceMatrix<const double> inverse() const { return {inverse_, m(), m(), m()}; }
  size_t MemoryBytes() const { return block_.size_bytes(); }

 private:
  explicit DeviceStage(const StageMatrices* host) : host_(host) {}
  template <typename T>
  DeviceMatrix<const T> Stack(const T* data) const {
    return {data, 3 * q(), m(), 3 * q()};
  }

  const StageMatrices* host_;    // lives until the process ends
  DeviceBuffer<uint8_t> block_;  // holds the tables below
  const uchar4 *samples_ = nullptr, *pattern_ = nullptr;
  const float *stack_ = nullptr, *bernstein_f_ = nullptr;
  const double *bernstein_ = nullptr, *inverse_ = nullptr;
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_DEVICE_STAGE_H_
