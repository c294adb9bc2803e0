// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The parts of a patch plan as core/patches knows them.
//
// Errors   kDataLoss for a header whose normals this client does not know
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PATCHES_PLAN_FROM_PROTO_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PATCHES_PLAN_FROM_PROTO_H_

#include <optional>

#include "absl/status/statusor.h"
#include "core/patches/patch_plan.h"
#include "core/patches/patch_plan_reader.h"
#include "latticed/v1/patches.pb.h"

namespace latticed::client {

[[nodiscard]] absl::StatusOr<PatchPlanHeader> FromProto(const v1::PatchPlanHeader& proto);
[[nodiscard]] PatchRun FromProto(v1::PatchRun proto);
[[nodiscard]] PatchSeams FromProto(const v1::PatchSeams& proto);

// Takes the messages of GetPatchPlan in their order. Errors: kDataLoss if they contradict each other.
class PatchPlanMessages {
 public:
  [[nodiscard]] absl::Status Add(v1::PatchPlanPart part);
  [[nodiscard]] absl::StatusOr<PatchPlan> Finish();

 private:
  std::optional<PatchPlanReader> reader_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PATCHES_PLAN_FROM_PROTO_H_
