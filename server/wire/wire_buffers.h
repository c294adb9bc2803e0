// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SceneEvents as ByteBuffers. Large chunks are not copied: each is a slice that keeps the snapshot's buffer alive until the
// transport has sent it, between slices of hand-written framing. Small chunks are copied into these. What is on the wire is
// what protobuf would have written (field numbers come from the generated code).
//
//   | SceneEvent.chunks, Chunks head, Chunk head | data | tail | Chunk head | data | tail | …
//
// A tail has the levels of a view with a tolerance, or says which edges bounds are of. Consecutive chunks of bounds are one
// Chunk, and one slice where they are neighbours in one buffer.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_WIRE_BUFFERS_H_
#define LATTICED_SERVER_WIRE_WIRE_BUFFERS_H_

#include <grpcpp/support/byte_buffer.h>

#include "latticed/v1/event.pb.h"
#include "server/engine/watcher.h"

namespace latticed {

[[nodiscard]] grpc::ByteBuffer EncodeEvent(const v1::SceneEvent& event);
[[nodiscard]] grpc::ByteBuffer EncodeEvent(const WatchEvent& event);

// One batch.
[[nodiscard]] grpc::ByteBuffer EncodeChunks(const ChunkBatch& batch);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_WIRE_BUFFERS_H_
