// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/cpu_backend.h"

#include <tbb/info.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <utility>

#include "core/cpu/cpu_context.h"
#include "core/cpu/cpu_gemm.h"
#include "core/cpu/cpu_target.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// The processors that a container may use, rounded up: "max 100000" or "150000 100000" in cgroup
// v2. oneTBB 2021 looks at the affinity mask only.
int CgroupThreads(int most) {
  std::ifstream file("/sys/fs/cgroup/cpu.max");
  std::string quota;
  long period = 0;
  if (!(file >> quota >> period) || quota == "max" || period <= 0) return most;
  const long allowed = std::strtol(quota.c_str(), nullptr, 10);
  return static_cast<int>(std::clamp<long>((allowed + period - 1) / period, 1, most));
}

int ThreadCount(int asked) {
  return asked > 0 ? asked : CgroupThreads(std::max(1, tbb::info::default_concurrency()));
}

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
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override {
    auto target = CpuTarget::Create(std::move(plan), pipeline, context_);
    if (!target.ok()) return target.status();
    return std::shared_ptr<DeformTarget>(*std::move(target));
  }

 private:
  std::shared_ptr<CpuContext> context_;
};

}  // namespace

std::unique_ptr<Backend> MakeCpuBackend(const CpuOptions& options) {
  std::shared_ptr<const ChunkEncoder> encoder = options.encoder;
  if (encoder == nullptr) encoder = MakeReferenceEncoder();
  return std::make_unique<CpuBackend>(
      std::make_shared<CpuContext>(ThreadCount(options.threads), std::move(encoder)));
}

}  // namespace latticed
