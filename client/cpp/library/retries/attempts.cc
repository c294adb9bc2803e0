// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/retries/attempts.h"

#include <algorithm>
#include <random>
#include <string_view>

#include "absl/time/clock.h"
#include "core/base/error.h"

namespace latticed::client {
namespace {

constexpr absl::Duration kFirstPause = absl::Milliseconds(100);
constexpr absl::Duration kLongestPause = absl::Seconds(1);
constexpr int kMostDoublings = 4;  // more would pass the longest pause
constexpr double kLeastJitter = 0.75, kMostJitter = 1.25;
constexpr int kToldAfter = 2;  // failures; one is usual where a proxy cuts connections

absl::Duration JitteredPause(int failures) {
  static thread_local std::minstd_rand random(std::random_device{}());
  const int doublings = std::min(failures - 1, kMostDoublings);
  return std::min(kFirstPause * (1 << doublings), kLongestPause) *
         std::uniform_real_distribution(kLeastJitter, kMostJitter)(random);
}

// gRPC tells these causes only in its messages.
bool IsPermanent(std::string_view message) {
  const auto says = [message](std::string_view part) { return message.find(part) != part.npos; };
  return says("http1.x server") || says("wrong version number") || says("empty address list") ||
         says("CERTIFICATE_VERIFY_FAILED");
}

}  // namespace

bool MayRetry(const absl::Status& status) {
  if (absl::IsInternal(status) || absl::IsUnknown(status)) {
    return !error::DetailsOf(status).metadata.contains("request_id");
  }
  if (absl::IsUnavailable(status)) {
    return !IsPermanent(std::string_view(status.message().data(), status.message().size()));
  }
  return absl::IsCancelled(status);
}

std::optional<absl::Duration> Attempts::PauseAfter(const absl::Status& failure) {
  if (!MayRetry(failure)) {
    Succeeded();  // the server has answered
    return std::nullopt;
  }
  const absl::Time now = absl::Now();
  if (++failures_ == 1) first_failure_ = now;
  const absl::Duration pause = JitteredPause(failures_);
  if (now + pause > first_failure_ + server_->retry_for()) {
    server_->GaveUp();
    return std::nullopt;
  }
  if (failures_ >= kToldAfter) server_->Lost(failure);
  return pause;
}

void Attempts::Succeeded() {
  failures_ = 0;
  server_->Found();
}

}  // namespace latticed::client
