// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views of device memory: what std::span and MatrixView are for the host's. The type says where the
// bytes are; nothing here may be read on the host.
#ifndef LATTICED_CUDA_DEVICE_DEVICE_SPAN_H_
#define LATTICED_CUDA_DEVICE_DEVICE_SPAN_H_

#include <cstddef>

namespace latticed {

template <typename T>
struct DeviceSpan {
  T* data = nullptr;
  size_t size = 0;

  // Implicit, as from a span of T to one of const T.
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

  // `count` rows from `first` on.
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
