// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Answers that several handlers give, and addresses as they read them.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_WEB_HTTP_ANSWERS_H_
#define LATTICED_SERVER_WEB_HTTP_ANSWERS_H_

#include <grpcpp/support/status.h>

#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/web/http_exchange.h"

namespace latticed::web {

// A sentence for people.
[[nodiscard]] HttpResponse TextAnswer(int status, std::string_view text);
// 405 with what is allowed, such as "GET, HEAD".
[[nodiscard]] HttpResponse MethodNotAllowed(std::string_view allowed);
// The closest HTTP status for the status of an rpc, with its message.
[[nodiscard]] HttpResponse FailureAnswer(const grpc::Status& status);

void Append(const HttpFields& more, HttpFields& fields);

// A -> %41 for every character that is not plain.
[[nodiscard]] std::string PercentEncode(std::string_view text, bool (*is_plain)(char));

// %41 -> A; false for a malformed escape or for NUL.
[[nodiscard]] bool PercentDecode(std::string_view text, std::string* decoded);

// The query of an address, behind the '?', such as "segments=20&normals=smooth": names with their
// values unescaped, in order. kInvalidArgument for a name that is not among `known`,
// and for a value that is missing or escaped wrongly.
[[nodiscard]] absl::StatusOr<HttpFields> QueryParameters(const std::string& query,
                                                         std::span<const std::string_view> known);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_HTTP_ANSWERS_H_
