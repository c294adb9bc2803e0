// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/cuda_backend.h"

#include <algorithm>
#include <string>
#include <utility>

#include "cuda/cuda_context.h"
#include "cuda/cuda_target.h"
#include "fmt/format.h"

namespace latticed {
namespace {

using Contexts = std::vector<std::shared_ptr<CudaContext>>;

class CudaBackend : public Backend {
 public:
  explicit CudaBackend(Contexts contexts) : contexts_(std::move(contexts)) {}

  std::string_view name() const override { return "cuda"; }
  std::string description() const override {
    std::string text;
    for (const auto& context : contexts_) {
      if (!text.empty()) text += "; ";
      text += fmt::format("{}, budget {:.1f} GiB", DescribeDevice(context->device()),
                          static_cast<double>(context->memory()->budget_bytes()) / kGiB);
    }
    return text;
  }
  std::vector<DeviceState> devices() const override {
    std::vector<DeviceState> states;
    for (const auto& context : contexts_) {
      const DeviceMemory& memory = *context->memory();
      states.push_back({.name = DescribeDevice(context->device()),
                        .memory_bytes = memory.device_bytes(),
                        .budget_bytes = memory.budget_bytes(),
                        .free_bytes = memory.free_bytes(),
                        .use = memory.use()});
    }
    return states;
  }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override {
    const auto freest =
        std::max_element(contexts_.begin(), contexts_.end(), [](const auto& a, const auto& b) {
          return a->memory()->free_bytes() < b->memory()->free_bytes();
        });
    auto target = CudaTarget::Create(std::move(plan), pipeline, *freest);
    if (!target.ok()) return target.status();
    return std::shared_ptr<DeformTarget>(*std::move(target));
  }

 private:
  static constexpr double kGiB = uint64_t{1} << 30;

  const Contexts contexts_;  // one a device, at least one
};

}  // namespace

absl::StatusOr<std::unique_ptr<Backend>> MakeCudaBackend(const CudaOptions& options) {
  if (options.devices.empty()) return absl::InvalidArgumentError("devices: name at least one");
  Contexts contexts;
  for (const int device : options.devices) {
    auto context = CudaContext::Create(device, options);
    if (!context.ok()) return context.status();
    contexts.push_back(*std::move(context));
  }
  return std::make_unique<CudaBackend>(std::move(contexts));
}

}  // namespace latticed
