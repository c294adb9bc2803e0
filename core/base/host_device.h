// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// LATTICED_HD marks a function that both the host compiler and nvcc build: one formula, two
// compilers. LATTICED_UNROLL before a loop with constant bounds unrolls it in full.
#ifndef LATTICED_CORE_BASE_HOST_DEVICE_H_
#define LATTICED_CORE_BASE_HOST_DEVICE_H_

#ifdef __CUDACC__
#define LATTICED_HD __host__ __device__
#else
#define LATTICED_HD
#endif

// nvcc reads a file once for the device, and once for the host, where neither its pragma nor the host's is known to both
// of the compilers that see it.
#if defined(__CUDA_ARCH__)
#define LATTICED_UNROLL _Pragma("unroll")
#elif defined(__CUDACC__)
#define LATTICED_UNROLL
#else
#define LATTICED_UNROLL _Pragma("GCC unroll 64")
#endif

#endif  // LATTICED_CORE_BASE_HOST_DEVICE_H_
