// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Calls a template of three degrees with degrees that are known at run time.
#ifndef LATTICED_CUDA_FUSED_CALL_BY_DEGREE_H_
#define LATTICED_CUDA_FUSED_CALL_BY_DEGREE_H_

#include "cuda/device/kernel_call.h"

namespace latticed::kernels {

// call.operator()<d[0], d[1], d[2]>(). The degrees are 1 to 3 and do not rise; for others it returns a
// call of no kernel.
template <class Call>
KernelCall CallByDegree(const int* d, const Call& call) {
  switch (100 * d[0] + 10 * d[1] + d[2]) {
    case 111:
      return call.template operator()<1, 1, 1>();
    case 211:
      return call.template operator()<2, 1, 1>();
    case 221:
      return call.template operator()<2, 2, 1>();
    case 222:
      return call.template operator()<2, 2, 2>();
    case 311:
      return call.template operator()<3, 1, 1>();
    case 321:
      return call.template operator()<3, 2, 1>();
    case 322:
      return call.template operator()<3, 2, 2>();
    case 331:
      return call.template operator()<3, 3, 1>();
    case 332:
      return call.template operator()<3, 3, 2>();
    case 333:
      return call.template operator()<3, 3, 3>();
    default:
      return {};
  }
}

}  // namespace latticed::kernels

#endif  // LATTICED_CUDA_FUSED_CALL_BY_DEGREE_H_
