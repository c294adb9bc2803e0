// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/geometry/outside_text.h"

#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

absl::Status NotOutside(const std::string& text) {
  return absl::InvalidArgumentError(fmt::format(
      "'{}' is not fixed, linear, linear:WIDTH, falloff:WIDTH or falloff:WIDTH:c0, with one width "
      "or six such as 0,0.5,0,0,0,0",
      text));
}

bool ParseWidths(const std::string& text, v1::LatticeOutside* outside) {
  const std::vector<std::string> words = absl::StrSplit(text, ',');
  for (const std::string& word : words) {
    double width = 0;
    if (!absl::SimpleAtod(word, &width)) return false;
    outside->add_widths(width);
  }
  return words.size() == 1 || words.size() == 6;
}

}  // namespace

absl::StatusOr<v1::LatticeOutside> ParseOutside(const std::string& text) {
  const std::vector<std::string> parts = absl::StrSplit(text, ':');
  v1::LatticeOutside outside;
  if (text == "fixed") {
    outside.set_mode(v1::OUTSIDE_MODE_FIXED);
    return outside;
  }
  if (parts[0] == "linear" && parts.size() <= 2) {
    outside.set_mode(v1::OUTSIDE_MODE_LINEAR);
    if (parts.size() == 1 || ParseWidths(parts[1], &outside)) return outside;
    return NotOutside(text);
  }
  if (parts[0] != "falloff" || parts.size() < 2 || parts.size() > 3) return NotOutside(text);
  outside.set_mode(v1::OUTSIDE_MODE_FALLOFF);
  const std::string continuity = parts.size() == 3 ? parts[2] : "c1";
  if (!ParseWidths(parts[1], &outside) || (continuity != "c0" && continuity != "c1")) {
    return NotOutside(text);
  }
  outside.set_continuity(continuity == "c0" ? v1::OUTSIDE_CONTINUITY_C0
                                            : v1::OUTSIDE_CONTINUITY_C1);
  return outside;
}

std::string CheckOutside(const std::string& text) {
  const auto outside = ParseOutside(text);
  return outside.ok() ? "" : std::string(outside.status().message());
}

}  // namespace latticed::client
