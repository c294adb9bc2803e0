// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/base/blas_environment.h"

#include <unistd.h>

#include <cstdlib>
#include <string>

namespace latticed {
namespace {

constexpr char kVariable[] = "OPENBLAS_CORETYPE";

}  // namespace

std::string_view BlasCoreType() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    return "SKYLAKEX";
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "HASWELL";
#endif
  return "";
}

void EnsureBlasEnvironment(char** argv) {
  const std::string core_type(BlasCoreType());
  if (core_type.empty() || std::getenv(kVariable) != nullptr) return;
  if (setenv(kVariable, core_type.c_str(), 0) != 0) return;
  execv("/proc/self/exe", argv);  // returns only if it failed
}

}  // namespace latticed
