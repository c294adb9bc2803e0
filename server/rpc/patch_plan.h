// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The answer of GetPatchPlan: core/patches/patch_plan_writer.h, one message at a time. The next part is made when the
// one before has been written, so the plan is never in memory as a whole.
//
// Errors   kNotFound for the scene, and for a topology that is not that of its patches; kInvalidArgument with the path
//          of the field; kResourceExhausted
// Threads  one thread at a time
#ifndef LATTICED_SERVER_RPC_PATCH_PLAN_H_
#define LATTICED_SERVER_RPC_PATCH_PLAN_H_

#include "absl/status/statusor.h"
#include "latticed/v1/scene.pb.h"
#include "server/rpc/method.h"

namespace latticed {

// Numbers all rest normals first, which takes some milliseconds per 10,000 patches.
[[nodiscard]] absl::StatusOr<NextPart<v1::PatchPlanPart>> OpenPatchPlan(
    const CallContext& context, const v1::GetPatchPlanRequest& request);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_PATCH_PLAN_H_
