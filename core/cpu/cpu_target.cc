// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/cpu/cpu_target.h"

#include <utility>

#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "core/cpu/adaptive/adaptive_view.h"
#include "core/cpu/adaptive/bounds/edge_bound_view.h"
#include "core/cpu/adaptive/surface/fused_surface.h"
#include "core/cpu/adaptive/surface/sampled_surface.h"
#include "core/cpu/cpu_view.h"
#include "core/cpu/fused/cpu_fused.h"
#include "core/cpu/gemm/cpu_gemm.h"
#include "core/cpu/gemm/gemm_kernel.h"
#include "core/cpu/gemm/patch_sampler.h"
#include "core/cpu/host_buffer.h"
#include "core/ffd/plan/shared_points.h"
#include "core/ffd/stage_matrices.h"
#include "core/view/checked_view.h"
#include "core/view/view_encoder.h"
#include "core/view/view_layout.h"

namespace latticed {
namespace {

// T = inv(B) Rs for one patch, as m points in world coordinates.
absl::Status ControlNet(const DeformPlan& plan, const PatchSampler& sampler,
                        const StageMatrices& stage, size_t patch, double* points) {
  const size_t m = stage.m;
  std::vector<double> samples(3 * m), net(3 * m);
  const Vec3d centre = sampler.Sample(patch, samples.data(), nullptr, {}, m);
  LATTICED_RETURN_IF_ERROR(CpuGemm(MatrixView<const double>{stage.inverse.data(), m, m, m},
                                   MatrixView<const double>{samples.data(), m, 3, m},
                                   MatrixView<double>{net.data(), m, 3, m}));
  const Vec3d origin = centre + plan.local_origin;
  for (size_t i = 0; i < m; ++i) {
    for (size_t axis = 0; axis < 3; ++axis) {
      points[3 * i + axis] = net[i + axis * m] + origin[static_cast<int>(axis)];
    }
  }
  return absl::OkStatus();
}

// The fused kernel of a target, as one view uses it.
class FusedViewKernel : public VertexKernel {
 public:
  FusedViewKernel(std::shared_ptr<const FusedKernel> kernel, const ViewSpec& spec,
                  std::shared_ptr<CpuContext> context)
      : kernel_(std::move(kernel)), spec_(spec), context_(std::move(context)) {}

  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks, std::span<uint8_t> vertices) override {
    return kernel_->Evaluate(control_points, box, chunks, spec_, vertices, context_->arena);
  }
  MemoryUse memory() const override { return {}; }

 private:
  const std::shared_ptr<const FusedKernel> kernel_;
  const ViewSpec spec_;
  const std::shared_ptr<CpuContext> context_;
};

class CpuTarget : public DeformTarget {
 public:
  CpuTarget(std::shared_ptr<const DeformPlan> plan, Pipeline pipeline,
            std::shared_ptr<CpuContext> context)
      : plan_(std::move(plan)), pipeline_(pipeline), context_(std::move(context)) {
    if (pipeline == Pipeline::kFused) {
      fused_plan_ = std::make_shared<const fused::FusedPlan>(plan_);
      fused_ = FusedKernel::Create(fused_plan_);
    } else {
      shared_ = std::make_shared<const SharedPoints>(*plan_);
    }
  }

  const DeformPlan& plan() const override { return *plan_; }
  Pipeline pipeline() const override { return pipeline_; }
  bool has_edge_bounds() const override { return pipeline_ == Pipeline::kFused; }

  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override {
    LATTICED_RETURN_IF_ERROR(Validate(spec));
    LATTICED_RETURN_IF_ERROR(CheckSupported(*this, spec));
    if (spec.format == VertexFormat::kEdgeBounds) {
      return CatchBadAlloc("the view", [&]() -> absl::StatusOr<std::unique_ptr<DeformView>> {
        return std::make_unique<EdgeBoundView>(fused_plan_, spec, context_);
      });
    }
    if (spec.tolerance > 0) return CreateAdaptiveView(spec);
    return CatchBadAlloc("the view", [&]() -> absl::StatusOr<std::unique_ptr<DeformView>> {
      std::unique_ptr<VertexKernel> kernel;
      if (fused_ != nullptr) {
        kernel = std::make_unique<FusedViewKernel>(fused_, spec, context_);
      } else {
        LATTICED_ASSIGN_OR_RETURN(const auto stage,
                                  StageMatrices::Get(plan_->surface_degree(), spec.segments));
        kernel = std::make_unique<GemmKernel>(plan_, shared_, *stage, pipeline_, spec, context_);
      }
      LATTICED_ASSIGN_OR_RETURN(
          auto vertices,
          HostBuffer::Create("vertices", MakeVertexLayout(*plan_, spec).total_bytes()));
      return std::make_unique<CpuView>(plan_, spec, std::move(kernel), context_,
                                       std::move(vertices));
    });
  }

  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override {
    LATTICED_RETURN_IF_ERROR(CheckControlNets(*plan_, control_points, first, last));
    // The net does not depend on the segments: any entry of the cache has inv(B).
    LATTICED_ASSIGN_OR_RETURN(const auto stage, StageMatrices::Get(plan_->surface_degree(), 1));
    return CatchBadAlloc("the control nets", [&]() -> absl::StatusOr<std::vector<double>> {
      const PatchSampler sampler(*plan_, *stage, control_points);
      const size_t doubles = 3 * stage->m;
      std::vector<double> nets((last - first) * doubles);
      LATTICED_RETURN_IF_ERROR(context_->arena.TryEach(last - first, [&](size_t i) {
        return ControlNet(*plan_, sampler, *stage, first + i, nets.data() + i * doubles);
      }));
      return nets;
    });
  }

