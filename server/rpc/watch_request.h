// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Checks and converts the scene of a request, and the messages that open and control a watch.
//
// Errors   kNotFound for the scene or the watch; kInvalidArgument with the path of the field
// Threads  pure functions
#ifndef LATTICED_SERVER_RPC_WATCH_REQUEST_H_
#define LATTICED_SERVER_RPC_WATCH_REQUEST_H_

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "latticed/v1/scene.pb.h"
#include "server/rpc/scene_stream.h"

namespace latticed {

struct CallInfo;
struct ServerEnv;

// Where servers share a store, a scene for which this one has no memory is made on the one with most of it: kUnavailable,
// reason SCENE_MOVED. `refused`, where no other has enough.
[[nodiscard]] absl::Status OrOnFreerServer(const ServerEnv& env, absl::Status refused);

// The scene that a request names. kInvalidArgument where it names none, or another than the
// metadata; kNotFound; kUnavailable, reason SCENE_MOVED.
[[nodiscard]] absl::StatusOr<std::shared_ptr<Scene>> FindScene(const ServerEnv& env,
                                                               const CallInfo& call,
                                                               const std::string& id);

struct OpenRequest {
  std::shared_ptr<Scene> scene;
  SceneStream::Options options;
};
[[nodiscard]] absl::StatusOr<OpenRequest> FromProto(ServerEnv* env, const CallInfo& call,
                                                    const v1::WatchRequest& request);
[[nodiscard]] absl::StatusOr<OpenRequest> FromProto(ServerEnv* env, const CallInfo& call,
                                                    const v1::GetUpdateRequest& request);
// `scene` is that of the watch.
[[nodiscard]] absl::StatusOr<WatchCommand> FromProto(const v1::ControlWatchRequest& request,
                                                     const Scene& scene);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_WATCH_REQUEST_H_
