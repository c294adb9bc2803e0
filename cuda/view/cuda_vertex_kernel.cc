// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/view/cuda_vertex_kernel.h"

namespace latticed {

kernels::Normals NormalsOf(NormalMode mode) {
  switch (mode) {
    case NormalMode::kNone:
      return kernels::Normals::kNone;
    case NormalMode::kFacet:
      return kernels::Normals::kFacet;
    case NormalMode::kSmooth:
      return kernels::Normals::kSmooth;
  }
  return kernels::Normals::kNone;
}

}  // namespace latticed
