// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What scenes have in the backend: every call of it on their behalf goes through here, which
// notices when the device is lost and asks it nothing any more.
//
//   Scene --Prepare--> ResidentTarget --CreateView--> ResidentView       each around the backend's
//
// Errors   the backend's; once the device is lost DeviceHealth's, for all
// Threads  safe
#ifndef LATTICED_SERVER_RESIDENCY_H_
#define LATTICED_SERVER_RESIDENCY_H_

#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/backend.h"
#include "server/device_health.h"

namespace latticed {

class ResidentTarget;  // server/resident_target.h

class Residency {
 public:
  // `backend` outlives this, and this all targets and views.
  explicit Residency(Backend* backend) : backend_(backend) {}
  Residency(const Residency&) = delete;  // targets and views hold its address
  Residency& operator=(const Residency&) = delete;

  [[nodiscard]] absl::StatusOr<std::shared_ptr<ResidentTarget>> Prepare(
      std::shared_ptr<const DeformPlan> plan, Pipeline pipeline);

  // Runs `call`, which asks something of the backend and returns a Status or a StatusOr.
  template <typename Call>
  auto Run(Call call) -> decltype(call()) {
    if (auto lost = health_.status(); !lost.ok()) return lost;
    auto answer = call();
    const absl::Status status = StatusOf(answer);
    health_.Note(status);
    if (absl::IsUnavailable(status)) return health_.status();
    return answer;
  }

  Backend& backend() const { return *backend_; }
  DeviceHealth& health() { return health_; }

 private:
  static absl::Status StatusOf(const absl::Status& status) { return status; }
  template <typename T>
  static absl::Status StatusOf(const absl::StatusOr<T>& answer) {
    return answer.status();
  }

  Backend* const backend_;
  DeviceHealth health_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RESIDENCY_H_
