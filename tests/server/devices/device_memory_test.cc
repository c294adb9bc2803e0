// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The budget --memory counts only the host's bytes, and --gpu-memory only the device's. The bytes of
// both are reported by purpose.
#include <algorithm>
#include <string>
#include <vector>

#include "server/engine/render/chunk_table.h"
#include "tests/server/devices/device_fixture.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

constexpr uint64_t kMiB = uint64_t{1} << 20;
// The default view at two segments: 6 points of 8 bytes (positions of 12 bits, normals of 8 bits).
constexpr int kSegments = 2;
constexpr uint64_t kBytesPerPatch = 6 * 8;
// The bytes of a stream's largest message: all chunks of a view with their heads, and 4 KiB for the rest.
constexpr uint64_t StreamBytes(uint64_t vertices, uint64_t chunks) {
  return std::min(vertices + 32 * chunks + 4'096, 1 * kMiB);
}

TEST(MemoryUseTest, TheNameSaysThePlace) {
  const MemoryUse use{{"plan", 1}, {"staging", 2}, {"device_plan", 4}, {"device_staging", 8}};

  EXPECT_EQ(HostBytes(use), 3u);
  EXPECT_EQ(DeviceBytes(use), 12u);
}

class DeviceMemoryTest : public DeviceFixture {
 protected:
  void SetUp() override { Start(kMiB); }

  void Start(uint64_t device_bytes, Options options = {}) {
    StartOnDevice(device_bytes, PlaneObj(20), options);
  }

  v1::Mesh GetMesh() {
    v1::GetMeshRequest request;
    request.set_mesh(mesh_);
    v1::Mesh mesh;
    EXPECT_OK(Call(&Meshes::GetMesh, request, &mesh));
    return mesh;
  }
};

TEST_F(DeviceMemoryTest, TheHostsBudgetDoesNotBoundTheDevice) {
  ASSERT_OK(Create(SceneRequest()));
  const uint64_t needed = Info().reserved_host_bytes();
  const uint64_t patches = Get().patches(), chunks = Get().chunks();
  const uint64_t vertices = patches * kBytesPerPatch;
  // Enough for the chunks of snapshots (as many bytes as the vertices, their headers and their table) and for
  // the largest message, but not for the vertices as well.
  Options options;
  options.memory_bytes = needed + vertices + 256 * chunks + ChunkTable::MostBytes(chunks) +
                         StreamBytes(vertices, chunks);
  ASSERT_GT(vertices, ChunkTable::MostBytes(chunks));
  Start(kMiB, options);
  ASSERT_OK(Create(SceneRequest()));

  EXPECT_OK(Update(kSegments));
}

TEST_F(DeviceMemoryTest, EachBudgetRefusesWithItsOwnBytes) {
  ASSERT_OK(Create(SceneRequest()));
  const uint64_t plan = Get().bytes().at("device_plan");
  // Read before any stream: a stream frees its reservation shortly after its client has the refusal.
  const uint64_t needed = Info().reserved_host_bytes();

  const absl::Status on_device = Update(32);

  ExpectRefused(on_device, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_EQ(error::DetailsOf(on_device).asked_bytes, Get().patches() * 561 * 8);
  EXPECT_EQ(error::DetailsOf(on_device).free_bytes, kMiB - plan);
  const uint64_t vertices = Get().patches() * 561 * 8;
  Options options;
  options.memory_bytes = needed + StreamBytes(vertices, Get().chunks()) + 100;
  Start(uint64_t{1} << 40, options);
  ASSERT_OK(Create(SceneRequest()));
  const absl::Status on_host = Update(32);
  ExpectRefused(on_host, absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_EQ(error::DetailsOf(on_host).free_bytes, 100u);
  EXPECT_THAT(on_host.message(), HasSubstr("the view"));
}

TEST_F(DeviceMemoryTest, SceneMeshAndServerTellEachByPurpose) {
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK(Update(kSegments));

  const v1::Scene scene = Get();
  const uint64_t plan = scene.patches() * ScriptedBackend::kPlanBytes;
  const uint64_t vertices = scene.patches() * kBytesPerPatch;
  EXPECT_EQ(scene.bytes().at("device_plan"), plan);
  EXPECT_EQ(scene.bytes().at("device_vertices"), vertices);
  for (const char* purpose : {"mesh", "plan", "patch_tree", "chunks"}) {
    EXPECT_GT(scene.bytes().at(purpose), 0u) << purpose;
  }
  EXPECT_EQ(GetMesh().device_bytes(), plan);

  const v1::ServerInfo info = Info();
  ASSERT_EQ(info.backends(0).devices_size(), 1);
  const v1::DeviceInfo& device = info.backends(0).devices(0);
  EXPECT_EQ(device.budget_bytes(), kMiB);
  EXPECT_EQ(device.free_bytes(), kMiB - plan - vertices);
  EXPECT_EQ(device.bytes().at("plan"), plan);
  EXPECT_EQ(device.bytes().at("vertices"), vertices);
  EXPECT_EQ(info.limits().max_device_bytes(), kMiB);
  EXPECT_EQ(info.host_bytes().at("plan"), scene.bytes().at("plan"));
  EXPECT_EQ(info.host_bytes().at("chunks"), scene.bytes().at("chunks"));
  EXPECT_EQ(info.host_bytes().at("mesh"), GetMesh().host_bytes());
  EXPECT_FALSE(info.host_bytes().contains("device_plan"));
}

}  // namespace
}  // namespace latticed::testing