  ViewTraits Traits(const ViewSpec& spec) const override {
    if (spec.format == VertexFormat::kEdgeBounds) {
      return {.host_bytes = EdgeBoundView::MostBytes(*plan_), .encode_batch = plan_->chunk_count()};
    }
    ViewTraits traits{
        .host_bytes = spec.tolerance > 0 ? AdaptiveView::MostBytes(*plan_, spec)
                                         : MakeVertexLayout(*plan_, spec).total_bytes() +
                                               ViewEncoder::MostBytes(spec),
        .encoder_bytes = EncoderBytesOf(*plan_, spec, *context_->encoder, context_->arena)};
    if (pipeline_ == Pipeline::kFused) return traits;
    const size_t threads = context_->arena.most_threads();
    if (spec.tolerance > 0) {
      traits.host_bytes += SampledSurface::MostBytes(*plan_, threads);
      return traits;
    }
    const auto stage = StageMatrices::Get(plan_->surface_degree(), spec.segments);
    if (stage.ok()) {
      traits.host_bytes += GemmKernel::MostBytes(*plan_, **stage, threads);
    }
    return traits;
  }

  MemoryUse memory() const override {
    MemoryUse use{{"plan", plan_->MemoryBytes()}};
    if (shared_ != nullptr) use["plan"] += shared_->MemoryBytes();
    if (fused_plan_ != nullptr) use["plan"] += fused_plan_->layout.MemoryBytes();
    return use;
  }

 private:
  absl::StatusOr<std::unique_ptr<DeformView>> CreateAdaptiveView(const ViewSpec& spec) const {
    return CatchBadAlloc("the view", [&]() -> absl::StatusOr<std::unique_ptr<DeformView>> {
      std::unique_ptr<AdaptiveSurface> surface;
      if (fused_plan_ != nullptr) {
        surface = std::make_unique<FusedSurface>(fused_plan_, spec, context_->arena);
      } else {
        // Control nets do not depend on the segments.
        LATTICED_ASSIGN_OR_RETURN(const auto stage, StageMatrices::Get(plan_->surface_degree(), 1));
        surface = std::make_unique<SampledSurface>(plan_, *stage, spec, context_->arena);
      }
      return std::make_unique<AdaptiveView>(plan_, spec, std::move(surface), context_);
    });
  }

  std::shared_ptr<const DeformPlan> plan_;
  Pipeline pipeline_;
  std::shared_ptr<CpuContext> context_;
  std::shared_ptr<const SharedPoints> shared_;          // GEMM pipelines only
  std::shared_ptr<const fused::FusedPlan> fused_plan_;  // pipeline fused only, as is fused_
  std::shared_ptr<const FusedKernel> fused_;
};

}  // namespace

absl::StatusOr<std::shared_ptr<DeformTarget>> MakeCpuTarget(std::shared_ptr<const DeformPlan> plan,
                                                            Pipeline pipeline,
                                                            std::shared_ptr<CpuContext> context) {
  LATTICED_RETURN_IF_ERROR(CheckSupported(*plan, pipeline));
  return CatchBadAlloc("the plan", [&]() -> absl::StatusOr<std::shared_ptr<DeformTarget>> {
    return std::make_shared<CpuTarget>(std::move(plan), pipeline, std::move(context));
  });
}

}  // namespace latticed
