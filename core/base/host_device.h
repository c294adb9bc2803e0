// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// LATTICED_HD marks a function that both the host compiler and nvcc build: one formula, two
// compilers.
#ifndef LATTICED_CORE_BASE_HOST_DEVICE_H_
#define LATTICED_CORE_BASE_HOST_DEVICE_H_

#ifdef __CUDACC__
#define LATTICED_HD __host__ __device__
#else
#define LATTICED_HD
#endif

#endif  // LATTICED_CORE_BASE_HOST_DEVICE_H_
