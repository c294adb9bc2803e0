// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/log_line.h"

#include <nlohmann/json.hpp>

#include "core/base/utf8.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Whether a character could forge or hide a line: C0 and C1 controls, DEL, the ends of lines and paragraphs
// (U+2028, U+2029), and the marks and overrides of direction (U+061C, U+200E, U+200F, U+202A to U+202E,
// U+2066 to U+2069).
bool IsHidden(std::string_view c) {
  if (c.size() == 1) return static_cast<unsigned char>(c[0]) < ' ' || c[0] == '\x7F';
  const auto in = [c](std::string_view first, std::string_view last) {
    return c.size() == first.size() && first <= c && c <= last;
  };
  return in("\xC2\x80", "\xC2\x9F") || c == "\xD8\x9C" || in("\xE2\x80\x8E", "\xE2\x80\x8F") ||
         in("\xE2\x80\xA8", "\xE2\x80\xAE") || in("\xE2\x81\xA6", "\xE2\x81\xA9");
}

std::string Printable(std::string_view value) {
  const std::string valid = ValidUtf8(value);
  std::string_view text = CutUtf8(valid, kMostLogValueBytes);
  std::string result;
  while (!text.empty()) {
    const std::string_view character = FirstCharacter(text);
    result += IsHidden(character) ? " " : character;
    text.remove_prefix(character.size());
  }
  return result;
}

std::string ToJson(const nlohmann::ordered_json& value) { return value.dump(); }

std::string QuotedWhereNeeded(const std::string& value) {
  return value.find_first_of(" =\"") == std::string::npos ? value : ToJson(value);
}

}  // namespace

std::string FormatEvent(std::string_view format, std::string_view message,
                        std::initializer_list<LogField> fields) {
  const bool is_json = format == "json";
  std::string text = Printable(message);
  nlohmann::ordered_json object = {{"message", text}};
  for (const auto& [name, value] : fields) {
    if (value.empty()) continue;
    std::string printable = Printable(value);
    if (is_json) {
      object[std::string(name)] = std::move(printable);
    } else {
      text += fmt::format(" {}={}", name, QuotedWhereNeeded(printable));
    }
  }
  return is_json ? ToJson(object).substr(1) : text;
}

}  // namespace latticed
