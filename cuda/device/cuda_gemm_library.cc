// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_gemm_library.h"

#include <dlfcn.h>

#include <string>

#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed {
namespace {

void* Open(std::string& problem) {
  const std::string name = fmt::format("libcublas.so.{}", CUBLAS_VER_MAJOR);
  // Some installations leave the toolkit off the loader's path.
  for (const std::string& path : {name, "/usr/local/cuda/lib64/" + name}) {
    if (void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) return library;
    if (problem.empty()) problem = dlerror();
  }
  return nullptr;
}

template <typename Function>
bool Find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  return function != nullptr;
}

absl::StatusOr<CublasLibrary> Load() {
  std::string problem;
  void* const library = Open(problem);
  CublasLibrary result;
  if (library != nullptr && Find(library, "cublasCreate_v2", result.create) &&
      Find(library, "cublasDestroy_v2", result.destroy) &&
      Find(library, "cublasSetStream_v2", result.set_stream) &&
      Find(library, "cublasSetWorkspace_v2", result.set_workspace) &&
      Find(library, "cublasSetAtomicsMode", result.set_atomics_mode) &&
      Find(library, "cublasSgemm_v2", result.sgemm) &&
      Find(library, "cublasDgemm_v2", result.dgemm)) {
    return result;
  }
  if (problem.empty()) problem = "a function is missing";
  return error::Unavailable("NO_CUBLAS", "cuBLAS cannot be loaded: " + problem, 0);
}

}  // namespace

absl::StatusOr<const CublasLibrary*> CublasLibrary::Get() {
  static const absl::StatusOr<CublasLibrary> library = Load();
  if (!library.ok()) return library.status();
  return &*library;
}

}  // namespace latticed
