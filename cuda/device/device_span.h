// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views of device memory, as std::span and MatrixView are views of host memory. The type says where
// the bytes are. Host code must not read them.
#ifndef LATTICED_CUDA_DEVICE_DEVICE_SPAN_H_
#define LATTICED_CUDA_DEVICE_DEVICE_SPAN_H_

#include <cstddef>

namespace latticed {

template <typename T>
struct DeviceSpan {
  T* data = nullptr;
  size_t size = 0;

  // Implicit, as the conversion of std::span<T> to std::span<const T>.
  // NOLINTNEXTLINE(google-explicit-constructor)
  operator DeviceSpan<const T>() const { return {data, size}; }
};

// Column-major: element (r, c) is data[r + c * stride].
template <typename T>
struct DeviceMatrix {
  T* data = nullptr;
  size_t rows = 0;
  size_t columns = 0;
  size_t stride = 0;

  // Rows first … first + count - 1.
  DeviceMatrix Rows(size_t first, size_t count) const {
    return {data + first, count, columns, stride};
  }
  DeviceMatrix Columns(size_t first, size_t count) const {
    return {data + first * stride, rows, count, stride};
  }
  // Implicit, as above.
  // NOLINTNEXTLINE(google-explicit-constructor)
  operator DeviceMatrix<const T>() const { return {data, rows, columns, stride}; }
};

}  // namespace latticed

#endif  // LATTICED_CUDA_DEVICE_DEVICE_SPAN_H_
