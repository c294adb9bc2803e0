// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The backend as scenes use it: every call for a scene goes through Run.
//
//   refused for want of memory   MemoryBudget::Admit evicts what unused scenes have there, and the call
//                                is made again
//   kUnavailable                 the device is lost, and no further call is made
//
// Errors   the backend's; once the device is lost DeviceHealth's, for all
// Threads  safe. No lock may be held while a call runs: eviction takes those of all scenes.
#ifndef LATTICED_SERVER_ENGINE_RENDER_RENDER_BACKEND_H_
#define LATTICED_SERVER_ENGINE_RENDER_RENDER_BACKEND_H_

#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/backend.h"
#include "core/base/status_macros.h"
#include "server/base/engine_counts.h"
#include "server/engine/memory/memory_budget.h"
#include "server/engine/render/device_health.h"

namespace latticed {

class RenderBackend {
 public:
  // `backend` outlives this, and this all targets and views.
  RenderBackend(Backend* backend, std::shared_ptr<MemoryBudget> memory)
      : backend_(backend), memory_(std::move(memory)) {}
  RenderBackend(const RenderBackend&) = delete;  // views hold its address
  RenderBackend& operator=(const RenderBackend&) = delete;

  // Runs `call`, which returns a Status or a StatusOr.
  template <typename Call>
  auto Run(Call call) -> decltype(call()) {
    return memory_->Admit([&]() -> decltype(call()) {
      LATTICED_RETURN_IF_ERROR(health_.status());
      auto answer = call();
      health_.Note(StatusOf(answer));
      LATTICED_RETURN_IF_ERROR(health_.status());
      return answer;
    });
  }
  [[nodiscard]] absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(
      const std::shared_ptr<const DeformPlan>& plan, Pipeline pipeline) {
    return Run([&] { return backend_->Prepare(plan, pipeline); });
  }
  [[nodiscard]] absl::StatusOr<std::shared_ptr<PointEvaluator>> PreparePoints(
      const std::shared_ptr<const SortedPoints>& points) {
    return Run([&] { return backend_->PreparePoints(points); });
  }

  MemoryBudget& memory() { return *memory_; }
  DeviceHealth& health() { return health_; }
  EngineCounts& counts() { return counts_; }

 private:
  static absl::Status StatusOf(const absl::Status& status) { return status; }
  template <typename T>
  static absl::Status StatusOf(const absl::StatusOr<T>& answer) {
    return answer.status();
  }

  Backend* const backend_;
  const std::shared_ptr<MemoryBudget> memory_;
  DeviceHealth health_;
  EngineCounts counts_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_RENDER_BACKEND_H_
