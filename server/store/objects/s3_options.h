// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A bucket, and how it is reached.
#ifndef LATTICED_SERVER_STORE_OBJECTS_S3_OPTIONS_H_
#define LATTICED_SERVER_STORE_OBJECTS_S3_OPTIONS_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace latticed {

struct S3Options {
  std::string bucket;
  std::string prefix;    // of all keys; empty, or with / at its end
  std::string endpoint;  // https://host:port. The bucket is the first part of the path
  std::string region;
  std::string access_key;
  std::string secret_key;
  std::string session_token;  // empty: the keys need none
  std::string keys_file;      // that has those three, and may be replaced; empty: they stay
  // A request that moves no byte for so long has failed. Large objects take servers a while.
  absl::Duration patience = absl::Seconds(15);
  absl::Duration first_pause = absl::Milliseconds(100);  // before a second try
  absl::Duration most_time = absl::Seconds(30);          // after which no new try begins

  // For people: the bucket, the prefix and the endpoint.
  std::string Name() const;
};

// Whether it is s3://….
[[nodiscard]] bool IsS3Url(std::string_view url);
// `url` is s3://BUCKET or s3://BUCKET/PREFIX. The keys are those of the environment: AWS_ACCESS_KEY_ID,
// AWS_SECRET_ACCESS_KEY and, if it is there, AWS_SESSION_TOKEN; without the first, those of the file that
// AWS_SHARED_CREDENTIALS_FILE names. An empty `endpoint` is Amazon's in the region.
// kInvalidArgument, without repeating the endpoint or a key; kNotFound: the file cannot be read.
[[nodiscard]] absl::StatusOr<S3Options> S3OptionsOf(std::string_view url, std::string endpoint,
                                                    std::string region);
// Reads the keys of section [default] of options.keys_file. An error, as above, leaves all as it was.
[[nodiscard]] absl::Status ReadS3Keys(S3Options& options);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_OBJECTS_S3_OPTIONS_H_
