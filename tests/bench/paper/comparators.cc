// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/comparators.h"

#include <utility>

#include "tests/bench/paper/comparator_kernels.h"

namespace latticed::bench {
namespace {

std::vector<double> AllKnots(const DeformPlan& plan) {
  std::vector<double> knots;
  for (const auto& axis : plan.structure.knots) {
    knots.insert(knots.end(), axis.begin(), axis.end());
  }
  return knots;
}

}  // namespace

DeviceLattice::DeviceLattice(std::shared_ptr<const DeformPlan> plan, CudaContext& context)
    : plan_(std::move(plan)),
      memory_(context.memory()),
      lane_(Checked(context.lanes().Borrow())),
      frame_(MakeFrame(context)),
      knots_(Upload(AllKnots(*plan_))) {}

CudaFrame DeviceLattice::MakeFrame(CudaContext& context) const {
  auto room = Checked(
      DeviceReservation::Create(memory_, kPurpose, CudaFrame::DeviceBytesFor(*plan_, false)));
  return Checked(CudaFrame::Create(plan_, nullptr, context, lane_, room));
}

VolumeView DeviceLattice::volume() const {
  VolumeView volume{.control_points = frame_.control_points().data};
  const double* knots = knots_.data();
  for (size_t a = 0; a < 3; ++a) {
    volume.degree[a] = plan_->structure.degree[a];
    volume.size[a] = plan_->structure.size[a];
    volume.knots[a] = knots;
    knots += plan_->structure.knots[a].size();
  }
  return volume;
}

BezierNetMaker::BezierNetMaker(const std::shared_ptr<const DeformPlan>& plan, CudaContext& context)
    : lattice_(plan, context),
      m_(BernsteinCount(plan->structure.patch_degree())),
      patches_(lattice_.Upload(MakeNetPatches(*plan))),
      tables_(lattice_.Upload(std::vector{MakeNetTables(plan->structure.patch_degree())})),
      nets_(lattice_.Allocate<NetPoint>(patches_.size() * static_cast<size_t>(m_ + 1))) {}

void BezierNetMaker::Enqueue(std::span<const Vec3d> control_points) {
  lattice_.Send(control_points);
  const NetJob job{.patches = patches_.data(),
                   .count = patches_.size(),
                   .volume = lattice_.volume(),
                   .tables = tables_.data(),
                   .nets = nets_.data()};
  CheckOk(CudaStatus(LaunchBezierNets(job, m_, lattice_.stream()), "the control nets"));
}

TensorProductMaker::TensorProductMaker(const std::shared_ptr<const DeformPlan>& plan,
                                       const TensorSurfaces& surfaces, CudaContext& context)
    : lattice_(plan, context),
      most_lines_(surfaces.most_lines),
      surfaces_(lattice_.Upload(surfaces.surfaces)),
      lines_(lattice_.Upload(surfaces.lines)),
      points_(lattice_.Upload(surfaces.points)),
      inverse_(lattice_.Upload(std::vector{MakeTensorInverse()})),
      centres_(lattice_.Allocate<Vec3d>(surfaces.count())),
      control_(lattice_.Allocate<float>(surfaces.count() * 3 * kTensorNet)),
      vertices_(lattice_.Allocate<TensorVertex>(surfaces.points.size())) {}

void TensorProductMaker::Enqueue(std::span<const Vec3d> control_points) {
  lattice_.Send(control_points);
  lane().Enqueued("copy");
  const TensorJob job{.surfaces = surfaces_.data(),
                      .count = centres_.size(),
                      .lines = lines_.data(),
                      .points = points_.data(),
                      .inverse = inverse_.data(),
                      .volume = lattice_.volume(),
                      .centres = centres_.data(),
                      .control = control_.data(),
                      .vertices = vertices_.data()};
  CheckOk(CudaStatus(LaunchTensorControl(job, lattice_.stream()), "the control points"));
  lane().Enqueued("control points");
  CheckOk(CudaStatus(LaunchTensorTessellation(job, most_lines_, lattice_.stream()),
                     "the comparator's vertices"));
}

}  // namespace latticed::bench
