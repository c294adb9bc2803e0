// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_gemm.h"

#include <dlfcn.h>

#include <array>
#include <string>

#include "core/base/error.h"
#include "core/base/matrix_view.h"
#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"
#include "fmt/format.h"
#include "fmt/ranges.h"

namespace latticed {
namespace {

int Int(size_t n) { return static_cast<int>(n); }

void* Open(std::string& problem) {
  const std::string name = fmt::format("libcublas.so.{}", CUBLAS_VER_MAJOR);
  // Some installations do not put the toolkit on the loader's path.
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
      Find(library, "cublasDgemm_v2", result.dgemm) &&
      Find(library, "cublasGetProperty", result.get_property)) {
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

std::string CublasVersion() {
  const auto library = CublasLibrary::Get();
  if (!library.ok()) return "missing";
  std::array<int, 3> version{};
  constexpr std::array kParts = {MAJOR_VERSION, MINOR_VERSION, PATCH_LEVEL};
  for (size_t i = 0; i < kParts.size(); ++i) (*library)->get_property(kParts[i], &version[i]);
  return fmt::format("{}", fmt::join(version, "."));
}

absl::StatusOr<std::unique_ptr<CudaGemm>> CudaGemm::Create(DeviceReservation& from,
                                                           cudaStream_t stream) {
  LATTICED_ASSIGN_OR_RETURN(const auto library, CublasLibrary::Get());
  LATTICED_ASSIGN_OR_RETURN(auto workspace, DeviceBuffer<uint8_t>::Create(from, "gemm_workspace",
                                                                          kWorkspaceBytes, stream));
  cublasHandle_t handle = nullptr;
  LATTICED_RETURN_IF_ERROR(CublasStatus(library->create(&handle), "cuBLAS"));
  std::unique_ptr<CudaGemm> gemm(new CudaGemm(*library, handle, std::move(workspace)));
  LATTICED_RETURN_IF_ERROR(gemm->Configure(stream));
  return gemm;
}

absl::Status CudaGemm::Configure(cudaStream_t stream) {
  // The stream comes first: cublasSetStream resets the workspace to the default.
  LATTICED_RETURN_IF_ERROR(CublasStatus(library_.set_stream(handle_, stream), "cuBLAS"));
  LATTICED_RETURN_IF_ERROR(
      CublasStatus(library_.set_workspace(handle_, workspace_.data(), kWorkspaceBytes), "cuBLAS"));
  return CublasStatus(library_.set_atomics_mode(handle_, CUBLAS_ATOMICS_NOT_ALLOWED), "cuBLAS");
}

CudaGemm::~CudaGemm() { static_cast<void>(library_.destroy(handle_)); }

absl::Status CudaGemm::Multiply(DeviceMatrix<const float> a, DeviceMatrix<const float> b,
                                DeviceMatrix<float> c) {
  LATTICED_RETURN_IF_ERROR(CheckProduct(a, b, c));
  const float one = 1, zero = 0;
  return CublasStatus(library_.sgemm(handle_, CUBLAS_OP_N, CUBLAS_OP_N, Int(c.rows), Int(c.columns),
                                     Int(a.columns), &one, a.data, Int(a.stride), b.data,
                                     Int(b.stride), &zero, c.data, Int(c.stride)),
                      "cublasSgemm");
}

absl::Status CudaGemm::Multiply(DeviceMatrix<const double> a, DeviceMatrix<const double> b,
                                DeviceMatrix<double> c) {
  LATTICED_RETURN_IF_ERROR(CheckProduct(a, b, c));
  const double one = 1, zero = 0;
  return CublasStatus(library_.dgemm(handle_, CUBLAS_OP_N, CUBLAS_OP_N, Int(c.rows), Int(c.columns),
                                     Int(a.columns), &one, a.data, Int(a.stride), b.data,
                                     Int(b.stride), &zero, c.data, Int(c.stride)),
                      "cublasDgemm");
}

}  // namespace latticed
