// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Frames of gRPC-Web, binary. Body of a request and of an answer:
//   https://github.com/grpc/grpc/blob/master/doc/PROTOCOL-WEB.md
//
//   frame = flags (1 byte: 0x80 trailers, 0x01 compressed) length (4 bytes, big endian) payload
//
// The last frame of an answer has the trailers as lines "name: value\r\n", grpc-status among them.
// Threads  none
#ifndef LATTICED_SERVER_WEB_GRPC_WEB_FRAMES_H_
#define LATTICED_SERVER_WEB_GRPC_WEB_FRAMES_H_

#include <grpcpp/support/status.h>

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/web/generic_call.h"

namespace latticed::web {

// Cuts a request's body into messages. Holds at most one message and the bytes that came after it.
class FrameReader {
 public:
  void Append(std::string_view bytes) { buffer_.append(bytes); }
  // The next whole message, or nullopt until it has come. kResourceExhausted for one above
  // limits::kMaxMessageBytes, kUnimplemented for a compressed one, kInvalidArgument for other flags.
  [[nodiscard]] absl::StatusOr<std::optional<std::string>> Next();
  // Whether the body may end here.
  [[nodiscard]] bool empty() const { return buffer_.empty(); }

 private:
  std::string buffer_;
};

// The prefix of a message of `bytes` bytes.
[[nodiscard]] std::string MessagePrefix(size_t bytes);
[[nodiscard]] std::string TrailersFrame(const grpc::Status& status, const CallMetadata& trailers);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_GRPC_WEB_FRAMES_H_
