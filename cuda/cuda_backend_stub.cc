// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/cuda_backend.h"

namespace latticed {

absl::StatusOr<std::unique_ptr<Backend>> MakeCudaBackend(const CudaOptions& /*options*/) {
  return absl::UnimplementedError("built without CUDA");
}

}  // namespace latticed
