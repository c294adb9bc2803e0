// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What scenes have in memory, the device's above all: every call of the backend on their behalf
// goes through here.
//
//   Scene --Prepare--> ResidentTarget --CreateView--> ResidentView       each around the backend's
//
//   refused for want of memory   another scene gives back what can be made again, one on the device
//                                that lacks it, and the call is tried once more, until it is granted;
//                                where nothing is left to give it is tried for some 50 ms more, for
//                                streams that are about to end and memory that comes free by itself
//   kUnavailable                 the device is lost, and is asked nothing any more
//
// Errors   the backend's; once the device is lost DeviceHealth's, for all
// Threads  safe. No lock may be held while a call runs: giving back takes those of all scenes.
#ifndef LATTICED_SERVER_ENGINE_RENDER_RESIDENCY_H_
#define LATTICED_SERVER_ENGINE_RENDER_RESIDENCY_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/backend.h"
#include "core/base/status_macros.h"
#include "server/engine/engine_counts.h"
#include "server/engine/render/device_health.h"

namespace latticed {

class ResidentTarget;  // server/engine/render/resident_target.h

class Residency {
 public:
  // What a call was refused for want of.
  struct Lack {
    uint64_t bytes = 0;         // 0: nobody knows how many
    std::optional<int> device;  // in whose memory; nullopt: the host's
  };
  // Has one scene give back what it has there. False: no scene may, or all that may have not so
  // much together.
  using MakeRoom = std::function<bool(const Lack& lack)>;

  // `backend` outlives this, and this all targets and views. Null: nothing is given back.
  explicit Residency(Backend* backend, MakeRoom make_room = nullptr)
      : backend_(backend), make_room_(std::move(make_room)) {}
  Residency(const Residency&) = delete;  // targets and views hold its address
  Residency& operator=(const Residency&) = delete;

  [[nodiscard]] absl::StatusOr<std::shared_ptr<ResidentTarget>> Prepare(
      std::shared_ptr<const DeformPlan> plan, Pipeline pipeline);
  // The backend's own, for a ResidentTarget that gave its back.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<DeformTarget>> PrepareInner(
      const std::shared_ptr<const DeformPlan>& plan, Pipeline pipeline) {
    return Run([&] { return backend_->Prepare(plan, pipeline); });
  }

  // Runs `call`, which asks something of the backend or of a budget and returns a Status or a
  // StatusOr; again while it is refused for want of memory that it may have by then.
  template <typename Call>
  auto Run(Call call) -> decltype(call()) {
    std::optional<absl::Time> give_up;
    while (true) {
      LATTICED_RETURN_IF_ERROR(health_.status());
      auto answer = call();
      const absl::Status status = StatusOf(answer);
      health_.Note(status);
      if (absl::IsUnavailable(status)) return health_.status();
      if (!MayFitNow(status, give_up)) return answer;
    }
  }

  DeviceHealth& health() { return health_; }
  EngineCounts& counts() { return counts_; }
  // Orders uses: each is above those before.
  uint64_t NextUse() { return ++last_use_; }

 private:
  static absl::Status StatusOf(const absl::Status& status) { return status; }
  template <typename T>
  static absl::Status StatusOf(const absl::StatusOr<T>& answer) {
    return answer.status();
  }
  // Whether what was refused is worth another try: room was made for it, or some time has passed,
  // until `give_up`, which begins with the first refusal that no scene could help.
  bool MayFitNow(const absl::Status& refusal, std::optional<absl::Time>& give_up);

  Backend* const backend_;
  const MakeRoom make_room_;
  DeviceHealth health_;
  EngineCounts counts_;
  std::atomic<uint64_t> last_use_ = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_RESIDENCY_H_
