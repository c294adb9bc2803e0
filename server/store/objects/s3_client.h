// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Objects of a bucket. What may pass is tried again, after pauses that double up to two seconds: an answer 5xx or 429, a lost
// connection, a server that stands still. Each request may be sent again: a PUT has the same bytes. The time is bounded.
//
// Errors   kNotFound: there is no such object; kResourceExhausted, reason STORE: no room; kUnavailable, reason STORE: the
//          rest, in some words that name neither the server nor a key. The log names the bucket
// Threads  safe; each call waits for its answer
#ifndef LATTICED_SERVER_STORE_OBJECTS_S3_CLIENT_H_
#define LATTICED_SERVER_STORE_OBJECTS_S3_CLIENT_H_

#include <curl/curl.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/mutex.h"
#include "server/base/watched_file.h"
#include "server/store/objects/s3_options.h"
#include "server/store/objects/s3_request.h"

namespace latticed {

class S3Client {
 public:
  explicit S3Client(S3Options options);

  // With the keys of the file as it is now.
  S3Options CurrentOptions() ABSL_LOCKS_EXCLUDED(mutex_);
  // `sha256` is that of the bytes, in hex: the server refuses others.
  [[nodiscard]] absl::Status Put(std::string_view key, std::string_view bytes,
                                 std::string_view sha256) ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] absl::StatusOr<std::string> Get(std::string_view key) ABSL_LOCKS_EXCLUDED(mutex_);
  // The number of its bytes.
  [[nodiscard]] absl::StatusOr<uint64_t> Head(std::string_view key) ABSL_LOCKS_EXCLUDED(mutex_);
  // OK as well if there is none.
  [[nodiscard]] absl::Status Delete(std::string_view key) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Cleanup {
    void operator()(CURL* handle) const { curl_easy_cleanup(handle); }
  };
  using Handle = std::unique_ptr<CURL, Cleanup>;

  // The answer, unless it is an error.
  [[nodiscard]] absl::StatusOr<S3Answer> Send(const S3Request& request) ABSL_LOCKS_EXCLUDED(mutex_);
  Handle Take() ABSL_LOCKS_EXCLUDED(mutex_);
  void GiveBack(Handle handle) ABSL_LOCKS_EXCLUDED(mutex_);

  Mutex mutex_;
  S3Options options_ ABSL_GUARDED_BY(mutex_);
  WatchedFile keys_file_ ABSL_GUARDED_BY(mutex_);
  std::vector<Handle> unused_ ABSL_GUARDED_BY(mutex_);  // with connections
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_OBJECTS_S3_CLIENT_H_
