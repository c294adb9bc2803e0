// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Logs: one line per event, for people or as one JSON object, on standard error. An event is a
// message with fields; request ids and node names have the same names as in the metadata of
// replies. A thread of the log writes the lines, so no caller waits for a reader of standard error.
// At most kMostLogLines wait; then the oldest is dropped and counted.
//
// Threads  safe
#ifndef LATTICED_SERVER_BASE_TELEMETRY_H_
#define LATTICED_SERVER_BASE_TELEMETRY_H_

#include <cstdint>
#include <initializer_list>
#include <string_view>

#include <spdlog/spdlog.h>

#include "absl/time/time.h"
#include "server/base/log_line.h"

namespace latticed {

inline constexpr size_t kMostLogLines = 1'024;

// Sets up the process-wide logger; `format` is "text" or "json", `level` one of Options::log_level.
void ConfigureLogging(std::string_view level, std::string_view format);

// Changes the least level that is logged.
void SetLogLevel(std::string_view level);

// Lines dropped since the process began, because nobody read standard error as fast as it was written.
// The log says so as well, as soon as lines are written again.
[[nodiscard]] uint64_t DroppedLogLines();

// Writes the waiting lines and ends the log. Returns false if that takes longer than `patience`: nobody
// reads, and the process must end by std::_Exit, which does not wait for the log's thread.
[[nodiscard]] bool CloseLog(absl::Duration patience);

// Logs `message` with fields; those with an empty value are left out. Before ConfigureLogging
// nothing is logged: a server inside of another program is quiet.
void LogEvent(spdlog::level::level_enum level, std::string_view message,
              std::initializer_list<LogField> fields);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_TELEMETRY_H_
