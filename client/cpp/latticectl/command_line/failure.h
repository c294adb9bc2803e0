// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a command prints when it fails: one line, for people or as JSON. Empty members are left out.
//
//   latticectl: MESSAGE; ADVICE (REASON, request ID)
//   {"error":{"message":"…","advice":"…","reason":"…","code":"…","field":"…","requestId":"…"}}
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_FAILURE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_FAILURE_H_

#include <iosfwd>
#include <string>

#include "absl/status/status.h"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace latticed::client {

// The key of error::Details::metadata whose value is advice that a command gives.
inline constexpr char kAdviceKey[] = "advice";

struct Failure {
  std::string message;
  std::string advice;      // how a user can get past it
  std::string reason;      // UPPER_SNAKE_CASE, of latticed.v1.ErrorReason; empty for wrong usage
  std::string code;        // of absl::StatusCode, such as NOT_FOUND
  std::string field;       // of the request, as the server names it
  std::string request_id;  // in the server's log
};

// The failure of a command of `app` that was run. Its message names options where the status names fields.
[[nodiscard]] Failure FailureOf(const absl::Status& status, const CLI::App& app);
// The failure to parse a command line of `app`. It names a misspelt command or option, and the one that was meant.
[[nodiscard]] Failure FailureOf(const CLI::ParseError& error, const CLI::App& app);

// Prints one line, "latticectl: MESSAGE" or {"notice":{"message":"…"}}, at once: the command goes on.
void PrintNotice(const std::string& message, bool as_json, std::ostream& err);
void PrintFailure(const Failure& failure, bool as_json, std::ostream& err);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_FAILURE_H_
