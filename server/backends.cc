// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/backends.h"

#include <string>
#include <utility>

#include "core/codec/chunk_encoder.h"
#include "core/cpu/cpu_backend.h"
#include "cuda/cuda_backend.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"

namespace latticed {

absl::StatusOr<std::vector<std::unique_ptr<Backend>>> MakeBackends(const Options& options) {
  const std::shared_ptr<const ChunkEncoder> encoder = MakeChunkEncoder(options.encoder);
  std::vector<std::unique_ptr<Backend>> backends;
  if (options.backend != "cpu") {
    absl::StatusOr<std::unique_ptr<Backend>> cuda =
        MakeCudaBackend({.devices = options.devices,
                         .span_patches = options.span_patches,
                         .memory_bytes = options.gpu_memory_bytes,
                         .threads = options.threads,
                         .encoder = encoder});
    if (cuda.ok()) {
      backends.push_back(*std::move(cuda));
    } else if (options.backend == "cuda") {
      return absl::Status(cuda.status().code(),
                          fmt::format("--backend cuda: {}; use --backend cpu or auto",
                                      std::string(cuda.status().message())));
    } else {
      LogEvent(spdlog::level::debug, "no CUDA backend",
               {{"why", std::string(cuda.status().message())}});
    }
  }
  if (options.backend != "cuda") {
    backends.push_back(MakeCpuBackend({.threads = options.threads, .encoder = encoder}));
  }
  return backends;
}

}  // namespace latticed
