// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/cpu/lane_order_view.h"

#include <utility>
#include <vector>

#include "core/cpu/fused/cpu_fused.h"
#include "core/cpu/host_buffer.h"
#include "core/view/cpu_arena.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

class LaneOrderView : public DeformView {
 public:
  LaneOrderView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec, int threads)
      : spec_(spec),
        kernel_(FusedKernel::Create(std::make_shared<const fused::FusedPlan>(std::move(plan)))),
        vertices_(Checked(HostBuffer::Create("vertices", kernel_->LaneOrderBytes(spec)))),
        arena_(threads) {}

  const ViewSpec& spec() const override { return spec_; }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override {
    return kernel_->Evaluate(control_points, box, chunks, spec_, vertices_.span(), arena_,
                             FusedOrder::kLanes);
  }
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override {
    kernel_->ReadLaneOrder(vertices_.span(), spec_, chunk, out);
    return absl::OkStatus();
  }
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t>, Encoding,
                                                  std::span<VertexDigest>, TakeEarly) override {
    return absl::UnimplementedError("lane order is not encoded");
  }
  MemoryUse memory() const override { return {{"vertices", vertices_.size()}}; }

 private:
  const ViewSpec spec_;
  const std::unique_ptr<FusedKernel> kernel_;
  HostBuffer vertices_;
  CpuArena arena_;
};

}  // namespace

std::unique_ptr<DeformView> MakeLaneOrderView(std::shared_ptr<const DeformPlan> plan,
                                              const ViewSpec& spec, int threads) {
  return std::make_unique<LaneOrderView>(std::move(plan), spec, threads);
}

}  // namespace latticed::bench
