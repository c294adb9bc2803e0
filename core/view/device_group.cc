// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/device_group.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_join.h"
#include "core/base/catch_bad_alloc.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/ffd/plan/plan_slice.h"
#include "core/view/spanned/spanned_target.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Device bytes of a patch at 10 segments: 64 of the plan, and 66 points of 8 bytes.
constexpr uint64_t kPatchBytes = 592;
constexpr uint64_t kChunkBytes = kPatchBytes * limits::kPatchesPerChunk;

class DeviceGroup : public Backend {
 public:
  DeviceGroup(std::vector<std::unique_ptr<Backend>> devices, uint64_t span_patches)
      : devices_(std::move(devices)), span_patches_(span_patches) {}

  std::string_view name() const override { return devices_.front()->name(); }
  std::string description() const override {
    std::string text;
    for (const auto& device : devices_) text += device->description() + "; ";
    return text + fmt::format("scenes of {} patches or more span them", span_patches_);
  }
  std::vector<DeviceState> devices() const override {
    std::vector<DeviceState> states;
    for (const auto& device : devices_) {
      for (DeviceState& state : device->devices()) states.push_back(std::move(state));
    }
    return states;
  }
  std::string Arithmetic(Pipeline pipeline) const override {
    std::set<std::string> all;
    for (const auto& device : devices_) all.insert(device->Arithmetic(pipeline));
    return absl::StrJoin(all, "; ");
  }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override {
    LATTICED_RETURN_IF_ERROR(CheckSupported(*plan, pipeline));
    const std::vector<DeviceState> states = devices();
    if (pipeline == Pipeline::kFused && Spans(*plan, states)) return Share(plan, states);
    return Freest(states).Prepare(std::move(plan), pipeline);
  }
  absl::StatusOr<std::shared_ptr<PointEvaluator>> PreparePoints(
      std::shared_ptr<const SortedPoints> points) override {
    return Freest(devices()).PreparePoints(std::move(points));
  }

 private:
  // The device with the most free memory.
  Backend& Freest(const std::vector<DeviceState>& states) const {
    const auto freest = std::ranges::max_element(states, {}, &DeviceState::free_bytes);
    return *devices_[static_cast<size_t>(freest - states.begin())];
  }
  bool Spans(const DeformPlan& plan, const std::vector<DeviceState>& states) const {
    if (plan.patches.size() >= span_patches_) return true;
    const uint64_t bytes = plan.patches.size() * kPatchBytes;
    return std::ranges::all_of(states, [bytes](const DeviceState& state) {
      return state.budget_bytes != 0 && state.budget_bytes < bytes;
    });
  }

  absl::StatusOr<std::shared_ptr<DeformTarget>> Share(const std::shared_ptr<const DeformPlan>& plan,
                                                      const std::vector<DeviceState>& states) {
    return CatchBadAlloc("the plan", [&]() -> absl::StatusOr<std::shared_ptr<DeformTarget>> {
      std::vector<uint64_t> free(states.size());
      std::ranges::transform(states, free.begin(), &DeviceState::free_bytes);
      const std::vector<size_t> bounds = ShareChunks(plan->chunk_count(), kChunkBytes, free);
      std::vector<SpannedTarget::Part> parts;
      for (size_t d = 0; d < devices_.size(); ++d) {
        if (bounds[d] == bounds[d + 1]) continue;
        LATTICED_ASSIGN_OR_RETURN(
            auto target,
            devices_[d]->Prepare(SlicePlan(*plan, bounds[d], bounds[d + 1]), Pipeline::kFused));
        parts.push_back({static_cast<uint32_t>(bounds[d]), std::move(target)});
      }
      return std::make_shared<SpannedTarget>(plan, std::move(parts));
    });
  }

  const std::vector<std::unique_ptr<Backend>> devices_;
  const uint64_t span_patches_;
};

}  // namespace

std::vector<size_t> ShareChunks(size_t chunks, uint64_t bytes_per_chunk,
                                std::span<const uint64_t> free_bytes) {
  const size_t devices = free_bytes.size(), equal = (chunks + devices - 1) / devices;
  std::vector<double> weights(free_bytes.begin(), free_bytes.end());
  const bool fits = std::ranges::min(free_bytes) >= equal * bytes_per_chunk;
  const double room = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (fits || room == 0) weights.assign(devices, 1);
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<size_t> bounds{0};
  double before = 0;
  for (const double weight : weights) {
    before += weight;
    bounds.push_back(
        static_cast<size_t>(std::llround(static_cast<double>(chunks) * before / total)));
  }
  bounds.back() = chunks;
  return bounds;
}

std::unique_ptr<Backend> MakeDeviceGroup(std::vector<std::unique_ptr<Backend>> devices,
                                         uint64_t span_patches) {
  if (devices.size() == 1) return std::move(devices.front());
  return std::make_unique<DeviceGroup>(std::move(devices), span_patches);
}

}  // namespace latticed
