// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/support/unfinished_calls.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <gtest/gtest.h>

#include "absl/time/clock.h"

namespace latticed::testing {
namespace {

// RFC 9113: frame types, flags, settings, and the limits before the server's settings arrive.
constexpr uint8_t kData = 0, kHeaders = 1, kReset = 3, kSettings = 4, kPing = 6, kGoaway = 7,
                  kWindowUpdate = 8;
constexpr uint8_t kAck = 1, kEndStream = 1, kEndHeaders = 4;
constexpr uint32_t kMaxConcurrentStreams = 3, kInitialWindowSize = 4;
constexpr int64_t kFirstWindow = 65'535;
constexpr size_t kFrameHeader = 9, kMostFrame = 16'384, kMessageHeader = 5;
constexpr absl::Duration kPatience = absl::Seconds(60);

std::string BigEndian(uint64_t value, int bytes) {
  std::string text;
  for (int b = bytes - 1; b >= 0; --b) text.push_back(static_cast<char>(value >> (8 * b) & 0xFF));
  return text;
}

std::string FrameHead(size_t payload, uint8_t type, uint8_t flags, uint32_t stream) {
  return BigEndian(payload, 3) + BigEndian(type, 1) + BigEndian(flags, 1) + BigEndian(stream, 4);
}

uint32_t ReadBigEndian(std::string_view bytes) {
  uint32_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<uint8_t>(byte);
  return value;
}

// RFC 7541: literal header fields without indexing, each shorter than 127 bytes.
std::string Fields(std::string_view method) {
  const std::array<std::pair<std::string_view, std::string_view>, 6> fields{
      {{":method", "POST"},
       {":scheme", "http"},
       {":path", method},
       {":authority", "test"},
       {"te", "trailers"},
       {"content-type", "application/grpc"}}};
  std::string text;
  for (const auto& [name, value] : fields) {
    text += std::string(1, '\0') + static_cast<char>(name.size()) + std::string(name);
    text += static_cast<char>(value.size()) + std::string(value);
  }
  return text;
}

// A gRPC message: not compressed, its length, its bytes.
std::string MessageOf(std::string_view bytes) {
  return BigEndian(0, 1) + BigEndian(bytes.size(), 4) + std::string(bytes);
}

int Connect(const std::string& address) {
  const size_t colon = address.rfind(':');
  sockaddr_in to{.sin_family = AF_INET,
                 .sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(colon + 1)))),
                 .sin_addr = {},
                 .sin_zero = {}};
  const int connection = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const timeval patience{.tv_sec = absl::ToInt64Seconds(kPatience), .tv_usec = 0};
  setsockopt(connection, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
  if (inet_pton(AF_INET, address.substr(0, colon).c_str(), &to.sin_addr) != 1 ||
      connect(connection, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) != 0) {
    ADD_FAILURE() << "no answer from " << address;
  }
  return connection;
}

}  // namespace

UnfinishedCalls::UnfinishedCalls(const std::string& address, std::string_view method, int count,
                                 size_t bytes)
    : UnfinishedCalls(
          address, method,
          {.bytes = bytes > kMessageHeader ? MessageOf(std::string(bytes - kMessageHeader, 'x'))
                                           : std::string(),
           .sent = bytes > kMessageHeader ? bytes - 1 : 0}) {
  SendFrame(kSettings, 0, 0, "");
  for (int i = 0; i < count; ++i) Begin();
}

UnfinishedCalls::UnfinishedCalls(const std::string& address, std::string_view method,
                                 std::string_view request)
    : UnfinishedCalls(address, method,
                      {.bytes = MessageOf(request), .sent = kMessageHeader + request.size()}) {
  SendFrame(kSettings, 0, 0, BigEndian(kInitialWindowSize, 2) + BigEndian(0, 4));
}

UnfinishedCalls::UnfinishedCalls(const std::string& address, std::string_view method,
                                 Message message)
    : method_(method),
      message_(std::move(message)),
      socket_(Connect(address)),
      window_(kFirstWindow),
      stream_window_(kFirstWindow) {
  SendBytes("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n");
}

void UnfinishedCalls::Begin() {
  const uint32_t stream = calls_.empty() ? 1 : calls_.rbegin()->first + 2;
  calls_[stream].window = stream_window_;
  SendFrame(kHeaders, kEndHeaders, stream, Fields(method_));
}

UnfinishedCalls::~UnfinishedCalls() { close(socket_); }

bool UnfinishedCalls::Run(const std::function<bool()>& done) {
  const absl::Time give_up = absl::Now() + kPatience;
  while (!done()) {
    if (closed_ || absl::Now() > give_up) return false;
    SendData();
    Hear();
  }
  return true;
}

