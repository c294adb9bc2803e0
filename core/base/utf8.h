// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes text from files and clients valid UTF-8. proto3 strings, JSON and gRPC messages must be
// valid; otherwise the whole message cannot be read.
//
// Errors   none
// Threads  pure functions
#ifndef LATTICED_CORE_BASE_UTF8_H_
#define LATTICED_CORE_BASE_UTF8_H_

#include <cstddef>
#include <string>
#include <string_view>

namespace latticed {

// The text with U+FFFD for every byte that is in no valid character: overlong forms, surrogates and
// numbers above U+10FFFF are not valid. Valid text comes back as it is.
[[nodiscard]] std::string ValidUtf8(std::string_view text);

// The first character of text that is valid and not empty.
[[nodiscard]] std::string_view FirstCharacter(std::string_view text);

// The longest prefix of valid text that has at most `most` bytes and ends between characters.
[[nodiscard]] std::string_view CutUtf8(std::string_view text, size_t most);

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_UTF8_H_
