// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Constraints of edits <-> scene_log.proto.
//
// Errors   kDataLoss for axes and numbers of layers that cannot be
// Threads  pure functions
#ifndef LATTICED_SERVER_STORE_RECORDS_CONSTRAINTS_CODEC_H_
#define LATTICED_SERVER_STORE_RECORDS_CONSTRAINTS_CODEC_H_

#include "absl/status/statusor.h"
#include "core/ffd/constraints/constraints.h"
#include "server/store/records/scene_log.pb.h"

namespace latticed {

void ToStored(const Constraints& constraints, store::Constraints& stored);
// Whether they fit the lattice, the history checks.
[[nodiscard]] absl::StatusOr<Constraints> ConstraintsFromStored(const store::Constraints& stored);

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_RECORDS_CONSTRAINTS_CODEC_H_
