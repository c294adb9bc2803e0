// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/grpc_web_frames.h"

#include "core/base/error.h"
#include "core/base/limits.h"
#include "fmt/format.h"
#include "server/web/call_metadata.h"
#include "server/web/http_answers.h"

namespace latticed::web {
namespace {

constexpr size_t kPrefixBytes = 5;
constexpr unsigned char kTrailersFlag = 0x80;
constexpr unsigned char kCompressedFlag = 0x01;

std::string Prefix(unsigned char flags, size_t bytes) {
  std::string prefix(kPrefixBytes, '\0');
  prefix[0] = static_cast<char>(flags);
  for (size_t i = 0; i < 4; ++i) prefix[1 + i] = static_cast<char>(bytes >> (24 - 8 * i) & 0xff);
  return prefix;
}

size_t Length(std::string_view prefix) {
  size_t bytes = 0;
  for (size_t i = 1; i < kPrefixBytes; ++i) {
    bytes = bytes << 8 | static_cast<unsigned char>(prefix[i]);
  }
  return bytes;
}

}  // namespace

absl::StatusOr<std::optional<std::string>> FrameReader::Next() {
  if (buffer_.size() < kPrefixBytes) return std::nullopt;
  const auto flags = static_cast<unsigned char>(buffer_[0]);
  if (flags == kCompressedFlag) {
    return error::Unimplemented("compression of requests");
  }
  if (flags != 0) {
    return error::InvalidField(
        "body", fmt::format("a frame has the flags {:#04x}, a message has 0", flags));
  }
  const size_t bytes = Length(buffer_);
  if (bytes > limits::kMaxMessageBytes) {
    return error::LimitExceeded(fmt::format("bytes of a message, {} here", bytes),
                                limits::kMaxMessageBytes);
  }
  if (buffer_.size() < kPrefixBytes + bytes) {
    buffer_.reserve(kPrefixBytes + bytes);
    return std::nullopt;
  }
  std::string message = buffer_.substr(kPrefixBytes, bytes);
  buffer_.erase(0, kPrefixBytes + bytes);
  return message;
}

std::string MessagePrefix(size_t bytes) { return Prefix(0, bytes); }

std::string TrailersFrame(const grpc::Status& status, const CallMetadata& trailers) {
  std::string lines;
  HttpFields fields = StatusFields(status);
  Append(ToFields(trailers), fields);
  for (const auto& [name, value] : fields) {
    lines += fmt::format("{}: {}\r\n", name, value);
  }
  return Prefix(kTrailersFlag, lines.size()) + lines;
}

}  // namespace latticed::web
