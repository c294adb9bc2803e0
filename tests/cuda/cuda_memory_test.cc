// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Budgets, failed allocations, leaks and repeatable bits, through the backend's interface where possible.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "cuda/cuda_backend.h"
#include "cuda/cuda_target.h"
#include "cuda/device/cuda_context.h"
#include "cuda/device/cuda_device.h"
#include "cuda/device/device_buffer.h"
#include "fmt/format.h"
#include "tests/cuda/cuda_test.h"
#include "tests/support/pipeline_name.h"

namespace latticed::testing {
namespace {

// Every layout of the device's vertices: words of 16 and 32 bits, wide normals, floats, and without
// normals; from 1 to 32 segments.
const std::array kSpecs{
    ViewSpec{.segments = 4, .normals = NormalMode::kSmooth},
    ViewSpec{.segments = 1, .position_bits = 16},
    ViewSpec{.segments = 10, .normals = NormalMode::kNone},
    ViewSpec{.segments = 32, .normal_bits = 12},
    ViewSpec{.segments = 7, .normals = NormalMode::kSmooth, .format = VertexFormat::kFloat32},
    ViewSpec{.segments = 10, .normals = NormalMode::kNone, .format = VertexFormat::kFloat32},
    ViewSpec{.segments = 3, .normals = NormalMode::kSmooth, .normal_bits = 12},
    ViewSpec{.format = VertexFormat::kEdgeBounds}};
// The specs whose scenes differ most in their buffers: integers, which are also encoded as streams;
// floats with smooth normals; floats without normals; and bounds.
const std::array kRefusedSpecs{kSpecs[0], kSpecs[4], kSpecs[5], kSpecs[7]};

class CudaMemory : public CudaTest {
 protected:
  CudaMemory() : CudaTest(3) {}

  using Bytes = std::vector<std::vector<uint8_t>>;
  struct Scene {
    std::shared_ptr<DeformTarget> target;
    std::unique_ptr<DeformView> view;
  };

  // The context behind a backend of one device, because the backend does not report pinned bytes.
  // It refuses one allocation after left_ others, or none if left_ is negative. With one thread,
  // the test's few chunks are too many for the host's Draco writer.
  absl::StatusOr<std::shared_ptr<CudaContext>> MakeRefusingDevice() {
    return CudaContext::Create(0, {.memory_bytes = 256 * kMiB,
                                   .threads = 1,
                                   .refuse_allocation = [this](std::string_view, uint64_t) {
                                     return left_ >= 0 && left_-- == 0;
                                   }});
  }
  // All memory in use, on the device and pinned.
  struct Held {
    MemoryUse use;
    uint64_t free_bytes = 0, pinned_bytes = 0;
  };
  static Held HeldOn(const CudaContext& device) {
    return {device.memory()->use(), device.memory()->free_bytes(), device.pinned().lent_bytes()};
  }
  static void ExpectSameHeld(const CudaContext& device, const Held& before) {
    const Held now = HeldOn(device);
    EXPECT_EQ(now.use, before.use);
    EXPECT_EQ(now.free_bytes, before.free_bytes);
    EXPECT_EQ(now.pinned_bytes, before.pinned_bytes);
  }
  // Evaluates, makes control nets, and encodes.
  absl::StatusOr<Bytes> Use(const Scene& scene) {
    const std::vector<uint32_t> chunks = AllChunks(*plan_);
    if (auto s = scene.view->Evaluate(points_, BoxFor(*plan_, points_), chunks); !s.ok()) return s;
    const auto nets = scene.target->ControlNets(points_, 0, 2);
    if (!nets.ok()) return nets.status();
    Bytes bytes;
    for (const Encoding encoding : encodings_) {
      if (FormatOf(encoding) != spec_.format) continue;
      const auto encoded = scene.view->Encode(chunks, encoding);
      if (!encoded.ok()) return encoded.status();
      for (const SharedBytes& e : *encoded) bytes.emplace_back(e.span().begin(), e.span().end());
    }
    return bytes;
  }
  absl::StatusOr<Scene> Make(Backend& backend, Pipeline pipeline) {
    return MakeScene(backend.Prepare(plan_, pipeline));
  }
  absl::StatusOr<Scene> Make(const std::shared_ptr<CudaContext>& device, Pipeline pipeline) {
    return MakeScene(MakeCudaTarget(plan_, pipeline, device));
  }
  // One whole use: prepares, makes a view and uses it. Releases everything.
  template <typename Device>
  absl::StatusOr<Bytes> Use(Device& device, Pipeline pipeline) {
    const auto scene = Make(device, pipeline);
    if (!scene.ok()) return scene.status();
    return Use(*scene);
  }

