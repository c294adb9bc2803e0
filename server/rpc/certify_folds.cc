// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/certify_folds.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/folds/fold_certifier.h"
#include "server/rpc/server_env.h"
#include "server/rpc/watch_request.h"
#include "server/wire/fold_converters.h"

namespace latticed {

absl::Status CertifyFolds(const CallContext& context, const v1::CertifyFoldsRequest& request,
                          v1::FoldReport& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto scene,
                            FindScene(context.env, context.call, request.scene()));
  LATTICED_ASSIGN_OR_RETURN(const FoldScope scope, FoldScopeFromProto(request.scope()));
  const auto state = scene->State();
  // Weights are of the surface: the volume around it has no deformation that could fold.
  if (state->plan->is_weighted() && scope == FoldScope::kVolume) {
    return error::NotWithWeights("a report of folds in the volume");
  }
  LATTICED_ASSIGN_OR_RETURN(
      const auto room,
      context.env.memory->Reserve("the report of folds", FoldCertifier::MostBytes(*state->plan),
                                  context.call.account->memory));
  const FoldCertifier certifier(state->plan, scope);
  LATTICED_ASSIGN_OR_RETURN(const FoldReport report, certifier.Certify(*state->control_points, [&] {
    return CheckCancelled(context.call);
  }));
  response = ToProto(report, state->revision, state->structure_id, kMostPlaces);
  return absl::OkStatus();
}

}  // namespace latticed
