// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "cuda/points/cuda_points.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/catch_bad_alloc.h"
#include "core/base/status_macros.h"
#include "cuda/device/cuda_status.h"
#include "cuda/points/device_points.h"
#include "cuda/points/point_kernels.h"

namespace latticed {
namespace {

constexpr char kScratchPurpose[] = "staging";
constexpr char kPointsWork[] = "the points";
// Polynomials of so many boxes, 1.6 MB, are on the host at once; a thread makes kBoxGrain at a time.
constexpr size_t kBoxesTogether = 1'024, kBoxGrain = 32;

enum class Polynomials { kOfPoints, kVelocities };

// The device memory of one call.
struct PointScratch {
  std::shared_ptr<CudaLane> lane;  // before the buffers, which are freed on its stream
  DeviceBuffer<BoxPolynomial> values, shape;
  DeviceBuffer<Vec3d> vectors;  // of one direction: an answer, or cotangents
  DeviceBuffer<BoxNumbers> of_pieces, of_boxes;

  cudaStream_t stream() const { return lane->stream().get(); }
};

absl::Status LaunchPoints(kernels::KernelCall call, cudaStream_t stream) {
  return CudaStatus(call.Launch(stream), kPointsWork);
}

// The elements of the host may be overwritten at once, since they are pageable.
template <class T>
absl::Status SendToDevice(std::span<const T> from, const DeviceBuffer<T>& to, size_t first,
                          cudaStream_t stream) {
  if (from.empty()) return absl::OkStatus();
  return CudaStatus(cudaMemcpyAsync(to.data() + first, from.data(), from.size_bytes(),
                                    cudaMemcpyHostToDevice, stream),
                    kPointsWork);
}

// Waits for the stream.
template <class T>
absl::Status FetchAndWait(const DeviceBuffer<T>& from, std::span<T> to, const CudaLane& lane) {
  absl::Status status;
  if (!to.empty()) {
    status = CudaStatus(cudaMemcpyAsync(to.data(), from.data(), to.size_bytes(),
                                        cudaMemcpyDeviceToHost, lane.stream().get()),
                        kPointsWork);
  }
  status.Update(lane.stream().Synchronize(kPointsWork));
  return status;
}

class CudaPoints : public PointEvaluator {
 public:
  CudaPoints(std::shared_ptr<const SortedPoints> points, std::shared_ptr<CudaContext> context,
             DevicePoints device)
      : points_(std::move(points)), context_(std::move(context)), device_(std::move(device)) {}
  ~CudaPoints() override {
    const DeviceGuard guard(context_->device());
    device_.reset();
  }

  const SortedPoints& points() const override { return *points_; }

  absl::Status Deform(std::span<const Vec3d> control_points, PointNormals normals, StopCheck stop,
                      std::span<Vec3d> out) override {
    return Run([&]() -> absl::Status {
      LATTICED_RETURN_IF_ERROR(stop());
      LATTICED_ASSIGN_OR_RETURN(const PointScratch scratch, MakeScratch(out.size(), true, false));
      return Evaluate(control_points, Polynomials::kOfPoints, normals, scratch, out);
    });
  }

  absl::Status ApplyJacobian(std::span<const Vec3d> control_points, std::span<const Vec3d> tangents,
                             PointNormals normals, StopCheck stop, std::span<Vec3d> out) override {
    return Run([&]() -> absl::Status {
      const bool with_normals = normals == PointNormals::kWanted;
      const size_t values = VectorsPerDirection(*points_, normals), count = control_points.size();
      LATTICED_ASSIGN_OR_RETURN(const PointScratch scratch,
                                MakeScratch(values, true, with_normals));
      if (with_normals) {
        LATTICED_RETURN_IF_ERROR(
            SendPolynomials(control_points, Polynomials::kOfPoints, scratch.shape, scratch));
      }
      for (size_t d = 0; d < tangents.size() / count; ++d) {
        LATTICED_RETURN_IF_ERROR(stop());
        LATTICED_RETURN_IF_ERROR(Evaluate(tangents.subspan(d * count, count),
                                          Polynomials::kVelocities, normals, scratch,
                                          out.subspan(d * values, values)));
      }
      return absl::OkStatus();
    });
  }

  absl::Status ApplyJacobianTranspose(std::span<const Vec3d> control_points,
                                      std::span<const Vec3d> cotangents, PointNormals normals,
                                      StopCheck stop, std::span<Vec3d> gradients) override {
    return Run([&]() -> absl::Status {
      const bool with_normals = normals == PointNormals::kWanted;
      const size_t values = VectorsPerDirection(*points_, normals), count = control_points.size();
      LATTICED_ASSIGN_OR_RETURN(const PointScratch scratch,
                                MakeScratch(values, false, with_normals, true));
      if (with_normals) {
        LATTICED_RETURN_IF_ERROR(
            SendPolynomials(control_points, Polynomials::kOfPoints, scratch.shape, scratch));
      }
      const kernels::PointSums sums{
          device_->tables(), with_normals ? scratch.shape.data() : nullptr, scratch.vectors.data(),
          scratch.of_pieces.data(), scratch.of_boxes.data()};
      std::vector<BoxNumbers> of_boxes(device_->boxes().size());
      std::ranges::fill(gradients, Vec3d());
      for (size_t d = 0; d < cotangents.size() / values; ++d) {
        LATTICED_RETURN_IF_ERROR(stop());
        LATTICED_RETURN_IF_ERROR(SendToDevice(cotangents.subspan(d * values, values),
                                              scratch.vectors, 0, scratch.stream()));
        // After a launch nothing returns before the stream has passed it, since it reads the points.
        absl::Status status;
        if (!of_boxes.empty()) {
          status = LaunchPoints(kernels::SumCall(sums), scratch.stream());
          status.Update(LaunchPoints(kernels::AddCall(sums), scratch.stream()));
        }
        status.Update(FetchAndWait(scratch.of_boxes, std::span(of_boxes), *scratch.lane));
        LATTICED_RETURN_IF_ERROR(status);
        for (size_t slot = 0; slot < of_boxes.size(); ++slot) {
          points_->boxes().AddGradient(device_->boxes()[slot], of_boxes[slot],
                                       gradients.subspan(d * count, count));
        }
      }
      return absl::OkStatus();
    });
  }

