// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scenes come and go: two thousand times a plan is prepared, viewed, evaluated, edited, encoded and
// dropped. In the end device and host must use the memory that they used after the warm-up, within
// the limits below. Takes some seconds.
#include <cuda_runtime_api.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <span>
#include <vector>

#include "cuda/cuda_backend.h"
#include "fmt/format.h"
#include "tests/cuda/cuda_test.h"
#include "tests/support/pipeline_name.h"

namespace latticed::testing {
namespace {

// By then every pipeline has run with every view, so lanes, workspaces and the pool have their
// final size.
constexpr size_t kWarmUp = 200;
constexpr size_t kLookEvery = 100;
// A pool may grow by this step, if blocks are freed in another order than before.
constexpr uint64_t kPoolStep = 32 * kMiB;
// The limit for the growth of the process over all cycles: 36 KiB per cycle.
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

  // Creates, evaluates, edits, encodes and deletes.
  absl::Status Cycle(Backend& backend, Pipeline pipeline, const ViewKind& kind) {
    auto target = backend.Prepare(plan_, pipeline);
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

  // Resident bytes of this process, including pinned memory.
  static uint64_t HostBytes() {
    std::ifstream statm("/proc/self/statm");
    uint64_t pages = 0, resident = 0;
    statm >> pages >> resident;
    return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  }
  // Free bytes of all devices: of their budgets, which we count to the byte, and by the driver.
  struct Free {
    uint64_t budgets = 0, devices = 0;
  };
  static Free FreeOn(const Backend& backend) {
    Free sum;
    for (const DeviceState& state : backend.devices()) {
      const DeviceGuard guard(state.number);
      size_t free = 0, total = 0;
      EXPECT_EQ(cudaMemGetInfo(&free, &total), cudaSuccess);
      sum.budgets += state.free_bytes;
      sum.devices += free;
    }
    return sum;
  }

  void ExpectMemoryStaysFlat(const CudaOptions& options, std::span<const Pipeline> pipelines,
                             size_t cycles) {
    ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend(options));
    // The pool of each part can grow. If all parts are on one device, that growth is counted once
    // per part.
    const uint64_t pool_steps = options.devices.size() * options.devices.size() * kPoolStep;
    Free before;
    uint64_t host_before = 0;
    for (size_t cycle = 0; cycle <= cycles; ++cycle) {
      if (cycle == kWarmUp) {
        before = FreeOn(*backend);
        host_before = HostBytes();
      }
      const Pipeline pipeline = pipelines[cycle % pipelines.size()];
      ASSERT_OK(Cycle(*backend, pipeline, kViews[cycle / pipelines.size() % kViews.size()]))
          << fmt::format("cycle {}, {}, seed {}", cycle, PipelineName(pipeline), kSeed);
      if (cycle < kWarmUp || cycle % kLookEvery != 0) continue;
      const Free now = FreeOn(*backend);
      ASSERT_EQ(now.budgets, before.budgets) << "cycle " << cycle;
      ASSERT_GE(now.devices + pool_steps, before.devices) << "cycle " << cycle;
    }
    EXPECT_LE(HostBytes(), host_before + kHostRoom);
  }
};

TEST_F(CudaSoak, TwoThousandScenesLeaveMemoryFlat) {
  ExpectMemoryStaysFlat({.memory_bytes = 256 * kMiB, .threads = 1}, kPipelines, 2'000);
}

// On two devices, or twice on one if there is no second.
TEST_F(CudaSoak, SpannedScenesLeaveMemoryFlat) {
  ExpectMemoryStaysFlat({.devices = {0, CheckDevice(1).ok() ? 1 : 0},
                         .span_patches = 1,
                         .memory_bytes = 256 * kMiB,
                         .threads = 1},
                        std::array{Pipeline::kFused}, 400);
}

}  // namespace
}  // namespace latticed::testing
