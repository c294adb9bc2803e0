// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/wire/message_bytes.h"

#include <utility>

#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>

#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed {

// The bytes are a member of gRPC's call that is not const, so const_cast is allowed.
absl::Status TakeMessage(const grpc::ByteBuffer& bytes, google::protobuf::Message* message) {
  grpc::ByteBuffer taken;
  taken.Swap(const_cast<grpc::ByteBuffer*>(&bytes));
  grpc::ProtoBufferReader reader(&taken);
  if (reader.status().ok() && message->ParseFromZeroCopyStream(&reader)) return absl::OkStatus();
  return error::InvalidField("message",
                             fmt::format("cannot be parsed as {}", message->GetTypeName()));
}

grpc::ByteBuffer ToBytes(const google::protobuf::Message& message) {
  constexpr int kBlockBytes = 1 << 20;  // no larger than a message
  grpc::ByteBuffer bytes;
  grpc::ProtoBufferWriter writer(&bytes, kBlockBytes, static_cast<int>(message.ByteSizeLong()));
  // Memory is the only thing that may be missing, and then gRPC ends the process.
  (void)message.SerializeToZeroCopyStream(&writer);
  return bytes;
}

}  // namespace latticed