  uint64_t TransposeBytes(size_t /*directions*/, PointNormals /*normals*/) const override {
    return device_->boxes().size() * sizeof(BoxNumbers);
  }
  uint64_t device_bytes() const override { return device_->bytes(); }

 private:
  template <class Work>
  absl::Status Run(const Work& work) const {
    const DeviceGuard guard(context_->device());
    return CatchBadAlloc(kPointsWork, work);
  }

  // Room for so many vectors, polynomials of values and of the shape, and sums.
  absl::StatusOr<PointScratch> MakeScratch(size_t vectors, bool values, bool shape,
                                           bool sums = false) const {
    const size_t boxes = device_->boxes().size(), pieces = device_->tables().piece_count;
    const uint64_t bytes = vectors * sizeof(Vec3d) +
                           ((values ? boxes : 0) + (shape ? boxes : 0)) * sizeof(BoxPolynomial) +
                           (sums ? boxes + pieces : 0) * sizeof(BoxNumbers);
    PointScratch scratch;
    LATTICED_ASSIGN_OR_RETURN(scratch.lane, context_->lanes().Borrow());
    LATTICED_ASSIGN_OR_RETURN(auto room,
                              DeviceReservation::Create(context_->memory(), kPointsWork, bytes));
    const auto make = [&]<class T>(DeviceBuffer<T>& buffer, size_t count) -> absl::Status {
      LATTICED_ASSIGN_OR_RETURN(
          buffer, DeviceBuffer<T>::Create(room, kScratchPurpose, count, scratch.stream()));
      return absl::OkStatus();
    };
    LATTICED_RETURN_IF_ERROR(make(scratch.vectors, vectors));
    LATTICED_RETURN_IF_ERROR(make(scratch.values, values ? boxes : 0));
    LATTICED_RETURN_IF_ERROR(make(scratch.shape, shape ? boxes : 0));
    LATTICED_RETURN_IF_ERROR(make(scratch.of_pieces, sums ? pieces : 0));
    LATTICED_RETURN_IF_ERROR(make(scratch.of_boxes, sums ? boxes : 0));
    return scratch;
  }

  absl::Status SendPolynomials(std::span<const Vec3d> points, Polynomials kind,
                               const DeviceBuffer<BoxPolynomial>& to,
                               const PointScratch& scratch) const {
    const BoxMaps& boxes = points_->boxes();
    const size_t slots = device_->boxes().size();
    std::vector<BoxPolynomial> some(std::min(slots, kBoxesTogether));
    for (size_t first = 0; first < slots; first += kBoxesTogether) {
      const size_t count = std::min(kBoxesTogether, slots - first);
      const auto make = [&](size_t i) {
        const size_t box = device_->boxes()[first + i];
        some[i] = kind == Polynomials::kOfPoints ? boxes.PolynomialOf(box, points)
                                                 : boxes.VelocityOf(box, points);
      };
      context_->arena().ForEach(count, make, kBoxGrain);
      LATTICED_RETURN_IF_ERROR(SendToDevice(std::span<const BoxPolynomial>(some.data(), count), to,
                                            first, scratch.stream()));
    }
    return absl::OkStatus();
  }

  // Values of one direction, made of `points` or of their velocities.
  absl::Status Evaluate(std::span<const Vec3d> points, Polynomials kind, PointNormals normals,
                        const PointScratch& scratch, std::span<Vec3d> out) const {
    LATTICED_RETURN_IF_ERROR(SendPolynomials(points, kind, scratch.values, scratch));
    const bool velocities = kind == Polynomials::kVelocities;
    const kernels::PointDeform deform{device_->tables(), scratch.values.data(),
                                      scratch.shape.data(), normals == PointNormals::kWanted,
                                      scratch.vectors.data()};
    absl::Status status;
    if (!points_->runs().empty()) {
      status = LaunchPoints(kernels::DeformCall(deform), scratch.stream());
    }
    if (points_->inside() < points_->size()) {
      status.Update(LaunchPoints(kernels::OutsideCall(deform, velocities), scratch.stream()));
    }
    status.Update(FetchAndWait(scratch.vectors, out, *scratch.lane));
    return status;
  }

  const std::shared_ptr<const SortedPoints> points_;
  const std::shared_ptr<CudaContext> context_;
  std::optional<DevicePoints> device_;
};

}  // namespace

absl::StatusOr<std::shared_ptr<PointEvaluator>> MakeCudaPoints(
    std::shared_ptr<const SortedPoints> points, std::shared_ptr<CudaContext> context) {
  const DeviceGuard guard(context->device());
  return CatchBadAlloc(kPointsWork, [&]() -> absl::StatusOr<std::shared_ptr<PointEvaluator>> {
    LATTICED_ASSIGN_OR_RETURN(auto device, DevicePoints::Create(*points, *context));
    return std::make_shared<CudaPoints>(std::move(points), std::move(context), std::move(device));
  });
}

}  // namespace latticed
