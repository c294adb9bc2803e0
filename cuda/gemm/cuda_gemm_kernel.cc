// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/gemm/cuda_gemm_kernel.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "core/view/view_layout.h"
#include "cuda/device/cuda_status.h"

namespace latticed {
namespace {

// The most bytes of a tile's matrices: enough to fill the device, and little of its memory. For
// kGemm at degree 2 x 2 x 2, 10 segments and facet normals, a tile has 198,000 patches.
constexpr size_t kTileBytes = size_t{512} << 20;
// A tile takes at most one kTileShare-th of the budget.
constexpr size_t kTileShare = 4;
constexpr char kPurpose[] = "samples";

template <typename T>
DeviceMatrix<T> Matrix(const DeviceBuffer<T>& buffer, size_t rows, size_t patches) {
  return {buffer.data(), rows, 3 * patches, rows};
}

}  // namespace

absl::StatusOr<std::unique_ptr<CudaGemmKernel>> CudaGemmKernel::Create(
    std::shared_ptr<const DeformPlan> plan, std::shared_ptr<DevicePlan> device_plan,
    Pipeline pipeline, const ViewSpec& spec, std::shared_ptr<CudaContext> context,
    std::shared_ptr<CudaLane> lane, DeviceReservation& from) {
  LATTICED_ASSIGN_OR_RETURN(auto stage,
                            context->Stage(plan->surface_degree(), spec.segments, from));
  LATTICED_ASSIGN_OR_RETURN(auto stages,
                            CudaGemmStages::Create(pipeline, std::move(stage),
                                                   spec.normals != NormalMode::kNone, from, *lane));
  LATTICED_ASSIGN_OR_RETURN(const auto tables,
                            device_plan->Tables(spec.normals == NormalMode::kSmooth, from));
  return std::unique_ptr<CudaGemmKernel>(
      new CudaGemmKernel(std::move(plan), std::move(device_plan), spec, std::move(context),
                         std::move(lane), std::move(stages), tables));
}

CudaGemmKernel::CudaGemmKernel(std::shared_ptr<const DeformPlan> plan,
                               std::shared_ptr<DevicePlan> device_plan, const ViewSpec& spec,
                               std::shared_ptr<CudaContext> context, std::shared_ptr<CudaLane> lane,
                               CudaGemmStages stages, kernels::PlanTables tables)
    : plan_(std::move(plan)),
      device_plan_(std::move(device_plan)),
      spec_(spec),
      context_(std::move(context)),
      lane_(std::move(lane)),
      stages_(std::move(stages)),
      tables_(tables),
      tile_patches_(TilePatches()) {}

uint64_t CudaGemmKernel::MostTileBytes(uint64_t budget_bytes) {
  return std::min<uint64_t>(kTileBytes, budget_bytes / kTileShare);
}

size_t CudaGemmKernel::TilePatches() const {
  const size_t m = stages_.stage().m(), q = stages_.stage().q(), times = smooth() ? 2 : 1;
  size_t bytes = 3 * (m * times + stages_.rows() + (smooth() ? q : 0)) * sizeof(float);
  if (stages_.in_double()) bytes += 3 * m * (times + 1) * sizeof(double);
  const size_t room = MostTileBytes(context_->memory()->budget_bytes());
  return std::clamp<size_t>(room / bytes, 1, std::max<size_t>(plan_->patches.size(), 1));
}

absl::Status CudaGemmKernel::Allocate() {
  if (buffers_.centres.size() > 0) return absl::OkStatus();
  const size_t columns = 3 * tile_patches_, m = stages_.stage().m(), q = stages_.stage().q();
  const bool in_double = stages_.in_double();
  Buffers made;
  const auto for_each = [&](const auto& use) {
    use(made.samples, m * columns);
    if (smooth()) use(made.by_normal, m * columns);
    if (in_double) use(made.samples_d, m * columns);
    if (in_double && smooth()) use(made.by_normal_d, m * columns);
    if (in_double) use(made.control_d, m * columns);
    use(made.surface, stages_.rows() * columns);
    if (smooth()) use(made.across, q * columns);
    if (spec_.normals != NormalMode::kNone) use(made.ill, kernels::IllWords(q * tile_patches_));
    use(made.centres, tile_patches_);
  };
  uint64_t bytes = 0;
  for_each([&]<typename T>(const DeviceBuffer<T>&, size_t count) { bytes += count * sizeof(T); });
  auto room = DeviceReservation::Create(context_->memory(), kPurpose, bytes);
  absl::Status status = room.status();
  for_each([&]<typename T>(DeviceBuffer<T>& buffer, size_t count) {
    if (!status.ok()) return;
    auto result = DeviceBuffer<T>::Create(*room, kPurpose, count, lane_->stream().get());
    status = result.status();
    if (result.ok()) buffer = *std::move(result);
  });
  if (status.ok()) buffers_ = std::move(made);
  return status;
}

absl::Status CudaGemmKernel::Evaluate(const CudaFrame& frame, const QuantisationBox& box,
                                      std::span<const uint32_t> /*chunks: always all*/,
                                      DeviceSpan<uint8_t> vertices) {
  LATTICED_RETURN_IF_ERROR(frame.Send());
  lane_->Enqueued("copy");
  LATTICED_RETURN_IF_ERROR(Allocate());
  LATTICED_RETURN_IF_ERROR(stages_.Begin());
  lane_->Enqueued("stack");
  const VertexWriter writer = MakeVertexWriter(*plan_, spec_, box);
  for (size_t first = 0; first < plan_->patches.size(); first += tile_patches_) {
    const size_t count = std::min(tile_patches_, plan_->patches.size() - first);
    LATTICED_RETURN_IF_ERROR(
        EvaluateTile({tables_, device_plan_->turned(), frame.control_points().data, first, count},
                     writer, vertices));
  }
  const kernels::SharedPositions shared{.tables = device_plan_->shared_points(),
                                        .turned = device_plan_->turned(),
                                        .attached = frame.attached().data,
                                        .segments = spec_.segments,
                                        .layout = MakeVertexLayout(*plan_, spec_),
                                        .writer = writer,
                                        .vertices = vertices.data};
  return CudaStatus(kernels::LaunchSharedPoints(tables_, frame.control_points().data, shared,
                                                lane_->stream().get()),
                    "the shared points");
}

absl::Status CudaGemmKernel::EvaluateTile(const kernels::Tile& tile, const VertexWriter& writer,
                                          DeviceSpan<uint8_t> vertices) {
  LATTICED_RETURN_IF_ERROR(Products(tile));
  lane_->Enqueued("products");
  const DeviceStage& stage = stages_.stage();
  const kernels::Surface surface{.products = buffers_.surface.data(),
                                 .across = buffers_.across.data(),
                                 .rows = stages_.rows(),
                                 .centres = buffers_.centres.data(),
                                 .pattern = stage.pattern(),
                                 .segments = stage.segments(),
                                 .q = static_cast<int>(stage.q()),
                                 .normals = NormalsOf(spec_.normals),
                                 .ill = buffers_.ill.data(),
                                 .layout = MakeVertexLayout(*plan_, spec_),
                                 .writer = writer,
                                 .vertices = vertices.data};
  const cudaError_t launched = kernels::LaunchSurface(tile, surface, lane_->stream().get());
  lane_->Enqueued("rearrange");
  return CudaStatus(launched, "the vertices");
}

absl::Status CudaGemmKernel::Products(const kernels::Tile& tile) {
  LATTICED_RETURN_IF_ERROR(
      stages_.in_double() ? Sample(tile, buffers_.samples_d.data(), buffers_.by_normal_d.data())
                          : Sample(tile, buffers_.samples.data(), buffers_.by_normal.data()));
  LATTICED_RETURN_IF_ERROR(
      Apply(tile, buffers_.samples_d, buffers_.samples, buffers_.surface, stages_.rows()));
  if (!smooth()) return absl::OkStatus();
  return Apply(tile, buffers_.by_normal_d, buffers_.by_normal, buffers_.across,
               stages_.stage().q());
}

template <typename T>
absl::Status CudaGemmKernel::Sample(const kernels::Tile& tile, T* positions, T* by_normal) {
  const DeviceStage& stage = stages_.stage();
  const kernels::Samples<T> samples{.points = stage.samples(),
                                    .degree = stage.degree(),
                                    .m = static_cast<int>(stage.m()),
                                    .positions = positions,
                                    .by_normal = by_normal,
                                    .centres = buffers_.centres.data()};
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(kernels::LaunchSamples(tile, samples, lane_->stream().get()), "the samples"));
  lane_->Enqueued("samples");
  return absl::OkStatus();
}

absl::Status CudaGemmKernel::Apply(const kernels::Tile& tile, const DeviceBuffer<double>& in_double,
                                   const DeviceBuffer<float>& samples,
                                   const DeviceBuffer<float>& out, size_t rows) {
  const size_t m = stages_.stage().m();
  const DeviceMatrix<float> rounded = Matrix(samples, m, tile.count);
  const DeviceMatrix<float> products = Matrix(out, rows, tile.count);
  if (!stages_.in_double()) return stages_.Apply(rounded, products);
  return stages_.Apply(Matrix(in_double, m, tile.count), Matrix(buffers_.control_d, m, tile.count),
                       rounded, products);
}

size_t CudaGemmKernel::Buffers::bytes() const {
  return samples.size_bytes() + by_normal.size_bytes() + samples_d.size_bytes() +
         by_normal_d.size_bytes() + control_d.size_bytes() + surface.size_bytes() +
         across.size_bytes() + ill.size_bytes() + centres.size_bytes();
}

MemoryUse CudaGemmKernel::memory() const {
  return {{"device_samples", buffers_.bytes()}, {"device_stage_matrices", stages_.MemoryBytes()}};
}

}  // namespace latticed
