// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/cuda_backend.h"

#include <string>
#include <utility>

#include "core/base/status_macros.h"
#include "core/view/device_group.h"
#include "cuda/cuda_target.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/cuda_gemm.h"
#include "cuda/gemm/cuda_gemm_kernel.h"
#include "cuda/points/cuda_points.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// A backend of one device.
class CudaBackend : public Backend {
 public:
  explicit CudaBackend(std::shared_ptr<CudaContext> context)
      : context_(std::move(context)), device_name_(DescribeDevice(context_->device())) {}

  std::string_view name() const override { return "cuda"; }
  std::string description() const override {
    return fmt::format("{}, budget {:.1f} GiB", device_name_,
                       static_cast<double>(context_->memory()->budget_bytes()) / kGiB);
  }
  std::vector<DeviceState> devices() const override {
    const DeviceMemory& memory = *context_->memory();
    return {{.number = context_->device(),
             .name = device_name_,
             .memory_bytes = memory.device_bytes(),
             .budget_bytes = memory.budget_bytes(),
             .free_bytes = memory.free_bytes(),
             .use = memory.use()}};
  }
  std::string Arithmetic(Pipeline pipeline) const override {
    // The driver compiles the kernels for devices that are newer than the build.
    std::string all = fmt::format("driver {}", DriverVersion());
    if (pipeline == Pipeline::kFused) return all;
    return all + fmt::format(", cuBLAS {}, tiles of {} bytes", CublasVersion(),
                             CudaGemmKernel::MostTileBytes(context_->memory()->budget_bytes()));
  }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override {
    return MakeCudaTarget(std::move(plan), pipeline, context_);
  }
  absl::StatusOr<std::shared_ptr<PointEvaluator>> PreparePoints(
      std::shared_ptr<const SortedPoints> points) override {
    return MakeCudaPoints(std::move(points), context_);
  }

 private:
  static constexpr double kGiB = uint64_t{1} << 30;

  const std::shared_ptr<CudaContext> context_;
  const std::string device_name_;  // kept, because asking the driver is slow
};

}  // namespace

absl::StatusOr<std::unique_ptr<Backend>> MakeCudaBackend(const CudaOptions& options) {
  if (options.devices.empty()) return absl::InvalidArgumentError("devices: name at least one");
  std::vector<std::unique_ptr<Backend>> devices;
  for (const int device : options.devices) {
    LATTICED_ASSIGN_OR_RETURN(auto context, CudaContext::Create(device, options));
    devices.push_back(std::make_unique<CudaBackend>(std::move(context)));
  }
  return MakeDeviceGroup(std::move(devices), options.span_patches);
}

}  // namespace latticed
