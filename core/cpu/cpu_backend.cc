// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/cpu_backend.h"

#include <unistd.h>

#include <string>
#include <utility>

#include "core/cpu/cpu_context.h"
#include "core/cpu/cpu_target.h"
#include "core/cpu/gemm/cpu_gemm.h"
#include "core/view/machine.h"
#include "fmt/format.h"

namespace latticed {
namespace {

std::string_view VectorUnit() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) return "AVX-512";
  if (__builtin_cpu_supports("avx2")) return "AVX2";
  return "SSE2";
#else
  return "native vectors";
#endif
}

class CpuBackend : public Backend {
 public:
  explicit CpuBackend(std::shared_ptr<CpuContext> context) : context_(std::move(context)) {}

  std::string_view name() const override { return "cpu"; }
  std::string description() const override {
    return fmt::format("{}, {} {}, OpenBLAS {}", VectorUnit(), context_->threads,
                       context_->threads == 1 ? "thread" : "threads", CpuBlasCoreName());
  }
  std::vector<DeviceState> devices() const override {
    return {{.name = description(),
             .memory_bytes = MachineBytes(_SC_PHYS_PAGES),
             .free_bytes = MachineBytes(_SC_AVPHYS_PAGES)}};
  }
  std::string Arithmetic(Pipeline pipeline) const override {
    return pipeline == Pipeline::kFused ? "" : CpuBlasVersion();
  }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override {
    return MakeCpuTarget(std::move(plan), pipeline, context_);
  }

 private:
  std::shared_ptr<CpuContext> context_;
};

}  // namespace

std::unique_ptr<Backend> MakeCpuBackend(const CpuOptions& options) {
  std::shared_ptr<const ChunkEncoder> encoder = options.encoder;
  if (encoder == nullptr) encoder = MakeChunkEncoder("latticed");
  return std::make_unique<CpuBackend>(
      std::make_shared<CpuContext>(AllowedThreads(options.threads), std::move(encoder)));
}

}  // namespace latticed
