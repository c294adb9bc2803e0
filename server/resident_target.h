// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene's target: the backend's, by way of Residency.
//
// Errors   those of Residency::Run
// Threads  safe
#ifndef LATTICED_SERVER_RESIDENT_TARGET_H_
#define LATTICED_SERVER_RESIDENT_TARGET_H_

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "core/backend.h"
#include "server/residency.h"

namespace latticed {

class ResidentTarget : public DeformTarget {
 public:
  ResidentTarget(Residency* residency, std::shared_ptr<const DeformPlan> plan,
                 std::shared_ptr<DeformTarget> inner)
      : residency_(residency), plan_(std::move(plan)), inner_(std::move(inner)) {}

  const DeformPlan& plan() const override { return *plan_; }
  Pipeline pipeline() const override { return inner_->pipeline(); }
  bool evaluates_on_device() const override { return inner_->evaluates_on_device(); }
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override;
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override;
  MemoryUse memory() const override { return inner_->memory(); }

 private:
  Residency* const residency_;
  const std::shared_ptr<const DeformPlan> plan_;
  const std::shared_ptr<DeformTarget> inner_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RESIDENT_TARGET_H_
