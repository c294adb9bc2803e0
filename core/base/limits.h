// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Every limit of the program: the unit is in the name, the reason in the comment. GetServerInfo publishes those that
// clients meet.
#ifndef LATTICED_CORE_BASE_LIMITS_H_
#define LATTICED_CORE_BASE_LIMITS_H_

#include <cstddef>
#include <cstdint>

namespace latticed::limits {

// Lattice. Degree 3 per axis makes patches of degree 9. Beyond it the interpolation matrix is too ill-conditioned.
inline constexpr int kMinDegree = 1;
inline constexpr int kMaxDegree = 3;
inline constexpr int kMaxControlPoints = 32'768;
// Lattices of a scene. Their sum has a control point for each combination of their knots.
inline constexpr int kMaxLattices = 8;

// Views. 32 segments: 561 points per patch; 32 patches stay far below kMaxChunkPoints.
inline constexpr int kMinSegments = 1;
inline constexpr int kMaxSegments = 32;
// The finest level of an edge under a tolerance: 2^5 = kMaxSegments segments.
inline constexpr int kMaxEdgeLevel = 5;
inline constexpr int kMinPositionBits = 8;
inline constexpr int kMaxPositionBits = 16;
inline constexpr int kMinNormalBits = 6;
inline constexpr int kMaxNormalBits = 12;
inline constexpr int kMaxViewsPerScene = 8;

// Chunks. At the default 10 segments, 32 patches have 2,112 points.
inline constexpr int kPatchesPerChunk = 32;
inline constexpr int kMaxChunkPoints = 65'535;

// Meshes: indices are 32-bit, and a plan multiplies faces by the knot boxes that they cross.
inline constexpr uint64_t kMaxMeshBytes = uint64_t{4} << 30;
inline constexpr uint64_t kMaxMeshVertices = 200'000'000;
inline constexpr uint64_t kMaxMeshFaces = 200'000'000;
// Stars, combs and spirals of this size take 0.02 to 0.5 s. What would take more than some 2 s is refused: triangulate.h.
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
// Chunks of a message. Those of few bytes then stay below kMaxMessageBytes with all their headers.
inline constexpr size_t kMaxBatchChunks = 8'192;
inline constexpr size_t kMaxChunkHeadBytes = 32;

// Transport. A client has a few concurrent calls, and one stream per window. Further calls wait at the client, which
// may open another connection, as proxies do.
inline constexpr int kMaxCallsPerConnection = 128;
// The most bytes of a header. HTTP/2 counts each field as its name, its value and 32.
inline constexpr uint32_t kMaxHeaderBytes = 12'288;
// The memory of a call besides its messages, whether it waits for a worker or none of its bytes have arrived.
inline constexpr uint64_t kCallBytes = 20'480;
// The most memory of a connection besides what gRPC's own quota counts: on --listen, its calls; on --http, a message
// in, one out, a piece of a body, TLS. --transport-memory divided by it is the largest number of connections, unless a
// process has fewer file descriptors.
inline constexpr uint64_t kConnectionBytes = kMaxCallsPerConnection * kCallBytes;
inline constexpr int kMaxConnections = 4'096;
// Files that the process opens besides its connections: libraries, epoll, the admin's port, the viewer's files.
inline constexpr uint64_t kOwnFiles = 48;
// gRPC's threads for services that block one thread per call; reflection is the only one. Calls beyond
// it are refused with RESOURCE_EXHAUSTED.
inline constexpr int kMaxGrpcThreads = 40;
// Calls of one caller; further ones in the same second are refused. A stream of edits is one call.
inline constexpr uint64_t kMaxCallsPerSecond = 5'000;
// The server pings a silent client this often, to find those that are gone without closing their connection.
inline constexpr int kKeepaliveMs = 60'000;
// A client that does not answer for this long counts as gone.
inline constexpr int kKeepaliveTimeoutMs = 20'000;
// A connection that has not said within this time which protocol it speaks is closed.
inline constexpr int kHandshakeMs = 10'000;
// A connection without a call is closed after this time. Clients connect again when they need to.
inline constexpr int kIdleConnectionMs = 300'000;
// HTTP/1.1: a request line with its fields. Browsers send cookies of other sites on localhost.
inline constexpr size_t kMaxHttpHeadBytes = size_t{16} << 10;
// Connections of --http beyond --max-connections that get an answer; further ones are just closed.
inline constexpr size_t kMaxRefusedHttpConnections = 64;
// Connections of --admin, which serves probes and scrapers only.
inline constexpr size_t kMaxAdminConnections = 64;
// Answers that a Deform stream queues for a slow reader. At this number, its requests are not read.
inline constexpr size_t kMaxQueuedAnswers = 64;
// With less, a few connections of ordinary clients would meet back-pressure.
inline constexpr uint64_t kMinTransportBytes = uint64_t{16} << 20;
// Parsed requests that wait for a worker may take --memory divided by this. It comes on top of --memory, so that
// requests that free memory are not refused.
inline constexpr uint64_t kWaitingRequestsShare = 8;
// Replies that clients have not read yet may take as much again. Small replies are not counted: a call that holds one
// takes no more memory than a call of which no bytes have arrived.
inline constexpr uint64_t kUntakenRepliesShare = 8;
inline constexpr uint64_t kSmallReplyBytes = 8'192;

// Scenes. The defaults of --max-scenes and --max-watchers: a scene costs a plan, a watcher a socket
// buffer.
inline constexpr int kDefaultMaxScenes = 10'000;
inline constexpr int kDefaultMaxWatchersPerScene = 1'000;
// Where there is a store, scenes and meshes that nobody uses for so long leave memory until the next call.
inline constexpr int kStoredIdleSeconds = 600;
// 4,096 points are answered in a millisecond, and their answer fits a message.
inline constexpr int kMaxEvaluatePoints = 4'096;
// Sets of points beside a scene: memory is their real limit. Places of points are 32-bit, and a list of sets must fit in a
// message. A direction of the largest lattice, 32,768 control points, has exactly kMaxPartBytes.
inline constexpr uint64_t kMaxPointSetPoints = 1'000'000'000;
inline constexpr int kMaxPointSetsPerScene = 64;
inline constexpr int kMaxDirections = 64;
// A drag of this many points, all independent, takes 0.1 s.
inline constexpr size_t kMaxDragPoints = 1'024;
// The presence of an editor is sent 10 times a second. With these limits it is below 4 KiB.
inline constexpr size_t kMaxPresenceName = 64;  // characters
inline constexpr size_t kMaxPresenceIndices = 1'024;
inline constexpr uint32_t kMaxPresenceColour = 0xFFFFFF;
inline constexpr int kMaxPresencesPerSecond = 10;
// Cameras of editors: beyond these a picture shows nothing, or its projection overflows.
inline constexpr double kMinCameraFovDegrees = 0.01;
inline constexpr double kMaxCameraFovDegrees = 179;
inline constexpr double kMinCameraHeight = 1e-15;  // world units, up to kMaxCoordinate
inline constexpr int kMaxEditorsRemembered = 1'024;
inline constexpr int kMaxUndoSteps = 256;
inline constexpr size_t kMaxUndoBytes = size_t{64} << 20;
inline constexpr int kMaxSnapshotsPerView = 3;
inline constexpr int kGestureTimeoutSeconds = 60;
inline constexpr int kUploadIdleSeconds = 3'600;
inline constexpr int kMaxPageSize = 1'000;
inline constexpr int kDefaultPageSize = 100;
// Items of one page of a list: its reply must fit in a message.
inline constexpr size_t kMaxPageBytes = size_t{768} << 10;
// Each unfinished upload holds its bytes.
inline constexpr int kMaxUploads = 64;
inline constexpr size_t kMaxSharesOfScene = 100;
inline constexpr int64_t kDefaultShareSeconds = int64_t{7} * 24 * 3600;
inline constexpr int64_t kMaxShareSeconds = int64_t{366} * 24 * 3600;
// Updates that a watcher may leave without acknowledgement.
inline constexpr int kMaxUnackedUpdates = 100;

// Limits of stored text of clients: ids, names and labels. Ids of editors and requests are UUIDs of
// 36 characters, or longer names.
inline constexpr size_t kMinSceneIdBytes = 1;
inline constexpr size_t kMaxSceneIdBytes = 63;
inline constexpr size_t kMaxEditorIdBytes = 64;
inline constexpr size_t kMaxRequestIdBytes = 64;
inline constexpr size_t kMaxNameBytes = 255;
inline constexpr size_t kMaxLabels = 32;
inline constexpr size_t kMaxLabelKeyBytes = 63;
inline constexpr size_t kMaxLabelValueBytes = 255;
// Groups of a mesh as a reply shows them: names in files have no bound, and the reply must fit in a
// message.
inline constexpr size_t kMaxShownGroupNameBytes = 255;
inline constexpr size_t kMaxShownGroupBytes = size_t{768} << 10;

}  // namespace latticed::limits

#endif  // LATTICED_CORE_BASE_LIMITS_H_
