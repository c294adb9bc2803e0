// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The threads and the encoder, which all targets and views of one CPU backend share.
#ifndef LATTICED_CORE_CPU_CPU_CONTEXT_H_
#define LATTICED_CORE_CPU_CPU_CONTEXT_H_

#include <memory>

#include "core/codec/chunk_encoder.h"
#include "core/view/cpu_arena.h"

namespace latticed {

struct CpuContext {
  CpuContext(int thread_count, std::shared_ptr<const ChunkEncoder> chunk_encoder)
      : threads(thread_count), arena(thread_count), encoder(std::move(chunk_encoder)) {}

  int threads;
  CpuArena arena;
  std::shared_ptr<const ChunkEncoder> encoder;
};

}  // namespace latticed

#endif  // LATTICED_CORE_CPU_CPU_CONTEXT_H_