size_t UnfinishedCalls::held_bytes() const {
  size_t held = 0;
  for (const auto& [stream, call] : calls_) held += call.ended ? 0 : call.sent;
  return held;
}

size_t UnfinishedCalls::ended() const {
  return static_cast<size_t>(
      std::ranges::count_if(calls_, [](const auto& call) { return call.second.ended; }));
}

size_t UnfinishedCalls::sent() const {
  return static_cast<size_t>(std::ranges::count_if(calls_, [this](const auto& call) {
    return !call.second.ended && call.second.sent == message_.sent;
  }));
}

size_t UnfinishedCalls::answered() const {
  return static_cast<size_t>(
      std::ranges::count_if(calls_, [](const auto& call) { return call.second.answered; }));
}

void UnfinishedCalls::SendBytes(std::string_view bytes) {
  while (!bytes.empty() && !closed_) {
    const ssize_t taken = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    closed_ = taken <= 0;
    EXPECT_TRUE(taken > 0 || errno != EAGAIN) << "the server takes nothing for a minute";
    if (!closed_) bytes.remove_prefix(static_cast<size_t>(taken));
  }
}

void UnfinishedCalls::SendFrame(uint8_t type, uint8_t flags, uint32_t stream,
                                std::string_view payload) {
  SendBytes(FrameHead(payload.size(), type, flags, stream) + std::string(payload));
}

void UnfinishedCalls::SendData() {
  for (auto& [stream, call] : calls_) {
    while (!call.ended && !closed_) {
      const auto most = static_cast<size_t>(std::max<int64_t>(std::min(window_, call.window), 0));
      const size_t size = std::min({most, kMostFrame, message_.sent - call.sent});
      if (size == 0) break;
      const bool last = call.sent + size == message_.bytes.size();
      SendFrame(kData, last ? kEndStream : 0, stream,
                std::string_view(message_.bytes).substr(call.sent, size));
      call.sent += size;
      call.window -= static_cast<int64_t>(size);
      window_ -= static_cast<int64_t>(size);
    }
  }
}

void UnfinishedCalls::Hear() {
  constexpr int kWaitMs = 5;
  pollfd readable{.fd = socket_, .events = POLLIN, .revents = 0};
  if (poll(&readable, 1, kWaitMs) <= 0) return;
  std::string buffer(size_t{64} << 10, '\0');
  const ssize_t size = recv(socket_, buffer.data(), buffer.size(), 0);
  closed_ = closed_ || size <= 0;
  if (size > 0) heard_.append(buffer, 0, static_cast<size_t>(size));
  while (heard_.size() >= kFrameHeader) {
    const std::string_view head = heard_;
    const size_t length = ReadBigEndian(head.substr(0, 3));
    if (heard_.size() < kFrameHeader + length) return;
    Take(static_cast<uint8_t>(head[3]), static_cast<uint8_t>(head[4]),
         ReadBigEndian(head.substr(5, 4)), head.substr(kFrameHeader, length));
    heard_.erase(0, kFrameHeader + length);
  }
}

void UnfinishedCalls::Take(uint8_t type, uint8_t flags, uint32_t stream, std::string_view payload) {
  const auto call = calls_.find(stream);
  if (type == kSettings && (flags & kAck) == 0) {
    TakeSettings(payload);
  } else if (type == kPing && (flags & kAck) == 0) {
    SendFrame(kPing, kAck, 0, payload);
  } else if (type == kWindowUpdate) {
    const int64_t more = ReadBigEndian(payload);
    if (stream == 0) window_ += more;
    if (call != calls_.end()) call->second.window += more;
  } else if (type == kGoaway) {
    closed_ = true;
  } else if (call != calls_.end()) {
    const bool ends = type == kReset || (type == kHeaders && (flags & kEndStream) != 0);
    call->second.answered = call->second.answered || (type == kHeaders && !ends);
    call->second.ended = call->second.ended || ends;
    if (type == kReset) reset_codes_.insert(ReadBigEndian(payload));
  }
}

void UnfinishedCalls::TakeSettings(std::string_view payload) {
  constexpr size_t kName = 2, kValue = 4;
  for (size_t at = 0; at + kName + kValue <= payload.size(); at += kName + kValue) {
    const uint32_t name = ReadBigEndian(payload.substr(at, kName));
    const uint32_t value = ReadBigEndian(payload.substr(at + kName, kValue));
    if (name == kMaxConcurrentStreams) max_calls_ = value;
    if (name != kInitialWindowSize) continue;
    const int64_t size = value;
    for (auto& [stream, call] : calls_) call.window += size - stream_window_;
    stream_window_ = size;
  }
  SendFrame(kSettings, kAck, 0, "");
}

}  // namespace latticed::testing
