// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/fold_guard.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/ffd/edit/lattice_edit.h"
#include "core/ffd/lattice.h"
#include "fmt/format.h"

namespace latticed {
namespace {

std::shared_ptr<const FoldReport> CertifyAll(const FoldCertifier& certifier,
                                             std::span<const Vec3d> control_points) {
  // Without a stop check it cannot fail.
  return std::make_shared<const FoldReport>(*certifier.Certify(control_points));
}

// Where a state folded, for reports of other boxes.
class FoldsBefore {
 public:
  FoldsBefore(const DeformPlan& plan, const FoldReport& report)
      : plan_(plan), report_(report), map_(plan.structure) {
    for (size_t a = 0; a < 3; ++a) {
      const std::vector<double>& knots = plan.structure.knots[a];
      const auto degree = static_cast<std::ptrdiff_t>(plan.structure.degree[a]);
      std::unique_copy(knots.begin() + degree, knots.end() - degree, std::back_inserter(faces_[a]));
    }
  }

  // The worst state of the boxes that have the point: a point of a face is in several.
  FoldState StateAt(Vec3d rest_point) const {
    const Vec3d parameter = map_.ToParameter(rest_point);
    FoldState worst = FoldState::kCertified;
    bool outside = false;
    std::array<std::array<size_t, 2>, 3> range{};  // of intervals per axis, its end excluded
    for (int a = 0; a < 3; ++a) {
      const std::vector<double>& faces = faces_[static_cast<size_t>(a)];
      const double rounding = 1e-9 * (faces.back() - faces.front());
      const double x = parameter[a];
      outside = outside || x < faces.front() + rounding || x > faces.back() - rounding;
      const auto below = std::ranges::lower_bound(faces, x - rounding) - faces.begin();
      const auto above = std::ranges::upper_bound(faces, x + rounding) - faces.begin();
      range[static_cast<size_t>(a)] = {static_cast<size_t>(std::max<std::ptrdiff_t>(below, 1)) - 1,
                                       std::min(static_cast<size_t>(above), faces.size() - 1)};
    }
    if (outside) worst = report_.StateOf(plan_.outside_box());
    for (size_t w = range[2][0]; w < range[2][1]; ++w) {
      for (size_t v = range[1][0]; v < range[1][1]; ++v) {
        for (size_t u = range[0][0]; u < range[0][1]; ++u) {
          const size_t box = u + (faces_[0].size() - 1) * (v + (faces_[1].size() - 1) * w);
          worst = std::max(worst, report_.StateOf(static_cast<uint32_t>(box)));
        }
      }
    }
    return worst;
  }

 private:
  const DeformPlan& plan_;
  const FoldReport& report_;
  FrameMap map_;
  std::array<std::vector<double>, 3> faces_;  // knots without repetition
};

// The same as NewFold, where `after` may be of other boxes, under `plan`.
const FoldedBox* NewFoldUnder(const DeformPlan& plan, const FoldReport& after,
                              const DeformPlan& plan_before, const FoldReport& before) {
  if (plan.structure == plan_before.structure) return NewFold(before, after);
  const FoldsBefore folds(plan_before, before);
  const auto worse = std::ranges::find_if(after.places, [&](const FoldedBox& place) {
    return place.state > folds.StateAt(place.rest_point);
  });
  return worse == after.places.end() ? nullptr : &*worse;
}

absl::Status NewFoldError(const FoldedBox& fold) {
  const auto& [i, j, k] = fold.place;
  const Vec3d p = fold.rest_point + Vec3d{};  // without -0
  const auto where = fold.place == kOutsidePlace ? "outside the first lattice"
                                                 : fmt::format("in knot box ({}, {}, {})", i, j, k);
  return error::WithDetails(
      absl::FailedPreconditionError(
          fmt::format("the edit {} a fold {}, at ({:.6g}, {:.6g}, {:.6g}): det J is {:.6g} there; "
                      "change less, or allow folds",
                      fold.state == FoldState::kFolded ? "makes" : "may make", where, p.x, p.y, p.z,
                      fold.determinant)),
      {.reason = "FOLD",
       .metadata = {{"box", fmt::format("{} {} {}", i, j, k)},
                    {"rest_point", fmt::format("{} {} {}", p.x, p.y, p.z)},
                    {"determinant", fmt::format("{}", fold.determinant)}}});
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
    const auto report = CertifyAll(FoldCertifier(plan, FoldScope::kSurface), control_points);
    const FoldedBox* const fold = NewFoldUnder(*plan, *report, *before.plan, old);
    return fold == nullptr ? absl::OkStatus() : NewFoldError(*fold);
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
