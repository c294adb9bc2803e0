// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// LATTICED_HD marks a function that both the host compiler and nvcc build: one formula, two
// compilers. LATTICED_UNROLL before a loop with constant bounds unrolls it in full.
#ifndef LATTICED_CORE_BASE_HOST_DEVICE_H_
#define LATTICED_CORE_BASE_HOST_DEVICE_H_

#ifdef __CUDACC__
#define LATTICED_HD __host__ __device__
#define LATTICED_UNROLL _Pragma("unroll")
#else
#define LATTICED_HD
#define LATTICED_UNROLL _Pragma("GCC unroll 64")
#endif

#endif  // LATTICED_CORE_BASE_HOST_DEVICE_H_
