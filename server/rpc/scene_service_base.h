// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The base of the SceneService implementation: the callback API, where the three streams that carry
// chunks take and give raw ByteBuffers, so that chunk bytes leave without being copied.
#ifndef LATTICED_SERVER_RPC_SCENE_SERVICE_BASE_H_
#define LATTICED_SERVER_RPC_SCENE_SERVICE_BASE_H_

#include "latticed/v1/scene.grpc.pb.h"

namespace latticed {

namespace scene_service_base {

using S = v1::SceneService;
using Streams = S::WithRawCallbackMethod_Deform<
    S::WithRawCallbackMethod_Watch<S::WithRawCallbackMethod_GetUpdate<S::Service>>>;
using Scenes = S::WithCallbackMethod_CreateScene<S::WithCallbackMethod_GetScene<
    S::WithCallbackMethod_ListScenes<S::WithCallbackMethod_DeleteScene<Streams>>>>;
using Edits = S::WithCallbackMethod_GetLattice<
    S::WithCallbackMethod_ApplyEdits<S::WithCallbackMethod_ControlWatch<Scenes>>>;
using All = S::WithCallbackMethod_GetTopology<S::WithCallbackMethod_Export<
    S::WithCallbackMethod_Pick<S::WithCallbackMethod_EvaluatePoints<Edits>>>>;

}  // namespace scene_service_base

// Deform, Watch and GetUpdate are overridden with ByteBuffer signatures; forward them to the
// factories in deform_stream.h, watch_stream.h and get_update.h.
using SceneServiceBase = scene_service_base::All;

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_SCENE_SERVICE_BASE_H_
