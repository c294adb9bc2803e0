// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads a patch plan as the C++ client does, and evaluates it. An accepted plan must name nothing that is not there.
//
//   byte 0      0: PatchRun.data are zlib streams as they are; else they are the arrays, which this program compresses
//   then        PatchPlanPart messages, each behind its length as a varint
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/util/delimited_message_util.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "client/cpp/library/patches/patch_evaluator.h"
#include "client/cpp/library/patches/plan_from_proto.h"
#include "core/patches/zlib_stream.h"

namespace latticed::client {
namespace {

void Require(bool holds) {
  if (!holds) std::abort();
}

// The lattice of the seeds.
Lattice UnitLattice() {
  Bounds bounds;
  bounds.Extend(Vec3d{0, 0, 0});
  bounds.Extend(Vec3d{1, 1, 1});
  return FitLattice(bounds, {3, 4, 2}, {1, 2, 1}, 0).value();
}

std::optional<PatchPlan> Read(const uint8_t* data, size_t size) {
  google::protobuf::io::ArrayInputStream stream(data + 1, static_cast<int>(size - 1));
  PatchPlanMessages messages;
  while (true) {
    v1::PatchPlanPart part;
    bool at_end = false;
    if (!google::protobuf::util::ParseDelimitedFromZeroCopyStream(&part, &stream, &at_end)) break;
    if (data[0] != 0 && part.has_run()) {
      part.mutable_run()->set_data(Deflate(part.run().data()).value());
    }
    if (!messages.Add(std::move(part)).ok()) return std::nullopt;
  }
  auto plan = messages.Finish();
  if (!plan.ok()) return std::nullopt;
  return *std::move(plan);
}

bool AreBelow(const std::array<uint32_t, 3>& numbers, size_t count) {
  return std::ranges::all_of(numbers, [count](uint32_t n) { return n < count; });
}

bool AreSeams(const PatchPlan& plan, const std::vector<uint32_t>& seams, size_t count) {
  return seams.size() == (plan.seam_ranges.empty() ? 0 : count) &&
         std::ranges::all_of(seams, [&](uint32_t seam) {
           return seam == PatchPlan::kNoSeam || seam < plan.seam_ranges.size();
         });
}

void RequireSound(const PatchPlan& plan) {
  const PatchPlanHeader& header = plan.header;
  Require(plan.patches.size() == header.patch_count);
  Require(plan.places.size() == header.vertex_count);
  Require(plan.rest_normals.size() == header.normal_count);
  const bool has_slopes = header.weighted && header.normals != RestNormals::kNone;
  Require(plan.weights.size() == (header.weighted ? plan.places.size() : 0));
  Require(plan.slopes.size() == (has_slopes ? plan.patches.size() : 0));
  for (const PatchPlan::Patch& patch : plan.patches) {
    Require(AreBelow(patch.vertex, plan.places.size()));
    Require(AreBelow(patch.edge, header.edge_count));
    if (header.normals != RestNormals::kNone) {
      Require(AreBelow(patch.normal, plan.rest_normals.size()));
    }
  }
  Require(AreSeams(plan, plan.vertex_seams, plan.places.size()));
  Require(AreSeams(plan, plan.edge_seams, header.edge_count));
}

void Evaluate(PatchPlan plan) {
  static const Lattice lattice = UnitLattice();
  std::vector<uint8_t> bounds(plan.header.edge_count);
  for (size_t e = 0; e < bounds.size(); e += 7) bounds[e] = 255;  // nothing is known: level 5
  auto evaluator =
      PatchEvaluator::Create(std::make_shared<const PatchPlan>(std::move(plan)), lattice.structure);
  if (!evaluator.ok()) return;
  PatchSurface surface;
  if (!evaluator->Evaluate(lattice.control_points, bounds, 1, &surface).ok()) return;
  for (const auto& triangle : surface.triangles) {
    Require(AreBelow(triangle, surface.positions.size()));
  }
}

}  // namespace
}  // namespace latticed::client

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 2) return 0;
  auto plan = latticed::client::Read(data, size);
  if (!plan.has_value()) return 0;
  latticed::client::RequireSound(*plan);
  latticed::client::Evaluate(*std::move(plan));
  return 0;
}
