// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/http_answers.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "fmt/format.h"

namespace latticed::web {
namespace {

int HttpStatus(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::OK:
      return 200;
    case grpc::StatusCode::INVALID_ARGUMENT:
    case grpc::StatusCode::OUT_OF_RANGE:
    case grpc::StatusCode::FAILED_PRECONDITION:
      return 400;
    case grpc::StatusCode::UNAUTHENTICATED:
      return 401;
    case grpc::StatusCode::PERMISSION_DENIED:
      return 403;
    case grpc::StatusCode::NOT_FOUND:
      return 404;
    case grpc::StatusCode::ALREADY_EXISTS:
    case grpc::StatusCode::ABORTED:
      return 409;
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return 429;
    case grpc::StatusCode::UNIMPLEMENTED:
      return 501;
    case grpc::StatusCode::UNAVAILABLE:
      return 503;
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return 504;
    default:
      return 500;
  }
}

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
  HttpResponse answer = TextAnswer(405, "this address takes " + std::string(allowed) + " alone");
  answer.fields.push_back({"allow", std::string(allowed)});
  return answer;
}

HttpResponse FailureAnswer(const grpc::Status& status) {
  HttpResponse answer = TextAnswer(HttpStatus(status.error_code()), status.error_message());
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

}  // namespace latticed::web
