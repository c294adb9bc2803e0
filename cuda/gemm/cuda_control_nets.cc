// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/gemm/cuda_control_nets.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/box/bernstein.h"
#include "cuda/gemm/gemm_kernels.h"
#include "cuda/view/cuda_frame.h"

namespace latticed {
namespace {

constexpr size_t kTilePatches = 16'384;  // 26 MB of nets at n = 10

// Device buffers of one tile.
struct Nets {
  DeviceBuffer<double> samples, control;  // m x 3t
  DeviceBuffer<Vec3d> centres;
};

uint64_t BytesOf(size_t m, size_t patches) {
  return (2 * 3 * m * sizeof(double) + sizeof(Vec3d)) * patches;
}

absl::StatusOr<Nets> Allocate(DeviceReservation& from, const CudaLane& lane, size_t m,
                              size_t patches) {
  const cudaStream_t stream = lane.stream().get();
  LATTICED_ASSIGN_OR_RETURN(auto samples,
                            DeviceBuffer<double>::Create(from, "samples", 3 * m * patches, stream));
  LATTICED_ASSIGN_OR_RETURN(auto control,
                            DeviceBuffer<double>::Create(from, "samples", 3 * m * patches, stream));
  LATTICED_ASSIGN_OR_RETURN(auto centres,
                            DeviceBuffer<Vec3d>::Create(from, "samples", patches, stream));
  return Nets{std::move(samples), std::move(control), std::move(centres)};
}

absl::Status Compute(const kernels::Tile& tile, const DeviceStage& stage, const CudaLane& lane,
                     CudaGemm& gemm, const Nets& nets) {
  const size_t m = stage.m(), columns = 3 * tile.count;
  const kernels::Samples<double> samples{.points = stage.samples(),
                                         .degree = stage.degree(),
                                         .m = static_cast<int>(m),
                                         .positions = nets.samples.data(),
                                         .by_normal = nullptr,
                                         .centres = nets.centres.data()};
  LATTICED_RETURN_IF_ERROR(
      CudaStatus(kernels::LaunchSamples(tile, samples, lane.stream().get()), "the samples"));
  return gemm.Multiply(stage.inverse(),
                       DeviceMatrix<const double>{nets.samples.data(), m, columns, m},
                       DeviceMatrix<double>{nets.control.data(), m, columns, m});
}

template <typename T>
absl::Status Download(const DeviceBuffer<T>& from, std::span<T> to, cudaStream_t stream) {
  return CudaStatus(
      cudaMemcpyAsync(to.data(), from.data(), to.size_bytes(), cudaMemcpyDeviceToHost, stream),
      "the control nets");
}

}  // namespace

absl::StatusOr<std::vector<double>> CudaControlNets(const std::shared_ptr<const DeformPlan>& plan,
                                                    const DevicePlan& device_plan,
                                                    CudaContext& context,
                                                    std::span<const Vec3d> control_points,
                                                    size_t first, size_t last) {
  // The net does not depend on the segments, so the stage of any number of segments has its inv(B).
  const int degree = plan->surface_degree(), any_segments = 1;
  const auto m = static_cast<size_t>(BernsteinCount(degree));
  const size_t tile_patches = std::min(kTilePatches, last - first);
  LATTICED_ASSIGN_OR_RETURN(const auto lane, context.lanes().Borrow());
  LATTICED_ASSIGN_OR_RETURN(
      auto room, DeviceReservation::Create(context.memory(), "the control nets", [&] {
        return CudaFrame::DeviceBytesFor(*plan, false) + BytesOf(m, tile_patches) +
               context.StageBytesToCome(degree, any_segments) + lane->GemmBytesToCome();
      }));
  LATTICED_ASSIGN_OR_RETURN(const auto stage, context.Stage(degree, any_segments, room));
  LATTICED_ASSIGN_OR_RETURN(const auto gemm, lane->gemm(room));
  LATTICED_ASSIGN_OR_RETURN(auto frame, CudaFrame::Create(plan, nullptr, context, lane, room));
  LATTICED_ASSIGN_OR_RETURN(const auto buffers, Allocate(room, *lane, m, tile_patches));

  std::vector<double> nets(3 * m * (last - first)), control(3 * m * tile_patches);
  std::vector<Vec3d> centres(tile_patches);
  const cudaStream_t stream = lane->stream().get();
  LATTICED_RETURN_IF_ERROR(frame.Upload(control_points));
  for (size_t begin = first; begin < last; begin += tile_patches) {
    const size_t count = std::min(tile_patches, last - begin);
    absl::Status status = Compute(
        {device_plan.tables(), device_plan.turned(), frame.control_points().data, begin, count},
        *stage, *lane, *gemm, buffers);
    if (status.ok()) {
      status = Download(buffers.control, std::span(control).first(3 * m * count), stream);
    }
    if (status.ok()) status = Download(buffers.centres, std::span(centres).first(count), stream);
    status.Update(lane->stream().Synchronize("the control nets"));
    if (!status.ok()) return status;
    double* out = nets.data() + 3 * m * (begin - first);
    for (size_t t = 0; t < count; ++t) {
      const Vec3d origin = centres[t] + plan->local_origin;
      for (size_t i = 0; i < m; ++i) {
        for (size_t axis = 0; axis < 3; ++axis) {
          *out++ = control[i + m * (t + axis * count)] + origin[static_cast<int>(axis)];
        }
      }
    }
  }
  return nets;
}

}  // namespace latticed
