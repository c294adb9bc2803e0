// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where a load's own edits had put the control points at each revision, as core/ffd applies them.
//
// Errors   EditHistory's: an edit that the server has applied cannot be
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
  // `edits` are all that were made of `before`, by `plan`.
  LatticeReplay(const LoadPlan& plan, const v1::LatticeState& before,
                std::vector<AppliedEdit> edits);
  // Not before one that was asked for earlier. Valid until the next call.
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
