// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Room for what a call keeps until its client has taken the reply: a client that does not read, or
// whose HTTP/2 window is shut, holds the message and gRPC's copy of its bytes. All such replies
// together have a budget of their own, beside --memory, so that they are in the way of no scene.
//
// Threads  one at a time
#ifndef LATTICED_SERVER_RPC_REPLY_ROOM_H_
#define LATTICED_SERVER_RPC_REPLY_ROOM_H_

#include <cstdint>

#include "absl/status/status.h"
#include "google/protobuf/message.h"
#include "server/engine/memory/memory_budget.h"

namespace latticed {

struct ServerEnv;

// As a message and as its bytes.
[[nodiscard]] uint64_t ReplyBytes(const google::protobuf::Message& reply);

// Empty at first. Destroyed when the call is done.
class ReplyRoom {
 public:
  explicit ReplyRoom(const ServerEnv& env);

  // For `bytes` in all, where that is more than it has. limits::kSmallReplyBytes need no room: so a
  // server whose replies nobody takes still answers who asks how it is, or frees memory.
  // kResourceExhausted OUT_OF_MEMORY, and nothing changes.
  [[nodiscard]] absl::Status Hold(uint64_t bytes);

 private:
  MemoryReservation room_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_REPLY_ROOM_H_
