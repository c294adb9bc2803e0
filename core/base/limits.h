// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Every limit of the program, unit in the name, reason in the comment. GetServerInfo publishes
// them.
#ifndef LATTICED_CORE_BASE_LIMITS_H_
#define LATTICED_CORE_BASE_LIMITS_H_

#include <cstddef>
#include <cstdint>

namespace latticed::limits {

// Lattice. Degree 3 per axis makes patches of degree 9, the last whose interpolation matrix is
// sane.
inline constexpr int kMinDegree = 1;
inline constexpr int kMaxDegree = 3;
inline constexpr int kMaxControlPoints = 32'768;

// Views. 32 segments: 561 points a patch, 32 patches stay far below kMaxChunkPoints.
inline constexpr int kMinSegments = 1;
inline constexpr int kMaxSegments = 32;
inline constexpr int kMinPositionBits = 8;
inline constexpr int kMaxPositionBits = 16;
inline constexpr int kMinNormalBits = 6;
inline constexpr int kMaxNormalBits = 12;
inline constexpr int kMaxViewsPerScene = 8;

// Chunks: 32 patches is the power of two nearest to 2,112 points at the default 10 segments.
inline constexpr int kPatchesPerChunk = 32;
inline constexpr int kMaxChunkPoints = 65'535;

// Meshes: indices are 32-bit, and a plan multiplies faces by the knot boxes that they cross.
inline constexpr uint64_t kMaxMeshBytes = uint64_t{4} << 30;
inline constexpr uint64_t kMaxMeshVertices = 200'000'000;
inline constexpr uint64_t kMaxMeshFaces = 200'000'000;
// Ear clipping is quadratic at worst: a few seconds for a polygon of this size.
inline constexpr uint32_t kMaxFaceCorners = 65'536;
// Squares and products of coordinates must stay within float32.
inline constexpr double kMaxCoordinate = 1e15;
inline constexpr uint64_t kMaxPatches = 100'000'000;

// Messages: a data field fits a gRPC message of 1 MiB with room for the rest of it.
inline constexpr size_t kMaxPartBytes = size_t{768} << 10;
inline constexpr size_t kMaxMessageBytes = size_t{1} << 20;
// Chunks are batched into messages of this size or more, up to kMaxChunkBatchBytes.
inline constexpr size_t kMinChunkBatchBytes = size_t{256} << 10;
inline constexpr size_t kMaxChunkBatchBytes = size_t{960} << 10;

// Transport. Clients have a few calls under way, and a stream a window; calls above wait at the client,
// which may open another connection, as proxies do.
inline constexpr int kMaxCallsPerConnection = 128;
// Of a header, each field as HTTP/2 counts it: its name, its value and 32.
inline constexpr uint32_t kMaxHeaderBytes = 8'192;
// What a call takes besides its messages, those that wait for a worker and those of which nothing has
// come alike.
inline constexpr uint64_t kCallBytes = 20'480;
// What a connection takes at most besides what gRPC's own quota counts: of --listen, its calls; of
// --http, a message in, one out, a piece of a body, TLS. There are as many as --transport-memory has
// room for, and not more than a process has file descriptors for.
inline constexpr uint64_t kConnectionBytes = kMaxCallsPerConnection * kCallBytes;
inline constexpr int kMaxConnections = 4'096;
// A client that answers nothing for so long has vanished.
inline constexpr int kKeepaliveTimeoutMs = 20'000;
// Below this a few connections of ordinary clients would be under pressure.
inline constexpr uint64_t kMinTransportBytes = uint64_t{16} << 20;
// Requests that wait for a worker, parsed, take up to this share of --memory more: beside it, so that
// what frees memory has a turn.
inline constexpr uint64_t kWaitingRequestsShare = 8;
// So may replies that their clients have not taken yet, but for small ones: a call that has nothing but
// such a reply takes 12 KB and the reply, no more than one of which nothing has come.
inline constexpr uint64_t kUntakenRepliesShare = 8;
inline constexpr uint64_t kSmallReplyBytes = 8'192;

// Scenes. The defaults of --max-scenes and --max-watchers: a scene costs a plan, a watcher a socket
// buffer.
inline constexpr int kDefaultMaxScenes = 10'000;
inline constexpr int kDefaultMaxWatchersPerScene = 1'000;
// 4,096 points are answered in a millisecond, and their answer fits a message.
inline constexpr int kMaxEvaluatePoints = 4'096;
// A drag of so many points that all are independent takes 0.1 s.
inline constexpr size_t kMaxDragPoints = 1'024;
// What others are told of an editor, 10 times a second: with these it stays below 4 KiB.
inline constexpr size_t kMaxPresenceName = 64;  // characters
inline constexpr size_t kMaxPresenceIndices = 1'024;
inline constexpr uint32_t kMaxPresenceColour = 0xFFFFFF;
inline constexpr int kMaxPresencesPerSecond = 10;
inline constexpr int kMaxEditorsRemembered = 1'024;
inline constexpr int kMaxUndoSteps = 256;
inline constexpr size_t kMaxUndoBytes = size_t{64} << 20;
inline constexpr int kMaxSnapshotsPerView = 3;
inline constexpr int kGestureTimeoutSeconds = 60;
inline constexpr int kUploadIdleSeconds = 3'600;
inline constexpr int kMaxPageSize = 1'000;
inline constexpr int kDefaultPageSize = 100;
// Each upload under way holds its bytes.
inline constexpr int kMaxUploads = 64;
// Words of clients that are kept: names and labels.
inline constexpr size_t kMaxNameBytes = 255;
inline constexpr size_t kMaxLabels = 32;
inline constexpr size_t kMaxLabelKeyBytes = 63;
inline constexpr size_t kMaxLabelValueBytes = 255;

}  // namespace latticed::limits

#endif  // LATTICED_CORE_BASE_LIMITS_H_
