// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// CertifyFolds: where the newest state of a scene folds. It looks at all boxes of the scope: a few microseconds each of
// degree 2, some 15 of degree 3. It holds no lock of the scene.
//
// Errors   kNotFound for the scene; kInvalidArgument for an unknown scope; kFailedPrecondition for the volume with vertex
//          weights or turned lattices; kCancelled
// Threads  safe
#ifndef LATTICED_SERVER_RPC_CERTIFY_FOLDS_H_
#define LATTICED_SERVER_RPC_CERTIFY_FOLDS_H_

#include "absl/status/status.h"
#include "latticed/v1/scene.pb.h"
#include "server/rpc/method.h"

namespace latticed {

[[nodiscard]] absl::Status CertifyFolds(const CallContext& context,
                                        const v1::CertifyFoldsRequest& request,
                                        v1::FoldReport& response);

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_CERTIFY_FOLDS_H_
