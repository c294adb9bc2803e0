// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/http_answers.h"

#include <algorithm>
#include <array>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed::web {
namespace {

// The HTTP status for each grpc::StatusCode, from OK (0) to UNAUTHENTICATED (16).
constexpr std::array<int, 17> kHttpStatus = {200, 500, 500, 400, 504, 404, 409, 403, 429,
                                             400, 409, 400, 501, 500, 503, 500, 401};

}  // namespace

std::string_view HttpRequest::Field(std::string_view name) const {
  const auto found =
      std::ranges::find_if(fields, [&](const HttpField& field) { return field.name == name; });
  return found == fields.end() ? std::string_view() : found->value;
}

HttpResponse TextAnswer(int status, std::string_view text) {
  return {.status = status,
          .fields = {{"content-type", "text/plain; charset=utf-8"},
                     {"x-content-type-options", "nosniff"},
                     {"cache-control", "no-store"}},
          .body = std::string(text) + "\n"};
}

HttpResponse MethodNotAllowed(std::string_view allowed) {
  HttpResponse answer = TextAnswer(405, "this address accepts only " + std::string(allowed));
  answer.fields.push_back({"allow", std::string(allowed)});
  return answer;
}

HttpResponse FailureAnswer(const grpc::Status& status) {
  HttpResponse answer =
      TextAnswer(kHttpStatus[static_cast<size_t>(status.error_code())], status.error_message());
  if (answer.status == 401) answer.fields.push_back({"www-authenticate", "Bearer"});
  return answer;
}

void Append(const HttpFields& more, HttpFields& fields) {
  fields.insert(fields.end(), more.begin(), more.end());
}

std::string PercentEncode(std::string_view text, bool (*is_plain)(char)) {
  std::string result;
  for (const char c : text) {
    result +=
        is_plain(c) ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return result;
}

bool PercentDecode(std::string_view text, std::string* decoded) {
  decoded->clear();
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded->push_back(text[i]);
      continue;
    }
    const std::string digits(text.substr(i + 1, 2));
    if (digits.size() != 2 || !absl::ascii_isxdigit(static_cast<unsigned char>(digits[0])) ||
        !absl::ascii_isxdigit(static_cast<unsigned char>(digits[1]))) {
      return false;
    }
    const std::string byte = absl::HexStringToBytes(digits);
    if (byte[0] == '\0') return false;
    *decoded += byte;
    i += 2;
  }
  return true;
}

absl::StatusOr<HttpFields> QueryParameters(const std::string& query,
                                           std::span<const std::string_view> known) {
  HttpFields parameters;
  for (const auto pair : absl::StrSplit(query, '&', absl::SkipEmpty())) {
    const std::string text(pair);
    const size_t equals = std::min(text.find('='), text.size());
    const std::string name = text.substr(0, equals);
    if (std::ranges::find(known, name) == known.end()) {
      return error::InvalidField(
          "query", fmt::format("'{}' is not a parameter; known: {}", name, fmt::join(known, ", ")));
    }
    if (std::ranges::find(parameters, name, &HttpField::name) != parameters.end()) {
      return error::InvalidField("query", fmt::format("'{}' is given twice", name));
    }
    std::string value;
    if (equals == text.size() || !PercentDecode(text.substr(equals + 1), &value)) {
      return error::InvalidField("query", fmt::format("'{}' has no value that can be read", text));
    }
    parameters.push_back({name, value});
  }
  return parameters;
}

}  // namespace latticed::web
