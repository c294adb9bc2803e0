// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Point sets on a device: refusals for want of memory, and several calls at once. Their values: tests/backend/points_test.cc.
#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "core/base/error.h"
#include "core/points/point_evaluator.h"
#include "cuda/cuda_backend.h"
#include "tests/core/points/point_fixture.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {
namespace {

constexpr size_t kCudaPoints = 30'000;

class CudaPointsTest : public CudaTest {
 protected:
  CudaPointsTest() : CudaTest(26) {}

  absl::StatusOr<std::shared_ptr<PointEvaluator>> Prepare(Backend& backend) {
    return backend.PreparePoints(sorted_);
  }
  absl::Status Transpose(PointEvaluator& points, std::vector<Vec3d>& gradient) {
    gradient.resize(control_points_.size());
    return points.ApplyJacobianTranspose(control_points_, cotangents_, PointNormals::kWanted,
                                         NeverStop, gradient);
  }
  // All three calls, with normals.
  absl::Status CallAll(PointEvaluator& points) {
    std::vector<Vec3d> out(2 * kCudaPoints), gradient;
    LATTICED_RETURN_IF_ERROR(points.Deform(control_points_, PointNormals::kWanted, NeverStop, out));
    LATTICED_RETURN_IF_ERROR(points.ApplyJacobian(control_points_, control_points_,
                                                  PointNormals::kWanted, NeverStop, out));
    return Transpose(points, gradient);
  }

  RandomVectors random_{26};
  CpuArena arena_{2};
  const LatticeStructure structure_ = ObliqueStructure({2, 3, 1}, {2, 1, 3});
  const std::vector<Vec3d> control_points_ = random_.Jittered(structure_, 0.2);
  const std::vector<Vec3d> cotangents_ = random_.Some(2 * kCudaPoints);
  const std::shared_ptr<const SortedPoints> sorted_ = std::make_shared<const SortedPoints>(
      structure_, random_.Around(structure_, kCudaPoints), random_.Units(kCudaPoints), arena_);
};

TEST_F(CudaPointsTest, ASetThatDoesNotFitIsRefusedBeforeAnythingIsAllocated) {
  ASSERT_OK_AND_ASSIGN(const auto large, MakeCudaBackend({.memory_bytes = 256 * kMiB}));
  ASSERT_OK_AND_ASSIGN(const auto points, Prepare(*large));
  const uint64_t bytes = points->device_bytes();
  ASSERT_OK_AND_ASSIGN(const auto enough, MakeCudaBackend({.memory_bytes = bytes}));
  ASSERT_OK_AND_ASSIGN(const auto small, MakeCudaBackend({.memory_bytes = bytes - 1}));

  const auto refused = Prepare(*small);

  ASSERT_THAT(refused, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(error::DetailsOf(refused.status()).asked_bytes, bytes);
  EXPECT_EQ(error::DetailsOf(refused.status()).free_bytes, bytes - 1);
  EXPECT_EQ(small->devices().front().use, MemoryUse());
  EXPECT_OK(Prepare(*enough));
}

TEST_F(CudaPointsTest, ACallThatDoesNotFitIsRefusedAndASmallerOneIsNot) {
  ASSERT_OK_AND_ASSIGN(const auto large, MakeCudaBackend({.memory_bytes = 256 * kMiB}));
  ASSERT_OK_AND_ASSIGN(const auto first, Prepare(*large));
  const uint64_t bytes = first->device_bytes() + 30 * kCudaPoints;  // 24 fit, 48 do not
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend({.memory_bytes = bytes}));
  ASSERT_OK_AND_ASSIGN(const auto points, Prepare(*backend));
  const DeviceState before = backend->devices().front();
  std::vector<Vec3d> out(2 * kCudaPoints);

  EXPECT_THAT(points->Deform(control_points_, PointNormals::kWanted, NeverStop, out),
              StatusIs(absl::StatusCode::kResourceExhausted));

  EXPECT_EQ(backend->devices().front().free_bytes, before.free_bytes);
  EXPECT_OK(points->Deform(control_points_, PointNormals::kNone, NeverStop,
                           std::span(out).first(kCudaPoints)));
}

TEST_F(CudaPointsTest, EveryFailedAllocationIsToldAndTheNextCallWorks) {
  int left = 0;
  ASSERT_OK_AND_ASSIGN(const auto backend,
                       MakeCudaBackend({.memory_bytes = 256 * kMiB,
                                        .refuse_allocation = [&](std::string_view, uint64_t) {
                                          return left-- == 0;
                                        }}));
  int refused = 0;
  for (int nth = 0; nth < 100; ++nth) {
    left = nth;
    const auto made = Prepare(*backend);
    const absl::Status status = made.ok() ? CallAll(**made) : made.status();
    if (status.ok()) break;
    ++refused;
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted)) << nth;
    left = -1;
    ASSERT_OK_AND_ASSIGN(const auto points, Prepare(*backend));
    EXPECT_OK(CallAll(*points));
  }
  EXPECT_GE(refused, 12) << "eight tables, and scratch of three calls";
}

TEST_F(CudaPointsTest, CallsOfSeveralThreadsHaveTheBitsOfOne) {
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend({.memory_bytes = 256 * kMiB}));
  ASSERT_OK_AND_ASSIGN(const auto points, Prepare(*backend));
  std::vector<Vec3d> expected;
  ASSERT_OK(Transpose(*points, expected));
  std::vector<std::vector<Vec3d>> got(4);
  std::vector<std::thread> threads;
  for (auto& gradient : got) {
    threads.emplace_back([&] {
      for (int run = 0; run < 5; ++run) EXPECT_OK(Transpose(*points, gradient));
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& gradient : got) {
    EXPECT_EQ(std::memcmp(gradient.data(), expected.data(), expected.size() * sizeof(Vec3d)), 0);
  }
}

}  // namespace
}  // namespace latticed::testing
