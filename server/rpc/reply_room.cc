// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/reply_room.h"

#include <algorithm>

#include "core/base/limits.h"
#include "server/rpc/server_env.h"

namespace latticed {

uint64_t ReplyBytes(const google::protobuf::Message& reply) {
  return reply.SpaceUsedLong() + reply.ByteSizeLong();
}

// Nothing is always granted.
ReplyRoom::ReplyRoom(const ServerEnv& env) : room_(*env.replies->Reserve("the reply", 0)) {}

absl::Status ReplyRoom::Hold(uint64_t bytes) {
  if (bytes <= std::max(limits::kSmallReplyBytes, room_.bytes())) return absl::OkStatus();
  return room_.Resize("the reply", bytes);
}

}  // namespace latticed
