// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Logs: one line per event, for people or as one JSON object, on standard error. An event is a
// message with fields; request ids and node names have the same names as in the metadata of
// replies.
//
// Threads  safe
#ifndef LATTICED_SERVER_BASE_TELEMETRY_H_
#define LATTICED_SERVER_BASE_TELEMETRY_H_

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include <spdlog/spdlog.h>

namespace latticed {

using LogField = std::pair<std::string_view, std::string>;

// Sets up the process-wide logger; `format` is "text" or "json", `level` one of Options::log_level.
void ConfigureLogging(std::string_view level, std::string_view format);

// Logs `message` with fields; those with an empty value are left out. Before ConfigureLogging
// nothing is logged: a server inside of another program is quiet.
void LogEvent(spdlog::level::level_enum level, std::string_view message,
              std::initializer_list<LogField> fields);

// The message and its fields as a line of a log in `format` shows them, after time and level.
[[nodiscard]] std::string FormatEvent(std::string_view format, std::string_view message,
                                      std::initializer_list<LogField> fields);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_TELEMETRY_H_
