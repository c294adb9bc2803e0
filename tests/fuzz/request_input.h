// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The input of request_fuzz: messages one after the other, each to a call of its own or to the call before.
//
//   +------+--------+--------+----------------
//   | head | length, 15 bits | bytes            head = rpc + flags; rpc counts the services' methods
//   +------+--------+--------+----------------  the bit above the length is the rpc's bit 5
//
// The last message may be cut short. Templates are valid messages, which mutations begin with.
//
// Threads  pure
#ifndef LATTICED_TESTS_FUZZ_REQUEST_INPUT_H_
#define LATTICED_TESTS_FUZZ_REQUEST_INPUT_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "google/protobuf/descriptor.h"

namespace latticed::fuzz {

struct RequestRecord {
  static constexpr uint16_t kSameCall = 0x20;   // if there is one; then the rpc does not count
  static constexpr uint16_t kLeaveOpen = 0x40;  // other calls come before the call's end
  static constexpr uint16_t kCancel = 0x80;     // once the message is on its way
  static constexpr size_t kHeads = 0x200;

  // The head of a message to this rpc, without flags; and back.
  static constexpr uint16_t HeadOf(size_t rpc) {
    return static_cast<uint16_t>((rpc & 0x1f) | (rpc & 0x20) << 3);
  }
  size_t rpc() const { return (head & 0x1fU) | (head & 0x100U) >> 3; }

  uint16_t head = 0;
  std::string bytes;
};

// All rpcs of latticed.v1.
[[nodiscard]] const std::vector<const google::protobuf::MethodDescriptor*>& Methods();
[[nodiscard]] const google::protobuf::MethodDescriptor* MethodOf(const RequestRecord& record);

[[nodiscard]] std::vector<RequestRecord> ReadRecords(std::string_view input);
[[nodiscard]] std::string WriteRecords(const std::vector<RequestRecord>& records);

// Valid calls of every rpc. Each is one record, or several of one stream.
[[nodiscard]] const std::vector<std::vector<RequestRecord>>& Templates();

}  // namespace latticed::fuzz

#endif  // LATTICED_TESTS_FUZZ_REQUEST_INPUT_H_
