// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Treats denormal numbers as zero on this thread, read or written, until the scope ends. High
// powers of small patches contain many of them, far below the resolution of any view, and Intel's
// processors take a hundred cycles for each.
#ifndef LATTICED_CORE_CPU_FLUSH_DENORMALS_H_
#define LATTICED_CORE_CPU_FLUSH_DENORMALS_H_

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace latticed {

class FlushDenormals {
 public:
#if defined(__x86_64__)
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | kFlushToZero | kAreZero); }
  ~FlushDenormals() { _mm_setcsr(before_); }
#else
  FlushDenormals() {}  // others compute with them at full speed
  ~FlushDenormals() {}
#endif
  FlushDenormals(const FlushDenormals&) = delete;  // a copy would restore twice
  FlushDenormals& operator=(const FlushDenormals&) = delete;

#if defined(__x86_64__)
 private:
  static constexpr unsigned kFlushToZero = 0x8000, kAreZero = 0x0040;
  const unsigned before_;
#endif
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_FLUSH_DENORMALS_H_
