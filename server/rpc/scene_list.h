// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_SERVER_RPC_SCENE_LIST_H_
#define LATTICED_SERVER_RPC_SCENE_LIST_H_

#include "absl/status/status.h"
#include "latticed/v1/scene.pb.h"
#include "server/rpc/method.h"

namespace latticed {

// The handler of SceneService.ListScenes: scenes in memory and scenes of the store, a page at a time. It wakes none.
[[nodiscard]] absl::Status ListScenes(const CallContext& context,
                                      const v1::ListScenesRequest& request,
                                      v1::ListScenesResponse& response);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SCENE_LIST_H_
