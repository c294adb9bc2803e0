// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One request to a server of S3, signed by libcurl (AWS Signature Version 4), without a query.
//
//   Signed are host, x-amz-date, x-amz-content-sha256 and, if there is one, x-amz-security-token. libcurl signs an empty
//   Expect: header too, which a proxy may drop, so none is set.
//
// Threads  one at a time for each handle
#ifndef LATTICED_SERVER_STORE_OBJECTS_S3_REQUEST_H_
#define LATTICED_SERVER_STORE_OBJECTS_S3_REQUEST_H_

#include <curl/curl.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "server/store/objects/s3_options.h"

namespace latticed {

enum class S3Method { kPut, kGet, kHead, kDelete };

struct S3Request {
  S3Method method;
  std::string_view key;
  std::string_view body;    // of kPut. It is sent from where it is
  std::string_view sha256;  // of the body, in hex
};

struct S3Answer {
  int64_t status = 0;      // of HTTP; 0: there is no answer
  std::string problem;     // why there is none
  bool no_memory = false;  // for the answer
  std::string body;        // of kGet
  std::string code;        // of an error: NoSuchBucket
  uint64_t length = 0;     // that kHead was told
};

// `handle` may keep its connection for the next request.
[[nodiscard]] S3Answer SendToS3(CURL* handle, const S3Options& options, const S3Request& request);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_OBJECTS_S3_REQUEST_H_
