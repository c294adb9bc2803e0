// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/store_errors.h"

#include <string>

#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed::error {
namespace {

constexpr char kStoreReason[] = "STORE";
constexpr uint32_t kRetryBusyMs = 100;  // in which time a disk takes the bytes that may wait
constexpr uint32_t kRetryFailedMs = 1'000;
constexpr uint32_t kRetryMovedMs = 20;  // as fast as a call without waste

absl::Status OfStore(absl::StatusCode code, std::string message, uint32_t retry_after_ms) {
  return WithDetails(absl::Status(code, message),
                     {.reason = kStoreReason, .retry_after_ms = retry_after_ms});
}

}  // namespace

absl::Status StoreFull(std::string_view problem) {
  return OfStore(absl::StatusCode::kResourceExhausted,
                 fmt::format("the store has no room: {}", problem), kRetryFailedMs);
}

absl::Status StoreBusy(uint64_t waiting_bytes, uint64_t most_bytes) {
  return OfStore(
      absl::StatusCode::kResourceExhausted,
      fmt::format(
          "the store is slow: {} bytes wait to be written, at most {} may; try again in {} ms",
          waiting_bytes, most_bytes, kRetryBusyMs),
      kRetryBusyMs);
}

absl::Status StoreFailed(std::string_view problem) {
  return OfStore(absl::StatusCode::kUnavailable, fmt::format("the store fails: {}", problem),
                 kRetryFailedMs);
}

absl::Status Damaged(std::string_view what, std::string_view problem) {
  return OfStore(absl::StatusCode::kDataLoss, fmt::format("{} is damaged: {}", what, problem), 0);
}

absl::Status NotNextRecord(std::string_view scene, uint64_t next, uint64_t got) {
  return absl::FailedPreconditionError(
      fmt::format("scene '{}': record {} was appended where {} is next", scene, got, next));
}

absl::Status SceneNotOwned(std::string_view scene) {
  return OfStore(absl::StatusCode::kAborted,
                 fmt::format("scene '{}': this server does not own it", scene), kRetryBusyMs);
}

absl::Status RecordInDoubt(std::string_view scene) {
  return OfStore(
      absl::StatusCode::kAborted,
      fmt::format("scene '{}': the store does not know whether it has the record", scene),
      kRetryBusyMs);
}

absl::Status SceneMoved(std::string_view owner) {
  return WithDetails(
      absl::UnavailableError(fmt::format("the scene is on another server{}{}: call it there",
                                         owner.empty() ? "" : ", ", owner)),
      {.reason = kSceneMovedReason,
       .metadata = {{"owner", std::string(owner)}},
       .retry_after_ms = kRetryMovedMs});
}

bool IsSceneMoved(const absl::Status& status) {
  return absl::IsUnavailable(status) && DetailsOf(status).reason == kSceneMovedReason;
}

bool IsOfMedium(const absl::Status& status) {
  return !status.ok() && !absl::IsNotFound(status) && !absl::IsAlreadyExists(status) &&
         !absl::IsFailedPrecondition(status) && !absl::IsAborted(status);
}

}  // namespace latticed::error
