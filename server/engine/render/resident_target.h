// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene's target: the backend's, by way of Residency. What that keeps on a device can be given
// back; whatever is asked next makes it again from the plan, which stays on the host.
//
// Errors   those of Residency::Run
// Threads  safe
#ifndef LATTICED_SERVER_ENGINE_RENDER_RESIDENT_TARGET_H_
#define LATTICED_SERVER_ENGINE_RENDER_RESIDENT_TARGET_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "core/backend.h"
#include "core/base/mutex.h"
#include "server/engine/render/residency.h"

namespace latticed {

class ResidentTarget : public DeformTarget, public std::enable_shared_from_this<ResidentTarget> {
 public:
  ResidentTarget(Residency* residency, std::shared_ptr<const DeformPlan> plan,
                 std::shared_ptr<DeformTarget> inner);

  const DeformPlan& plan() const override { return *plan_; }
  Pipeline pipeline() const override { return pipeline_; }
  bool evaluates_on_device() const override { return on_device_; }
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override
      ABSL_LOCKS_EXCLUDED(mutex_);
  // 0 once what it has was given back.
  uint64_t EncoderBytes(const ViewSpec& spec) const override ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override
      ABSL_LOCKS_EXCLUDED(mutex_);
  // The plan alone once the rest was given back.
  MemoryUse memory() const override ABSL_LOCKS_EXCLUDED(mutex_);
  DeviceUse device_use() const override ABSL_LOCKS_EXCLUDED(mutex_);

  Residency& residency() const { return *residency_; }
  // Counts as a use from here on.
  void Touch() { last_use_ = residency_->NextUse(); }
  uint64_t last_use() const { return last_use_.load(); }
  // Frees what is on the device, unless a view or a call uses it. Whether it did: never where the host
  // evaluates, for there it belongs to the plan.
  bool GiveBack() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // Makes it where it was given back. Two who ask at once may both make it; one of them is kept.
  absl::StatusOr<std::shared_ptr<DeformTarget>> Inner() ABSL_LOCKS_EXCLUDED(mutex_);
  // Null where it was given back.
  std::shared_ptr<DeformTarget> InnerNow() const ABSL_LOCKS_EXCLUDED(mutex_);

  Residency* const residency_;
  const std::shared_ptr<const DeformPlan> plan_;
  const Pipeline pipeline_;
  const bool on_device_;
  std::atomic<uint64_t> last_use_;

  mutable Mutex mutex_;
  // Null: given back. Its views hold it as well, whatever of it the backend's own hold.
  std::shared_ptr<DeformTarget> inner_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_RESIDENT_TARGET_H_
