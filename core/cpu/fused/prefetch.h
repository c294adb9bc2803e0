// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Prefetch hints. An invalid address is no error.
#ifndef LATTICED_CORE_CPU_FUSED_PREFETCH_H_
#define LATTICED_CORE_CPU_FUSED_PREFETCH_H_

#include <cstddef>
#include <cstdint>

namespace latticed {

inline constexpr size_t kCacheLine = 64;

inline void PrefetchToRead(const void* bytes, size_t size) {
  for (size_t at = 0; at < size; at += kCacheLine) {
    __builtin_prefetch(static_cast<const uint8_t*>(bytes) + at, 0);
  }
}
// Fetches the lines for writing, so that stores do not wait for them.
inline void PrefetchToWrite(const void* bytes, size_t size) {
  for (size_t at = 0; at < size; at += kCacheLine) {
    __builtin_prefetch(static_cast<const uint8_t*>(bytes) + at, 1);
  }
}

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_FUSED_PREFETCH_H_
