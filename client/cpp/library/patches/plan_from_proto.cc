// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/patches/plan_from_proto.h"

#include <string>
#include <utility>

#include "client/cpp/library/patches/lattice_from_proto.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

// What the server has sent is not an argument of the caller's.
absl::Status AsDataLoss(const absl::Status& status) {
  if (!absl::IsInvalidArgument(status)) return status;
  return absl::DataLossError(
      fmt::format("the patch plan is damaged: {}", std::string(status.message())));
}

}  // namespace

absl::StatusOr<PatchPlanHeader> FromProto(const v1::PatchPlanHeader& proto) {
  PatchPlanHeader header{.patch_count = proto.patch_count(),
                         .patches_outside = proto.patches_outside(),
                         .vertex_count = proto.vertex_count(),
                         .edge_count = proto.edge_count(),
                         .normal_count = proto.normal_count(),
                         .origin = FromProto(proto.origin()),
                         .outside_lower = FromProto(proto.outside_lower()),
                         .outside_upper = FromProto(proto.outside_upper()),
                         .curvature_unit = proto.curvature_unit(),
                         .weighted = proto.weighted()};
  switch (proto.normals()) {
    case v1::NORMAL_MODE_NONE:
      header.normals = RestNormals::kNone;
      return header;
    case v1::NORMAL_MODE_FACET:
      header.normals = RestNormals::kFacet;
      return header;
    case v1::NORMAL_MODE_SMOOTH:
      header.normals = RestNormals::kSmooth;
      return header;
    default:
      return absl::DataLossError(
          fmt::format("the patch plan has normals {}, which this client does not know",
                      static_cast<int>(proto.normals())));
  }
}

PatchRun FromProto(v1::PatchRun proto) {
  return {.first_patch = proto.first_patch(),
          .patches = proto.patches(),
          .new_vertices = proto.new_vertices(),
          .new_normals = proto.new_normals(),
          .data = std::move(*proto.mutable_data())};
}

PatchSeams FromProto(const v1::PatchSeams& proto) {
  return {.ranges = {proto.ranges().begin(), proto.ranges().end()},
          .vertices = {proto.vertices().begin(), proto.vertices().end()},
          .vertex_seams = {proto.vertex_seams().begin(), proto.vertex_seams().end()},
          .outside_places = {proto.outside_places().begin(), proto.outside_places().end()},
          .edges = {proto.edges().begin(), proto.edges().end()},
          .edge_seams = {proto.edge_seams().begin(), proto.edge_seams().end()},
          .identity_points = {proto.identity_points().begin(), proto.identity_points().end()}};
}

absl::Status PatchPlanMessages::Add(v1::PatchPlanPart part) {
  if (part.has_header() == reader_.has_value()) {
    return absl::DataLossError("a patch plan begins with its header, and has one");
  }
  switch (part.part_case()) {
    case v1::PatchPlanPart::kHeader: {
      LATTICED_ASSIGN_OR_RETURN(const auto header, FromProto(part.header()));
      reader_.emplace(header);
      return absl::OkStatus();
    }
    case v1::PatchPlanPart::kRun:
      return AsDataLoss(reader_->Add(FromProto(std::move(*part.mutable_run()))));
    case v1::PatchPlanPart::kSeams:
      return AsDataLoss(reader_->Add(FromProto(part.seams())));
    default:
      return absl::OkStatus();  // later versions may add parts
  }
}

absl::StatusOr<PatchPlan> PatchPlanMessages::Finish() {
  if (!reader_.has_value()) return absl::DataLossError("the server sent no patch plan");
  auto plan = reader_->Finish();
  if (!plan.ok()) return AsDataLoss(plan.status());
  return plan;
}

}  // namespace latticed::client
