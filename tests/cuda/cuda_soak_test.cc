// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes come and go for long: two thousand times a plan is prepared, viewed, evaluated, edited,
// encoded and dropped, and device and host have as much memory afterwards as at the start. Takes
// some seconds.
#include <cuda_runtime_api.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <memory>
#include <vector>

#include "cuda/cuda_backend.h"
#include "fmt/format.h"
#include "tests/cuda/cuda_test.h"

namespace latticed::testing {
namespace {

constexpr size_t kCycles = 2'000;
// By then every pipeline has run with every view: lanes, workspaces and the pool have their size.
constexpr size_t kWarmUp = 200;
constexpr size_t kLookEvery = 100;
// The pool grows by so much at a time, where blocks are given back in another order than before.
constexpr uint64_t kPoolStep = 32 * kMiB;
// What the process may grow by in all cycles: 36 KiB each.
constexpr uint64_t kHostRoom = 64 * kMiB;
constexpr uint32_t kSeed = 11;

struct ViewKind {
  ViewSpec spec;
  Encoding encoding;
};
const std::array kViews{
    ViewKind{{.segments = 10}, Encoding::kQuantised},
    ViewKind{{.segments = 4, .normals = NormalMode::kSmooth}, Encoding::kDracoPoints},
    ViewKind{{.segments = 5, .normals = NormalMode::kNone}, Encoding::kDracoMesh},
    ViewKind{{.segments = 7, .normals = NormalMode::kSmooth, .format = VertexFormat::kFloat32},
             Encoding::kRaw}};

class CudaSoak : public CudaTest {
 protected:
  CudaSoak() : CudaTest(kSeed) {}

  void SetUp() override {
    CudaTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    ASSERT_OK_AND_ASSIGN(auto backend, MakeCudaBackend({.memory_bytes = 256 * kMiB, .threads = 1}));
    backend_ = std::move(backend);
  }

  // Create, evaluate, edit, encode, delete.
  absl::Status Cycle(Pipeline pipeline, const ViewKind& kind) {
    auto target = backend_->Prepare(plan_, pipeline);
    if (!target.ok()) return target.status();
    auto view = (*target)->CreateView(kind.spec);
    if (!view.ok()) return view.status();
    const std::vector<uint32_t> all = AllChunks(*plan_), one{0};
    std::vector<Vec3d> edited = points_;
    edited.front().x += 0.01;
    const QuantisationBox box = BoxFor(*plan_, points_);
    if (auto s = (*view)->Evaluate(points_, box, all); !s.ok()) return s;
    if (auto s = (*view)->Evaluate(edited, box, one); !s.ok()) return s;
    if (auto s = (*view)->Encode(all, kind.encoding); !s.ok()) return s.status();
    return (*target)->ControlNets(points_, 0, 2).status();
  }

  // Resident bytes of this process, pinned ones among them.
  static uint64_t HostBytes() {
    std::ifstream statm("/proc/self/statm");
    uint64_t pages = 0, resident = 0;
    statm >> pages >> resident;
    return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  }
  // The budget's, counted to the byte by us.
  uint64_t FreeOfBudget() const { return backend_->devices().front().free_bytes; }
  // The device's, by the driver.
  static uint64_t FreeOnDevice() {
    size_t free = 0, total = 0;
    EXPECT_EQ(cudaMemGetInfo(&free, &total), cudaSuccess);
    return free;
  }

  std::unique_ptr<Backend> backend_;
};

TEST_F(CudaSoak, TwoThousandScenesLeaveMemoryFlat) {
  uint64_t budget_before = 0, device_before = 0, host_before = 0;
  for (size_t cycle = 0; cycle < kCycles; ++cycle) {
    if (cycle == kWarmUp) {
      budget_before = FreeOfBudget();
      device_before = FreeOnDevice();
      host_before = HostBytes();
    }
    const Pipeline pipeline = kPipelines[cycle % kPipelines.size()];
    ASSERT_OK(Cycle(pipeline, kViews[cycle / kPipelines.size() % kViews.size()]))
        << fmt::format("cycle {}, {}, seed {}", cycle, PipelineName(pipeline), kSeed);
    if (cycle < kWarmUp || cycle % kLookEvery != 0) continue;
    ASSERT_EQ(FreeOfBudget(), budget_before) << "cycle " << cycle;
    ASSERT_GE(FreeOnDevice() + kPoolStep, device_before) << "cycle " << cycle;
  }
  EXPECT_EQ(FreeOfBudget(), budget_before);
  EXPECT_GE(FreeOnDevice() + kPoolStep, device_before);
  EXPECT_LE(HostBytes(), host_before + kHostRoom);
}

}  // namespace
}  // namespace latticed::testing
