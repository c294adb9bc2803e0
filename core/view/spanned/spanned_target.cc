// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/view/spanned/spanned_target.h"

#include <algorithm>
#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "core/patches/edge_order.h"
#include "core/view/checked_view.h"
#include "core/view/spanned/spanned_bound_view.h"
#include "core/view/spanned/spanned_view.h"

namespace latticed {
namespace {

std::shared_ptr<const SharedEdges> EdgesAt(const DeformPlan& plan,
                                           const std::vector<SpannedTarget::Part>& parts) {
  std::vector<uint32_t> first_chunks;
  first_chunks.reserve(parts.size());
  for (const SpannedTarget::Part& part : parts) first_chunks.push_back(part.first_chunk);
  return std::make_shared<const SharedEdges>(SharedEdges::Find(plan, first_chunks));
}

}  // namespace

SpannedTarget::SpannedTarget(std::shared_ptr<const DeformPlan> plan, std::vector<Part> parts)
    : plan_(std::move(plan)), parts_(std::move(parts)), shared_edges_(EdgesAt(*plan_, parts_)) {}

absl::StatusOr<std::unique_ptr<DeformView>> SpannedTarget::CreateView(const ViewSpec& spec) {
  LATTICED_RETURN_IF_ERROR(CheckSupported(*this, spec));
  return CatchBadAlloc("the view", [&]() -> absl::StatusOr<std::unique_ptr<DeformView>> {
    if (spec.format == VertexFormat::kEdgeBounds) return CreateBoundView(spec);
    std::vector<SpannedView::Part> parts;
    std::vector<DeformView*> views;
    for (const Part& part : parts_) {
      LATTICED_ASSIGN_OR_RETURN(auto view, part.target->CreateView(spec));
      views.push_back(view.get());
      parts.push_back({part.first_chunk, std::move(view)});
    }
    std::unique_ptr<ToleranceExchange> exchange;
    if (spec.tolerance > 0) {
      LATTICED_ASSIGN_OR_RETURN(exchange,
                                ToleranceExchange::Create(*plan_, spec, shared_edges_, views));
    }
    return std::make_unique<SpannedView>(plan_, spec, std::move(parts), std::move(exchange));
  });
}

absl::StatusOr<std::unique_ptr<DeformView>> SpannedTarget::CreateBoundView(
    const ViewSpec& spec) const {
  std::vector<SpannedBoundView::Slice> slices;
  for (const Part& part : parts_) {
    LATTICED_ASSIGN_OR_RETURN(auto view, part.target->CreateView(spec));
    slices.push_back({part.first_chunk, FirstEdges(part.target->plan()), std::move(view)});
  }
  return SpannedBoundView::Create(plan_, spec, shared_edges_, std::move(slices));
}

absl::StatusOr<std::vector<double>> SpannedTarget::ControlNets(
    std::span<const Vec3d> control_points, size_t first, size_t last) {
  LATTICED_RETURN_IF_ERROR(CheckControlNets(*plan_, control_points, first, last));
  return CatchBadAlloc("the control nets", [&]() -> absl::StatusOr<std::vector<double>> {
    std::vector<double> nets;
    for (const Part& part : parts_) {
      const size_t begin = plan_->ChunkPatches(part.first_chunk)[0];
      const size_t end = begin + part.target->plan().patches.size();
      const size_t from = std::clamp(first, begin, end), to = std::clamp(last, begin, end);
      if (from == to) continue;
      LATTICED_ASSIGN_OR_RETURN(const auto some,
                                part.target->ControlNets(control_points, from - begin, to - begin));
      nets.insert(nets.end(), some.begin(), some.end());
    }
    return nets;
  });
}

ViewTraits SpannedTarget::Traits(const ViewSpec& spec) const {
  ViewTraits sum{.encode_batch = 0, .device_chunks = {}};
  if (spec.tolerance > 0) sum.host_bytes = ToleranceExchange::MostBytes(*shared_edges_);
  for (const Part& part : parts_) {
    const ViewTraits traits = part.target->Traits(spec);
    sum.on_device = traits.on_device;
    sum.host_bytes += traits.host_bytes;
    sum.encoder_bytes += traits.encoder_bytes;
    sum.encode_batch += traits.encode_batch;
    sum.device_chunks.push_back(part.first_chunk);
  }
  if (spec.format == VertexFormat::kEdgeBounds) {
    sum.host_bytes += SpannedBoundView::MostBytes(*plan_, *shared_edges_);
    sum.device_chunks = {0};  // Encode asks nothing of the devices
  }
  return sum;
}

MemoryUse SpannedTarget::memory() const {
  MemoryUse use{{"plan", plan_->MemoryBytes() + shared_edges_->MemoryBytes()}};
  for (const Part& part : parts_) {
    for (const auto& [purpose, bytes] : part.target->memory()) use[purpose] += bytes;
    use["plan"] += part.target->plan().mesh->MemoryBytes();  // a slice's own
  }
  return use;
}

DeviceUse SpannedTarget::device_use() const {
  DeviceUse use;
  for (const Part& part : parts_) {
    for (const auto& [device, bytes] : part.target->device_use()) use[device] += bytes;
  }
  return use;
}

}  // namespace latticed
