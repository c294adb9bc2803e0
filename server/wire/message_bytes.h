// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Protobuf messages from and to gRPC's bytes. The services take and give bytes, because gRPC answers a message
// that it cannot parse with INTERNAL, and parses before a caller is known.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_MESSAGE_BYTES_H_
#define LATTICED_SERVER_WIRE_MESSAGE_BYTES_H_

#include <grpcpp/support/byte_buffer.h>

#include "absl/status/status.h"
#include "google/protobuf/message.h"

namespace latticed {

// Parses the bytes of a call and frees them: gRPC would keep them until the call has ended, and the client
// decides when that is. kInvalidArgument for bytes that are no such message.
[[nodiscard]] absl::Status TakeMessage(const grpc::ByteBuffer& bytes,
                                       google::protobuf::Message* message);

[[nodiscard]] grpc::ByteBuffer ToBytes(const google::protobuf::Message& message);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_MESSAGE_BYTES_H_
