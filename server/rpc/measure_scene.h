// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Measures of a state's exact surface.
//
// Errors   kInvalidArgument naming the field; kFailedPrecondition OPEN_SURFACE; kResourceExhausted; what `stop` returns
// Threads  pure function
#ifndef LATTICED_SERVER_RPC_MEASURE_SCENE_H_
#define LATTICED_SERVER_RPC_MEASURE_SCENE_H_

#include "absl/status/status.h"
#include "core/base/stop_check.h"
#include "latticed/v1/measure.pb.h"
#include "server/engine/scene/scene_state.h"

namespace latticed {

// The most bytes of the reply.
[[nodiscard]] uint64_t MeasureReplyBytes(const SceneState& state,
                                         const v1::MeasureSceneRequest& request);
[[nodiscard]] absl::Status MeasureState(const SceneState& state,
                                        const v1::MeasureSceneRequest& request, StopCheck stop,
                                        v1::MeasureSceneResponse* response);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_MEASURE_SCENE_H_
