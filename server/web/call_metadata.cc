// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/call_metadata.h"

#include <algorithm>
#include <array>
#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "core/base/error.h"
#include "fmt/format.h"
#include "server/web/http_answers.h"

namespace latticed::web {
namespace {

// The metadata keys that the server reads (server/rpc/call.cc).
constexpr std::array<std::string_view, 5> kRead = {
    "authorization", "latticed-request-id", "latticed-scene", "traceparent", "x-forwarded-for"};

bool IsMessageCharacter(char c) { return c >= ' ' && c <= '~' && c != '%'; }

}  // namespace

absl::StatusOr<CallMetadata> ToMetadata(const HttpFields& fields) {
  CallMetadata metadata;
  for (const HttpField& field : fields) {
    if (std::ranges::find(kRead, field.name) == kRead.end()) continue;
    if (!std::ranges::all_of(field.value, absl::ascii_isprint)) {
      return error::InvalidField(field.name, "must be printable ASCII");
    }
    metadata.push_back(field);
  }
  return metadata;
}

HttpFields ToFields(const CallMetadata& metadata) {
  HttpFields fields = metadata;
  std::erase_if(fields,
                [](const HttpField& field) { return !field.name.starts_with("latticed-"); });
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

absl::StatusOr<absl::Time> DeadlineOf(std::string_view timeout, absl::Time now) {
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
