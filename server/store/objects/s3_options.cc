// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/objects/s3_options.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_split.h"
#include "core/base/read_file.h"
#include "core/base/status_macros.h"
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

// A line break would end a header.
absl::Status CheckKeys(const S3Options& options, std::string_view where) {
  if (IsPlain(options.access_key, "-._:/+=") && IsPlain(options.session_token, "-._/+=") &&
      std::ranges::all_of(options.secret_key, [](char c) { return c > ' ' && c <= '~'; })) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(fmt::format("{} has characters that no such key has", where));
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
  options.keys_file =
      options.access_key.empty() ? FromEnvironment("AWS_SHARED_CREDENTIALS_FILE") : "";
  if (!options.keys_file.empty()) {
    LATTICED_RETURN_IF_ERROR(ReadS3Keys(options));
  } else if (options.access_key.empty() || options.secret_key.empty()) {
    return absl::InvalidArgumentError(fmt::format(
        "'{}' needs AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY in the environment, or a file of "
        "keys in AWS_SHARED_CREDENTIALS_FILE",
        url));
  }
  LATTICED_RETURN_IF_ERROR(
      CheckKeys(options, "AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY or AWS_SESSION_TOKEN"));
  return options;
}

absl::Status ReadS3Keys(S3Options& options) {
  LATTICED_ASSIGN_OR_RETURN(const std::string text, ReadFile(options.keys_file));
  S3Options read;
  bool in_default = false;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    const absl::string_view stripped = absl::StripAsciiWhitespace(line);
    if (absl::StartsWith(stripped, "[")) in_default = stripped == "[default]";
    const std::pair<absl::string_view, absl::string_view> entry =
        absl::StrSplit(stripped, absl::MaxSplits('=', 1));
    const absl::string_view name = absl::StripAsciiWhitespace(entry.first);
    const std::string value(absl::StripAsciiWhitespace(entry.second));
    if (!in_default) continue;
    if (name == "aws_access_key_id") read.access_key = value;
    if (name == "aws_secret_access_key") read.secret_key = value;
    if (name == "aws_session_token") read.session_token = value;
  }
  if (read.access_key.empty() || read.secret_key.empty()) {
    return absl::InvalidArgumentError(
        fmt::format("{}: section [default] needs aws_access_key_id and aws_secret_access_key",
                    options.keys_file));
  }
  LATTICED_RETURN_IF_ERROR(CheckKeys(read, options.keys_file));
  options.access_key = std::move(read.access_key);
  options.secret_key = std::move(read.secret_key);
  options.session_token = std::move(read.session_token);
  return absl::OkStatus();
}

}  // namespace latticed
