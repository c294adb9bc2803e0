// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/objects/s3_request.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/time/clock.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr size_t kMostErrorBytes = 64 << 10;  // servers send less than one KiB
constexpr size_t kMostCodeBytes = 64;
constexpr int64_t kFirstError =
    300;  // S3 redirects to other regions, which a signature does not allow
constexpr long kConnectSeconds = 3;
constexpr char kSha256OfNothing[] =
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
using Headers = std::unique_ptr<curl_slist, FreeList>;

bool Add(Headers& headers, const std::string& header) {
  curl_slist* longer = curl_slist_append(headers.get(), header.c_str());
  if (longer == nullptr) return false;
  (void)headers.release();
  headers.reset(longer);
  return true;
}

// What libcurl's callbacks know.
struct Transfer {
  CURL* handle;
  std::string_view unsent;
  std::string_view all;  // to begin again with
  absl::Duration patience;
  curl_off_t moved = 0;  // bytes, in both directions
  absl::Time last_move = absl::Now();
  S3Answer answer;
};

size_t Send(char* to, size_t /*one*/, size_t most, void* user) {
  auto& transfer = *static_cast<Transfer*>(user);
  const size_t count = std::min(most, transfer.unsent.size());
  std::memcpy(to, transfer.unsent.data(), count);
  transfer.unsent.remove_prefix(count);
  return count;
}

int Rewind(void* user, curl_off_t offset, int origin) {
  auto& transfer = *static_cast<Transfer*>(user);
  if (origin != SEEK_SET || offset < 0 || static_cast<size_t>(offset) > transfer.all.size()) {
    return CURL_SEEKFUNC_FAIL;
  }
  transfer.unsent = transfer.all.substr(static_cast<size_t>(offset));
  return CURL_SEEKFUNC_OK;
}

size_t Receive(char* from, size_t /*one*/, size_t count, void* user) {
  S3Answer& answer = static_cast<Transfer*>(user)->answer;
  CURL* const handle = static_cast<Transfer*>(user)->handle;
  long status = 0;
  curl_off_t length = -1;
  curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
  curl_easy_getinfo(handle, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
  const bool is_error = status >= kFirstError;
  if (is_error && answer.body.size() + count > kMostErrorBytes) return count;
  try {
    if (!is_error && answer.body.empty() && length > 0) {
      answer.body.reserve(static_cast<size_t>(length));  // so that it is in memory once
    }
    answer.body.append(from, count);
  } catch (const std::exception&) {
    answer.no_memory = true;
    return 0;
  }
  return count;
}

// libcurl calls it at least once a second.
int Watch(void* user, curl_off_t, curl_off_t received, curl_off_t, curl_off_t sent) {
  auto& transfer = *static_cast<Transfer*>(user);
  const absl::Time now = absl::Now();
  if (std::exchange(transfer.moved, received + sent) != received + sent) transfer.last_move = now;
  return now - transfer.last_move > transfer.patience ? 1 : 0;
}

// <Error><Code>NoSuchBucket</Code>…: a word, or nothing. The rest may have parts of the request.
std::string CodeOf(std::string_view body) {
  constexpr std::string_view kBegin = "<Code>", kEnd = "</Code>";
  const size_t begin = body.find(kBegin);
  if (begin == std::string_view::npos) return "";
  body.remove_prefix(begin + kBegin.size());
  const std::string_view code = body.substr(0, std::min(body.find(kEnd), kMostCodeBytes));
  const auto is_letter = [](char c) { return absl::ascii_isalnum(static_cast<unsigned char>(c)); };
  return std::ranges::all_of(code, is_letter) ? std::string(code) : "";
}

void SetMethod(CURL* handle, const S3Request& request) {
  switch (request.method) {
    case S3Method::kPut:
      curl_easy_setopt(handle, CURLOPT_UPLOAD, 1L);
      curl_easy_setopt(handle, CURLOPT_INFILESIZE_LARGE,
                       static_cast<curl_off_t>(request.body.size()));
      break;
    case S3Method::kGet:
      break;
    case S3Method::kHead:
      curl_easy_setopt(handle, CURLOPT_NOBODY, 1L);
      break;
    case S3Method::kDelete:
      curl_easy_setopt(handle, CURLOPT_CUSTOMREQUEST, "DELETE");
      break;
  }
}

void SetOptions(CURL* handle, const S3Options& options, const std::string& url) {
  curl_easy_reset(handle);  // connections stay
  curl_easy_setopt(handle, CURLOPT_URL, url.c_str());
  curl_easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(handle, CURLOPT_HTTP_VERSION, CURL_HTTP_VERSION_1_1);
  curl_easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(handle, CURLOPT_AWS_SIGV4, fmt::format("aws:amz:{}:s3", options.region).c_str());
  curl_easy_setopt(handle, CURLOPT_USERNAME, options.access_key.c_str());
  curl_easy_setopt(handle, CURLOPT_PASSWORD, options.secret_key.c_str());
  curl_easy_setopt(handle, CURLOPT_CONNECTTIMEOUT, kConnectSeconds);
  curl_easy_setopt(handle, CURLOPT_NOPROGRESS, 0L);
}

}  // namespace

S3Answer SendToS3(CURL* handle, const S3Options& options, const S3Request& request) {
  Transfer transfer{
      .handle = handle, .unsent = request.body, .all = request.body, .patience = options.patience};
  S3Answer& answer = transfer.answer;
  SetOptions(
      handle, options,
      fmt::format("{}/{}/{}{}", options.endpoint, options.bucket, options.prefix, request.key));
  SetMethod(handle, request);
  Headers headers;
  answer.no_memory =
      !Add(headers, fmt::format("x-amz-content-sha256: {}",
                                request.body.empty() ? kSha256OfNothing : request.sha256)) ||
      (!options.session_token.empty() &&
       !Add(headers, fmt::format("x-amz-security-token: {}", options.session_token)));
  if (answer.no_memory) return std::move(answer);
  curl_easy_setopt(handle, CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(handle, CURLOPT_READFUNCTION, &Send);
  curl_easy_setopt(handle, CURLOPT_READDATA, &transfer);
  curl_easy_setopt(handle, CURLOPT_SEEKFUNCTION, &Rewind);
  curl_easy_setopt(handle, CURLOPT_SEEKDATA, &transfer);
  curl_easy_setopt(handle, CURLOPT_WRITEFUNCTION, &Receive);
  curl_easy_setopt(handle, CURLOPT_WRITEDATA, &transfer);
  curl_easy_setopt(handle, CURLOPT_XFERINFOFUNCTION, &Watch);
  curl_easy_setopt(handle, CURLOPT_XFERINFODATA, &transfer);
  const CURLcode code = curl_easy_perform(handle);
  if (code != CURLE_OK) {
    answer.problem =
        code == CURLE_ABORTED_BY_CALLBACK
            ? fmt::format("it stood still for {}", absl::FormatDuration(options.patience))
            : curl_easy_strerror(code);
    return std::move(answer);
  }
  curl_off_t length = 0;
  long status = 0;
  curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
  curl_easy_getinfo(handle, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
  answer.status = status;
  answer.length = static_cast<uint64_t>(std::max<curl_off_t>(length, 0));
  if (status >= kFirstError) {
    answer.code = CodeOf(answer.body);
    answer.body.clear();
  }
  return std::move(answer);
}

}  // namespace latticed
