// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/gemm/cpu_gemm.h"

#include <cblas.h>
#include <dlfcn.h>
#include <stdlib.h>

#include "absl/status/statusor.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// The value of OPENBLAS_CORETYPE for this processor, or null for OpenBLAS's own choice.
const char* CoreType() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    return "SKYLAKEX";
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "HASWELL";
#endif
  return nullptr;
}

// Runs before main, while the program has one thread: setenv races with getenv in other threads.
[[maybe_unused]] const bool environment_is_set = [] {
  if (const char* core_type = CoreType()) setenv("OPENBLAS_CORETYPE", core_type, 0);
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  return true;
}();

struct OpenBlas {
  decltype(&cblas_sgemm) sgemm = nullptr;
  decltype(&cblas_dgemm) dgemm = nullptr;
  decltype(&openblas_get_corename) get_corename = nullptr;
  std::string config;  // the library writes it anew with each call, for all threads at one place
};

absl::StatusOr<OpenBlas> LoadOpenBlas() {
  void* const library = dlopen("libopenblas.so.0", RTLD_NOW | RTLD_LOCAL);  // never closed
  OpenBlas blas;
  if (library != nullptr) {
    blas.sgemm = reinterpret_cast<decltype(blas.sgemm)>(dlsym(library, "cblas_sgemm"));
    blas.dgemm = reinterpret_cast<decltype(blas.dgemm)>(dlsym(library, "cblas_dgemm"));
    blas.get_corename =
        reinterpret_cast<decltype(blas.get_corename)>(dlsym(library, "openblas_get_corename"));
    const auto get_config =
        reinterpret_cast<decltype(&openblas_get_config)>(dlsym(library, "openblas_get_config"));
    if (get_config != nullptr) blas.config = get_config();
  }
  if (blas.sgemm == nullptr || blas.dgemm == nullptr || blas.get_corename == nullptr ||
      blas.config.empty()) {
    const char* error = dlerror();
    return absl::UnavailableError(
        fmt::format("cannot load OpenBLAS, which the pipelines gemm, gemm12 and control-net need: "
                    "{}; install libopenblas0, or use the pipeline fused",
                    error == nullptr ? "a function is missing" : error));
  }
  return blas;
}

const absl::StatusOr<OpenBlas>& Blas() {
  static const auto* const blas = new absl::StatusOr<OpenBlas>(LoadOpenBlas());
  return *blas;
}

blasint Int(size_t n) { return static_cast<blasint>(n); }

}  // namespace

absl::Status CpuGemm(MatrixView<const float> a, MatrixView<const float> b, MatrixView<float> c) {
  LATTICED_RETURN_IF_ERROR(CheckProduct(a, b, c));
  LATTICED_RETURN_IF_ERROR(Blas().status());
  Blas()->sgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, Int(c.rows), Int(c.columns),
                Int(a.columns), 1.0f, a.data, Int(a.stride), b.data, Int(b.stride), 0.0f, c.data,
                Int(c.stride));
  return absl::OkStatus();
}

absl::Status CpuGemm(MatrixView<const double> a, MatrixView<const double> b, MatrixView<double> c) {
  LATTICED_RETURN_IF_ERROR(CheckProduct(a, b, c));
  LATTICED_RETURN_IF_ERROR(Blas().status());
  Blas()->dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, Int(c.rows), Int(c.columns),
                Int(a.columns), 1.0, a.data, Int(a.stride), b.data, Int(b.stride), 0.0, c.data,
                Int(c.stride));
  return absl::OkStatus();
}

std::string CpuBlasCoreName() { return Blas().ok() ? Blas()->get_corename() : "missing"; }
std::string CpuBlasVersion() { return Blas().ok() ? Blas()->config : "missing"; }

}  // namespace latticed
