// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/call_metadata.h"

#include <grpc/grpc.h>
#include <grpc/slice.h>

#include <algorithm>
#include <array>
#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "core/base/error.h"
#include "fmt/format.h"
#include "server/web/http_answers.h"

namespace latticed::web {
namespace {

// Of the connection, the browser or the body; the rest is the application's.
constexpr std::array<std::string_view, 24> kNotMetadata = {"host",
                                                           "connection",
                                                           "keep-alive",
                                                           "transfer-encoding",
                                                           "te",
                                                           "trailer",
                                                           "upgrade",
                                                           "content-type",
                                                           "content-length",
                                                           "content-encoding",
                                                           "accept",
                                                           "accept-encoding",
                                                           "accept-language",
                                                           "accept-charset",
                                                           "expect",
                                                           "user-agent",
                                                           "origin",
                                                           "referer",
                                                           "cookie",
                                                           "cache-control",
                                                           "pragma",
                                                           "priority",
                                                           "dnt",
                                                           "x-grpc-web"};

bool IsMetadata(std::string_view name) {
  if (name.starts_with("grpc-") || name.starts_with("sec-") || name.starts_with("proxy-") ||
      name.starts_with("access-control-")) {
    return false;
  }
  return std::ranges::find(kNotMetadata, name) == kNotMetadata.end();
}

bool IsBinary(std::string_view name) { return name.ends_with("-bin"); }

grpc_slice Slice(const std::string& text) {
  return grpc_slice_from_static_buffer(text.data(), text.size());
}

bool IsLegal(const std::string& name, const std::string& value) {
  return grpc_header_key_is_legal(Slice(name)) != 0 &&
         (IsBinary(name) || grpc_header_nonbin_value_is_legal(Slice(value)) != 0);
}

bool IsMessageCharacter(char c) { return c >= ' ' && c <= '~' && c != '%'; }

}  // namespace

absl::StatusOr<CallMetadata> ToMetadata(const HttpFields& fields) {
  CallMetadata metadata;
  for (const HttpField& field : fields) {
    if (!IsMetadata(field.name)) continue;
    std::string value = field.value;
    const bool decoded = !IsBinary(field.name) || absl::Base64Unescape(field.value, &value);
    if (!decoded || !IsLegal(field.name, value)) {
      return error::InvalidField(field.name, IsBinary(field.name)
                                                 ? "is no base64"
                                                 : "holds what metadata cannot: printable ASCII");
    }
    metadata.emplace_back(field.name, std::move(value));
  }
  return metadata;
}

HttpFields ToFields(const CallMetadata& metadata) {
  HttpFields fields;
  for (const auto& [name, value] : metadata) {
    if (name.starts_with("grpc-") || name == "content-type" || name == "user-agent") continue;
    fields.push_back({name, IsBinary(name) ? absl::Base64Escape(value) : value});
  }
  return fields;
}

HttpFields StatusFields(const grpc::Status& status) {
  HttpFields fields = {{"grpc-status", fmt::to_string(static_cast<int>(status.error_code()))}};
  if (!status.error_message().empty()) {
    fields.push_back({"grpc-message", PercentEncode(status.error_message(), IsMessageCharacter)});
  }
  if (!status.error_details().empty()) {
    fields.push_back({"grpc-status-details-bin", absl::Base64Escape(status.error_details())});
  }
  return fields;
}

absl::StatusOr<absl::Time> Deadline(std::string_view timeout, absl::Time now) {
  constexpr size_t kMaxDigits = 8;
  constexpr std::array<std::pair<char, absl::Duration>, 6> kUnits = {{{'H', absl::Hours(1)},
                                                                      {'M', absl::Minutes(1)},
                                                                      {'S', absl::Seconds(1)},
                                                                      {'m', absl::Milliseconds(1)},
                                                                      {'u', absl::Microseconds(1)},
                                                                      {'n', absl::Nanoseconds(1)}}};
  if (timeout.empty()) return absl::InfiniteFuture();
  const std::string digits(timeout.substr(0, timeout.size() - 1));
  const auto* const unit = std::ranges::find_if(
      kUnits, [&](const auto& known) { return known.first == timeout.back(); });
  int64_t count = 0;
  const bool numeric = !digits.empty() && digits.size() <= kMaxDigits &&
                       digits.find_first_not_of("0123456789") == std::string::npos &&
                       absl::SimpleAtoi(digits, &count);
  if (!numeric || unit == kUnits.end()) {
    return error::InvalidField("grpc-timeout", "must be 1 to 8 digits and one of H M S m u n");
  }
  return now + count * unit->second;
}

}  // namespace latticed::web
