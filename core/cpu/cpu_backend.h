// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CPU backend: `fused` on Highway (AVX2, AVX-512, chosen at run time), `gemm`, `gemm12` and
// `control-net` on OpenBLAS (kept to one thread inside), threads by oneTBB.
#ifndef LATTICED_CORE_CPU_CPU_BACKEND_H_
#define LATTICED_CORE_CPU_CPU_BACKEND_H_

#include <memory>

#include "core/backend.h"
#include "core/codec/chunk_encoder.h"

namespace latticed {

struct CpuOptions {
  int threads = 0;                              // 0: all that the machine or its cgroup allows
  std::shared_ptr<const ChunkEncoder> encoder;  // null: the one of core/codec/draco_writer.h
};

[[nodiscard]] std::unique_ptr<Backend> MakeCpuBackend(const CpuOptions& options);

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_CPU_BACKEND_H_
