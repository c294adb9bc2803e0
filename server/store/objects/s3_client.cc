// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/objects/s3_client.h"

#include <algorithm>
#include <random>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/store/store_errors.h"

namespace latticed {
namespace {

constexpr size_t kMostUnused = 8;
constexpr absl::Duration kLongestPause = absl::Seconds(2);

bool MayPass(const S3Answer& answer) {
  constexpr int64_t kTimeout = 408, kTooMany = 429, kNoRoom = 507, kServerError = 500;
  if (answer.no_memory) return false;
  return answer.status == 0 || answer.status == kTimeout || answer.status == kTooMany ||
         (answer.status >= kServerError && answer.status != kNoRoom);
}

absl::Status StatusOf(const S3Answer& answer) {
  constexpr int64_t kFirstError = 300, kNotFound = 404, kTooLarge = 413, kNoRoom = 507;
  if (answer.no_memory) return error::AllocationFailed("an object of the store");
  if (answer.status == 0) return error::StoreFailed(fmt::format("S3: {}", answer.problem));
  if (answer.status < kFirstError) return absl::OkStatus();
  const std::string problem =
      fmt::format("S3 answers {}{}{}", answer.status, answer.code.empty() ? "" : " ", answer.code);
  if (answer.status == kNotFound && answer.code != "NoSuchBucket") {
    return absl::NotFoundError(problem);
  }
  const bool full = answer.status == kNoRoom || answer.status == kTooLarge ||
                    answer.code == "QuotaExceeded" || answer.code == "EntityTooLarge";
  return full ? error::StoreFull(problem) : error::StoreFailed(problem);
}

// Many servers that were refused together do not come back together.
absl::Duration Jittered(absl::Duration pause) {
  thread_local std::minstd_rand random(std::random_device{}());
  return pause * std::uniform_real_distribution<>(0.5, 1.0)(random);
}

}  // namespace

S3Client::S3Client(S3Options options)
    : options_(std::move(options)), keys_file_(options_.keys_file) {
  static const CURLcode initialised = curl_global_init(CURL_GLOBAL_DEFAULT);
  (void)initialised;  // without it there are no handles
}

S3Options S3Client::CurrentOptions() {
  const MutexLock lock(&mutex_);
  if (keys_file_.Changed()) {
    if (const absl::Status status = ReadS3Keys(options_); !status.ok()) {
      LogEvent(spdlog::level::err, "the keys of the bucket stay as they were",
               {{"error", std::string(status.message())}});
    }
  }
  return options_;
}

absl::Status S3Client::Put(std::string_view key, std::string_view bytes, std::string_view sha256) {
  return Send({.method = S3Method::kPut, .key = key, .body = bytes, .sha256 = sha256}).status();
}

absl::StatusOr<std::string> S3Client::Get(std::string_view key) {
  LATTICED_ASSIGN_OR_RETURN(S3Answer answer, Send({.method = S3Method::kGet, .key = key}));
  return std::move(answer.body);
}

absl::StatusOr<uint64_t> S3Client::Head(std::string_view key) {
  LATTICED_ASSIGN_OR_RETURN(const S3Answer answer, Send({.method = S3Method::kHead, .key = key}));
  return answer.length;
}

absl::Status S3Client::Delete(std::string_view key) {
  const absl::Status status = Send({.method = S3Method::kDelete, .key = key}).status();
  return absl::IsNotFound(status) ? absl::OkStatus() : status;
}

absl::StatusOr<S3Answer> S3Client::Send(const S3Request& request) {
  S3Options options = CurrentOptions();
  const absl::Time end = absl::Now() + options.most_time;
  absl::Duration pause = options.first_pause;
  for (int tries = 1;; ++tries, pause = std::min(2 * pause, kLongestPause)) {
    Handle handle = Take();
    if (handle == nullptr) return error::AllocationFailed("a request to S3");
    S3Answer answer = SendToS3(handle.get(), options, request);
    GiveBack(std::move(handle));
    const absl::Status status = StatusOf(answer);
    if (status.ok()) return answer;
    if (absl::IsNotFound(status)) return status;
    LogEvent(spdlog::level::warn, "a request to the bucket of meshes failed",
             {{"bucket", options.Name()},
              {"key", std::string(request.key)},
              {"try", fmt::to_string(tries)},
              {"error", std::string(status.message())}});
    if (!MayPass(answer) || absl::Now() + pause > end) return status;
    absl::SleepFor(Jittered(pause));
    options = CurrentOptions();
  }
}

S3Client::Handle S3Client::Take() {
  {
    MutexLock lock(&mutex_);
    if (!unused_.empty()) {
      Handle handle = std::move(unused_.back());
      unused_.pop_back();
      return handle;
    }
  }
  return Handle(curl_easy_init());
}

void S3Client::GiveBack(Handle handle) {
  MutexLock lock(&mutex_);
  if (unused_.size() < kMostUnused) unused_.push_back(std::move(handle));
}

}  // namespace latticed
