// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan, and the backend's target for it until that is evicted. An evicted target is prepared again when
// the plan is evaluated next. On the CPU there is nothing to evict.
//
// Errors   those of RenderBackend::Run
// Threads  safe
#ifndef LATTICED_SERVER_ENGINE_RENDER_TARGET_SLOT_H_
#define LATTICED_SERVER_ENGINE_RENDER_TARGET_SLOT_H_

#include <cstdint>
#include <memory>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/engine/render/render_backend.h"

namespace latticed {

class TargetSlot {
 public:
  // `backend` outlives this. `reservation` is for the host memory of plan and target.
  TargetSlot(RenderBackend* backend, std::shared_ptr<DeformTarget> target,
             std::shared_ptr<const DeformPlan> plan, MemoryReservation reservation);
  TargetSlot(const TargetSlot&) = delete;  // scenes and work share it
  TargetSlot& operator=(const TargetSlot&) = delete;

  const std::shared_ptr<const DeformPlan>& plan() const { return plan_; }
  RenderBackend& backend() const { return *backend_; }
  // Whether the vertices of its views are on a device.
  bool on_device() const { return on_device_; }
  // As DeformTarget's.
  bool has_edge_bounds() const { return has_edge_bounds_; }
  // The target is not evicted while somebody holds the result.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<DeformTarget>> Get() ABSL_LOCKS_EXCLUDED(mutex_);

  [[nodiscard]] MemoryUse memory() const ABSL_LOCKS_EXCLUDED(mutex_);
  // `bytes` are those of a view on all devices; returns those on one device. Views are distributed among
  // devices as their target is.
  [[nodiscard]] uint64_t BytesOn(int device, uint64_t bytes) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Frees the target, unless somebody holds it. Returns whether that freed any memory.
  bool Evict() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  std::shared_ptr<DeformTarget> Now() const ABSL_LOCKS_EXCLUDED(mutex_);

  RenderBackend* const backend_;
  const std::shared_ptr<const DeformPlan> plan_;
  const Pipeline pipeline_;
  const bool on_device_, has_edge_bounds_;
  const MemoryReservation reservation_;
  mutable Mutex mutex_;
  std::shared_ptr<DeformTarget> target_ ABSL_GUARDED_BY(mutex_);  // null: evicted
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_TARGET_SLOT_H_
