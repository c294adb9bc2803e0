// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/objects/s3_options.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "absl/strings/ascii.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr std::string_view kScheme = "s3://";

// Such keys are the same in a URL, in a signature and for every server.
bool IsPlain(std::string_view text, std::string_view others) {
  return std::ranges::all_of(text, [others](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
           others.find(c) != std::string_view::npos;
  });
}

// Nothing else: a password, a path or a query has no place there.
bool IsEndpoint(std::string_view url) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!url.starts_with(scheme)) continue;
    url.remove_prefix(scheme.size());
    return !url.empty() && IsPlain(url, "-.:[]");
  }
  return false;
}

std::string FromEnvironment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

std::string S3Options::Name() const {
  return fmt::format("s3://{}/{} at {}", bucket, prefix, endpoint);
}

bool IsS3Url(std::string_view url) { return url.starts_with(kScheme); }

absl::StatusOr<S3Options> S3OptionsOf(std::string_view url, std::string endpoint,
                                      std::string region) {
  S3Options options{.endpoint = std::move(endpoint),
                    .region = std::move(region),
                    .access_key = FromEnvironment("AWS_ACCESS_KEY_ID"),
                    .secret_key = FromEnvironment("AWS_SECRET_ACCESS_KEY"),
                    .session_token = FromEnvironment("AWS_SESSION_TOKEN")};
  const std::string_view path = url.substr(std::min(kScheme.size(), url.size()));
  const size_t slash = std::min(path.find('/'), path.size());
  options.bucket = path.substr(0, slash);
  options.prefix = path.substr(std::min(slash + 1, path.size()));
  if (!options.prefix.empty() && !options.prefix.ends_with('/')) options.prefix += '/';
  if (!IsS3Url(url) || options.bucket.empty() || !IsPlain(options.bucket, "-.") ||
      !IsPlain(options.prefix, "-._/") || options.prefix.find("//") != std::string::npos ||
      options.prefix.starts_with('/') ||
      fmt::format("/{}", options.prefix).find("/.") != std::string::npos) {
    return absl::InvalidArgumentError(fmt::format(
        "'{}' is no bucket; write s3://BUCKET/PREFIX with letters, digits and - . _ /", url));
  }
  if (options.region.empty() || !IsPlain(options.region, "-")) {
    return absl::InvalidArgumentError("the region of the bucket has letters, digits and -");
  }
  if (options.endpoint.empty()) {
    options.endpoint = fmt::format("https://s3.{}.amazonaws.com", options.region);
  }
  if (!IsEndpoint(options.endpoint)) {
    return absl::InvalidArgumentError("the endpoint of the bucket is not https://host:port");
  }
  if (options.access_key.empty() || options.secret_key.empty()) {
    return absl::InvalidArgumentError(fmt::format(
        "'{}' needs AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY in the environment", url));
  }
  // A line break would end a header.
  if (!IsPlain(options.access_key, "-._:/+=") || !IsPlain(options.session_token, "-._/+=") ||
      !std::ranges::all_of(options.secret_key, [](char c) { return c > ' ' && c <= '~'; })) {
    return absl::InvalidArgumentError(
        "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY or AWS_SESSION_TOKEN has characters that no "
        "such key has");
  }
  return options;
}

}  // namespace latticed
