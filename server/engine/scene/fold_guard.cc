// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/fold_guard.h"

#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/ffd/edit/lattice_edit.h"
#include "fmt/format.h"

namespace latticed {
namespace {

std::shared_ptr<const FoldReport> CertifyAll(const FoldCertifier& certifier,
                                             std::span<const Vec3d> control_points) {
  // Without a stop check it cannot fail.
  return std::make_shared<const FoldReport>(*certifier.Certify(control_points));
}

absl::Status NewFoldError(const FoldedBox& fold) {
  const auto& [i, j, k] = fold.place;
  const Vec3d& p = fold.rest_point;
  const auto box = fmt::format("{} {} {}", i, j, k);
  const auto where =
      fold.place == kOutsidePlace ? "outside the first lattice" : "in knot box " + box;
  const auto point = fmt::format("{} {} {}", p.x, p.y, p.z);
  const auto determinant = fmt::format("{}", fold.determinant);
  return error::WithDetails(
      absl::FailedPreconditionError(
          fmt::format("the edit would fold the deformation {}, at {}: det J is {} there; "
                      "move less, or leave refuse_folds unset",
                      where, point, determinant)),
      {.reason = "FOLD",
       .metadata = {{"box", box}, {"rest_point", point}, {"determinant", determinant}}});
}

}  // namespace

const FoldReport& FoldGuard::ReportOf(const SceneState& state) {
  if (known_.certifier == nullptr || &known_.certifier->plan() != state.plan.get()) {
    known_ = {std::make_shared<const FoldCertifier>(state.plan, FoldScope::kSurface)};
  }
  if (known_.report == nullptr || known_.revision != state.revision) {
    known_.report = CertifyAll(*known_.certifier, *state.control_points);
    known_.revision = state.revision;
  }
  return *known_.report;
}

absl::Status FoldGuard::Admit(const SceneState& before,
                              const std::shared_ptr<const DeformPlan>& plan,
                              std::span<const Vec3d> control_points) {
  const FoldReport& old = ReportOf(before);
  if (plan != before.plan) {
    if (!old.certified()) return absl::OkStatus();
    const auto report = CertifyAll(FoldCertifier(plan, FoldScope::kSurface), control_points);
    return report->certified() ? absl::OkStatus() : NewFoldError(report->places.front());
  }
  std::vector<uint32_t> changed;
  for (uint32_t i = 0; i < control_points.size(); ++i) {
    if (!SameBits(control_points[i], (*before.control_points)[i])) changed.push_back(i);
  }
  const FoldReport report = known_.certifier->Recertify(old, changed, control_points);
  const FoldedBox* const fold = NewFold(old, report);
  return fold == nullptr ? absl::OkStatus() : NewFoldError(*fold);
}

std::shared_ptr<const FoldReport> FoldGuard::Follow(const SceneState& before,
                                                    const SceneState& after,
                                                    std::span<const uint32_t> changed) {
  const bool follows = after.plan == before.plan && known_.report != nullptr &&
                       &known_.certifier->plan() == after.plan.get() &&
                       known_.revision == before.revision;
  if (!follows) {
    ReportOf(after);
    return known_.report;
  }
  known_.report = std::make_shared<const FoldReport>(
      known_.certifier->Recertify(*known_.report, changed, *after.control_points));
  known_.revision = after.revision;
  return known_.report;
}

size_t FoldGuard::MemoryBytes() const {
  return (known_.certifier == nullptr ? 0 : known_.certifier->MemoryBytes()) +
         (known_.report == nullptr ? 0 : known_.report->MemoryBytes());
}

}  // namespace latticed
