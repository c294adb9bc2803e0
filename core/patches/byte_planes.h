// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Arrays of unsigned integers in byte planes: the lowest bytes of all numbers, then the next bytes of all numbers, and
// so on. Bytes of one plane are alike, so that they compress well.
//
// Threads  pure functions
#ifndef LATTICED_CORE_PATCHES_BYTE_PLANES_H_
#define LATTICED_CORE_PATCHES_BYTE_PLANES_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace latticed {

// A difference of two uint32 below 2^31: 2 d, or -2 d - 1 if d < 0.
constexpr uint32_t EncodeDifference(uint32_t from, uint32_t to) {
  return to >= from ? 2 * (to - from) : 2 * (from - to) - 1;
}
constexpr uint32_t DecodeDifference(uint32_t from, uint32_t code) {
  return code % 2 == 0 ? from + code / 2 : from - code / 2 - 1;
}

template <typename T>
void AppendBytePlanes(std::span<const T> numbers, std::string* bytes) {
  for (size_t plane = 0; plane < sizeof(T); ++plane) {
    for (const T number : numbers)
      bytes->push_back(static_cast<char>(number >> (8 * plane) & 0xFF));
  }
}

// Number `index` of an array of `count`; `bytes` begins with the array.
template <typename T>
T BytePlanesNumber(std::string_view bytes, size_t count, size_t index) {
  T number = 0;
  for (size_t plane = 0; plane < sizeof(T); ++plane) {
    const auto byte = static_cast<uint8_t>(bytes[plane * count + index]);
    number = static_cast<T>(number | static_cast<T>(byte) << (8 * plane));
  }
  return number;
}

}  // namespace latticed

#endif  // LATTICED_CORE_PATCHES_BYTE_PLANES_H_
