// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/render/device_health.h"

#include <string>
#include <utility>

#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// By then a load balancer has noticed the loss and sends the next call to another server.
constexpr uint32_t kRetryElsewhereMs = 1'000;

}  // namespace

absl::Status DeviceHealth::status() const {
  const MutexLock lock(&mutex_);
  return status_;
}

void DeviceHealth::Note(const absl::Status& answer) {
  if (!absl::IsUnavailable(answer)) return;
  const MutexLock lock(&mutex_);
  if (!status_.ok()) return;
  status_ = error::Unavailable(
      "DEVICE_LOST",
      fmt::format("the device of this server is lost until it is started again, call another: {}",
                  std::string(answer.message())),
      kRetryElsewhereMs);
  if (observer_ != nullptr) observer_(status_);
}

void DeviceHealth::SetObserver(Observer observer) {
  const MutexLock lock(&mutex_);
  observer_ = std::move(observer);
  if (observer_ != nullptr && !status_.ok()) observer_(status_);
}

}  // namespace latticed