  // Each spec with every pipeline that has such views.
  static std::vector<std::pair<ViewSpec, Pipeline>> Scenes(std::span<const ViewSpec> specs) {
    std::vector<std::pair<ViewSpec, Pipeline>> scenes;
    for (const ViewSpec& spec : specs) {
      for (const Pipeline pipeline : kPipelines) {
        if (spec.format == VertexFormat::kEdgeBounds && pipeline != Pipeline::kFused) continue;
        scenes.emplace_back(spec, pipeline);
      }
    }
    return scenes;
  }
  static std::string Told(const ViewSpec& spec, Pipeline pipeline, int allocation) {
    return fmt::format("{}, {} segments, allocation {}", PipelineName(pipeline), spec.segments,
                       allocation);
  }
  // Whether the allocation to refuse was reached.
  bool Refused() { return std::exchange(left_, -1) < 0; }

  ViewSpec spec_ = kSpecs.front();
  std::vector<Encoding> encodings_{Encoding::kQuantised, Encoding::kDracoPoints,
                                   Encoding::kDracoMesh, Encoding::kRaw, Encoding::kPatches};
  int left_ = -1;

 private:
  template <typename Target>
  absl::StatusOr<Scene> MakeScene(absl::StatusOr<std::shared_ptr<Target>> target) {
    if (!target.ok()) return target.status();
    auto view = (*target)->CreateView(spec_);
    if (!view.ok()) return view.status();
    return Scene{*std::move(target), *std::move(view)};
  }
};

TEST_F(CudaMemory, MoreThanTheDeviceHasLeavesItUsable) {
  ASSERT_OK_AND_ASSIGN(const auto memory, DeviceMemory::Create(0, uint64_t{1} << 50, nullptr));
  ASSERT_OK_AND_ASSIGN(const auto stream, CudaStream::Create());

  const auto huge =
      DeviceBuffer<uint8_t>::Create(memory, "vertices", size_t{1} << 45, stream.get());

  ASSERT_THAT(huge, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_OK(LastCudaStatus("after it"));
  EXPECT_OK(DeviceBuffer<uint8_t>::Create(memory, "vertices", kMiB, stream.get()));
}

TEST_F(CudaMemory, EveryFailedAllocationIsRefusedCleanly) {
  ASSERT_OK_AND_ASSIGN(const auto device, MakeRefusingDevice());
  for (const auto& [spec, pipeline] : Scenes(kRefusedSpecs)) {
    spec_ = spec;
    ASSERT_OK_AND_ASSIGN(const auto expected, Use(device, pipeline));
    ASSERT_GT(expected.size(), 0u);
    const Held unused = HeldOn(*device);
    EXPECT_EQ(unused.pinned_bytes, 0u);
    int refused = 0;
    for (int at = 0;; ++at) {
      SCOPED_TRACE(Told(spec, pipeline, at));
      left_ = at;
      const auto failed = Use(device, pipeline);
      if (!Refused()) break;
      ExpectSameHeld(*device, unused);
      ASSERT_THAT(failed, StatusIs(absl::StatusCode::kResourceExhausted));
      ++refused;
      ASSERT_OK_AND_ASSIGN(const auto again, Use(device, pipeline));
      ASSERT_TRUE(again == expected);
      ExpectSameHeld(*device, unused);
    }
    // Bounds are encoded from where they are, without memory of the device.
    const bool has_vertices = spec.format != VertexFormat::kEdgeBounds;
    EXPECT_GT(refused, has_vertices ? 12 : 8) << Told(spec, pipeline, -1);
  }
}

TEST_F(CudaMemory, RefusalsLeaveALivingSceneAsItWas) {
  ASSERT_OK_AND_ASSIGN(const auto device, MakeRefusingDevice());
  for (const auto& [spec, pipeline] : Scenes(kRefusedSpecs)) {
    spec_ = spec;
    ASSERT_OK_AND_ASSIGN(const auto living, Make(device, pipeline));
    ASSERT_OK_AND_ASSIGN(const auto expected, Use(living));
    ASSERT_OK(Use(device, pipeline));  // a second scene at the same time has its own lane
    const Held one_scene = HeldOn(*device);
    EXPECT_GT(one_scene.pinned_bytes, 0u);
    int refused = 0;
    for (int at = 0;; ++at) {
      SCOPED_TRACE(Told(spec, pipeline, at));
      left_ = at;
      const auto failed = Use(device, pipeline);
      if (!Refused()) break;
      ExpectSameHeld(*device, one_scene);
      ASSERT_THAT(failed, StatusIs(absl::StatusCode::kResourceExhausted));
      ++refused;
    }
    EXPECT_GT(refused, spec.format == VertexFormat::kEdgeBounds ? 7 : 10)
        << Told(spec, pipeline, -1);
    ASSERT_OK_AND_ASSIGN(const auto again, Use(living));
    EXPECT_TRUE(again == expected);
    ExpectSameHeld(*device, one_scene);
  }
}

// Each workspace takes 4 MiB, and clients choose a scene's pipeline.
TEST_F(CudaMemory, ManyScenesOfMatrixProductsLeaveFewWorkspaces) {
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend({.memory_bytes = 256 * kMiB}));
  const auto workspaces = [&] { return backend->devices().front().use["gemm_workspace"]; };
  for (int time = 0; time < 2; ++time) {
    std::vector<Scene> scenes;
    for (int i = 0; i < 12; ++i) {
      ASSERT_OK_AND_ASSIGN(auto scene, Make(*backend, Pipeline::kGemm));
      ASSERT_OK(Use(scene));
      scenes.push_back(std::move(scene));
    }
    EXPECT_GE(workspaces(), 12 * 4 * kMiB);
    scenes.clear();
    EXPECT_LE(workspaces(), 4 * 4 * kMiB);
    EXPECT_GT(workspaces(), 0u) << "the next scene finds one";
  }
}

TEST_F(CudaMemory, RepeatedRunsAreBitIdentical) {
  ASSERT_OK_AND_ASSIGN(const auto backend, MakeCudaBackend({.threads = 1}));
  for (const auto& [spec, pipeline] : Scenes(kSpecs)) {
    spec_ = spec;
    ASSERT_OK_AND_ASSIGN(const auto expected, Use(*backend, pipeline));
    for (int run = 0; run < 5; ++run) {
      ASSERT_OK_AND_ASSIGN(const auto again, Use(*backend, pipeline));
      EXPECT_TRUE(again == expected) << PipelineName(pipeline) << ", " << spec.segments;
    }
  }
}

TEST_F(CudaMemory, PoisonedMemoryIsFullyOverwritten) {
  ASSERT_OK_AND_ASSIGN(const auto poisoned, MakeCudaBackend({.threads = 1, .poison_memory = true}));
  ASSERT_OK_AND_ASSIGN(const auto plain, MakeCudaBackend({.threads = 1}));
  for (const auto& [spec, pipeline] : Scenes(kSpecs)) {
    spec_ = spec;
    const auto expected = Use(*plain, pipeline), got = Use(*poisoned, pipeline);
    ASSERT_OK(expected);
    ASSERT_OK(got);
    EXPECT_TRUE(*got == *expected) << PipelineName(pipeline) << ", " << spec.segments;
  }
}

TEST_F(CudaMemory, SmallBudgetsGoThroughInTilesWithinTheSameTolerance) {
  PolygonMesh mesh = TorusMesh(60, 40);
  const LatticeStructure structure = MakeStructure(mesh.ComputeBounds(), {});
  plan_ = MakeTestPlan(std::move(mesh), structure);
  points_ = Jitter(structure, 0.05, 3);
  encodings_ = {Encoding::kQuantised};
  ASSERT_OK_AND_ASSIGN(const auto small, MakeCudaBackend({.memory_bytes = 16 * kMiB}));
  ASSERT_OK_AND_ASSIGN(const auto large, MakeCudaBackend({}));

  const auto tiled = Use(*small, Pipeline::kGemm), whole = Use(*large, Pipeline::kGemm);

  ASSERT_OK(tiled);
  ASSERT_OK(whole);
  ASSERT_EQ(tiled->size(), whole->size());
  for (size_t c = 0; c < tiled->size(); ++c) ASSERT_EQ((*tiled)[c].size(), (*whole)[c].size());
  size_t differing = 0, count = 0;
  for (size_t c = 0; c < tiled->size(); ++c) {
    // Positions of 12 bits in 16-bit words: they differ by one rounding at most.
    const size_t integers = 3 * ChunkPoints(*plan_, c, 4);
    for (size_t i = 0; i < integers; ++i, ++count) {
      const int a = (*tiled)[c][2 * i] | (*tiled)[c][2 * i + 1] << 8;
      const int b = (*whole)[c][2 * i] | (*whole)[c][2 * i + 1] << 8;
      ASSERT_LE(std::abs(a - b), 1);
      differing += a != b;
    }
  }
  EXPECT_LE(differing, count / 100);
}

}  // namespace
}  // namespace latticed::testing
