// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A plan, and the backend's target for it while nobody has evicted that. An evicted target is
// prepared again when the plan is evaluated next. On the CPU there is nothing to evict.
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
  // `backend` outlives this, which keeps the host memory that `reservation` is for.
  TargetSlot(RenderBackend* backend, std::shared_ptr<DeformTarget> target,
             std::shared_ptr<const DeformPlan> plan, MemoryReservation reservation);
  TargetSlot(const TargetSlot&) = delete;  // scenes and work share it
  TargetSlot& operator=(const TargetSlot&) = delete;

  const std::shared_ptr<const DeformPlan>& plan() const { return plan_; }
  RenderBackend& backend() const { return *backend_; }
  // Vertices of its views lie on a device.
  bool on_device() const { return on_device_; }
  // While somebody holds the result it is not evicted.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<DeformTarget>> Get() ABSL_LOCKS_EXCLUDED(mutex_);

  [[nodiscard]] MemoryUse memory() const ABSL_LOCKS_EXCLUDED(mutex_);
  // The part of `bytes`, on all devices together, that is on one: views lie as their target does.
  [[nodiscard]] uint64_t BytesOn(int device, uint64_t bytes) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Frees the target, unless somebody holds it. Whether that freed any memory.
  bool Evict() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  std::shared_ptr<DeformTarget> Now() const ABSL_LOCKS_EXCLUDED(mutex_);

  RenderBackend* const backend_;
  const std::shared_ptr<const DeformPlan> plan_;
  const Pipeline pipeline_;
  const bool on_device_;
  const MemoryReservation reservation_;
  mutable Mutex mutex_;
  std::shared_ptr<DeformTarget> target_ ABSL_GUARDED_BY(mutex_);  // null: evicted
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_TARGET_SLOT_H_
