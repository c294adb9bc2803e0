// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The control points at each revision of a load, computed by core/ffd from the load's own edits.
//
// Errors   EditHistory's, where core/ffd cannot apply an edit that the server has applied
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LOAD_LATTICE_REPLAY_H_
#define LATTICED_CLIENT_CPP_LOAD_LATTICE_REPLAY_H_

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cpp/load/edit_log.h"
#include "client/cpp/load/load_plan.h"
#include "core/ffd/edit_history.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed::client {

class LatticeReplay {
 public:
  // `edits` are all edits of `plan` since `before`.
  LatticeReplay(const LoadPlan& plan, const v1::LatticeState& before,
                std::vector<AppliedEdit> edits);
  // Revisions must not decrease from call to call. The result is valid until the next call.
  [[nodiscard]] absl::StatusOr<std::span<const Vec3d>> At(uint64_t revision);

 private:
  absl::Status Apply(const AppliedEdit& edit);

  const LoadPlan& plan_;
  const v1::LatticeState& before_;
  std::vector<AppliedEdit> edits_;  // by revision
  size_t next_ = 0;
  EditHistory history_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LATTICE_REPLAY_H_
