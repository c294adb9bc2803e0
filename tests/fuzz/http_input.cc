// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/http_input.h"

#include <algorithm>

#include "absl/strings/ascii.h"

namespace latticed::fuzz {
namespace {

constexpr std::string_view kCut = "<cut>";
constexpr std::string_view kHeadEnd = "\r\n\r\n";
constexpr std::string_view kLength = "content-length: ";
constexpr size_t kMostPieces = 16;
constexpr size_t kPrefixBytes = 5;  // of a frame: flags, and a length of 32 bits

}  // namespace

std::vector<std::string_view> Pieces(std::string_view input) {
  std::vector<std::string_view> pieces;
  while (!input.empty()) {
    const bool last = pieces.size() + 1 == kMostPieces;
    const size_t end = last ? input.size() : std::min(input.find(kCut), input.size());
    pieces.push_back(input.substr(0, end));
    input.remove_prefix(std::min(input.size(), end + kCut.size()));
  }
  return pieces;
}

std::string WithTrueLengths(std::string_view input) {
  const size_t head_end = input.find(kHeadEnd);
  if (head_end == std::string_view::npos) return std::string(input);
  std::string head(input.substr(0, head_end + kHeadEnd.size()));
  std::string body(input.substr(head.size()));
  const size_t end = std::min(body.find(kCut), body.size());
  const std::string lower = absl::AsciiStrToLower(head);
  if (lower.find("grpc-web") != std::string::npos && end >= kPrefixBytes) {
    const size_t bytes = end - kPrefixBytes;
    for (size_t i = 0; i < 4; ++i) body[1 + i] = static_cast<char>(bytes >> (24 - 8 * i) & 0xff);
  }
  const size_t length = lower.find(kLength);
  if (length != std::string::npos) {
    const size_t digits = length + kLength.size();
    head.replace(digits, head.find('\r', digits) - digits, std::to_string(end));
  }
  return head + body;
}

}  // namespace latticed::fuzz
