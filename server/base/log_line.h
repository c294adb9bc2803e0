// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The text of a line of the log. Values come from files and clients, so what could forge or hide a line is
// replaced by spaces: control characters, ends of lines, and characters that turn the direction of text.
//
// Errors   none
// Threads  pure functions
#ifndef LATTICED_SERVER_BASE_LOG_LINE_H_
#define LATTICED_SERVER_BASE_LOG_LINE_H_

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace latticed {

using LogField = std::pair<std::string_view, std::string>;

inline constexpr size_t kMostLogValueBytes = 1'024;  // of a message or value; the rest is cut off

// The message and its fields as a line of a log in `format`, "text" or "json", shows them after time and level.
// Fields with an empty value are left out.
[[nodiscard]] std::string FormatEvent(std::string_view format, std::string_view message,
                                      std::initializer_list<LogField> fields);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_LOG_LINE_H_
