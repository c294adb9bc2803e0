// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Point sets on a server whose backend has a device: which are there, what they take, and how they fail.
#include "server/engine/points/point_set.h"
#include "tests/server/points/point_set_client.h"
#include "tests/server/support/scripted_backend.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

constexpr uint64_t kDeviceBytes = uint64_t{1} << 20;
constexpr size_t kLarge = 20'000, kSmall = 1'000;
static_assert(kLarge * ScriptedBackend::kPointBytes < kDeviceBytes &&
              2 * kLarge * ScriptedBackend::kPointBytes > kDeviceBytes);

class DevicePointsTest : public SceneFixture {
 protected:
  void SetUp() override {
    auto backend = std::make_unique<ScriptedBackend>(kDeviceBytes);
    backend_ = backend.get();
    StartServerOn(std::move(backend));
    mesh_ = Upload(kGridObj);
    ASSERT_OK(Create(SceneRequest()));
    client_ = std::make_unique<PointSetClient>(server_->channel());
  }
  absl::StatusOr<v1::PointSet> CreatePoints(size_t count) {
    return client_->CreateWorld(std::vector<Vec3d>(count, Vec3d{1, 1, 0}));
  }
  uint64_t DevicePointBytes() const {
    const MemoryUse use = backend_->devices().front().use;
    return use.contains("points") ? use.at("points") : 0;
  }

  ScriptedBackend* backend_ = nullptr;
  std::unique_ptr<PointSetClient> client_;
};

TEST_F(DevicePointsTest, LargeSetsAreOnTheDeviceUntilTheyAreDeleted) {
  ASSERT_OK_AND_ASSIGN(const v1::PointSet small, CreatePoints(kSmall));
  EXPECT_EQ(DevicePointBytes(), 0u);
  ASSERT_OK(client_->Deform(small));
  EXPECT_EQ(backend_->script().calls(Step::kPointCall), 0);

  ASSERT_OK_AND_ASSIGN(const v1::PointSet large, CreatePoints(kLarge));
  EXPECT_EQ(DevicePointBytes(), kLarge * ScriptedBackend::kPointBytes);
  EXPECT_EQ(Get().bytes().at("device_points"), DevicePointBytes());
  ASSERT_OK_AND_ASSIGN(const auto deformed, client_->Deform(large));
  EXPECT_EQ(deformed.vectors.size(), kLarge);
  EXPECT_EQ(backend_->script().calls(Step::kPointCall), 1);

  ASSERT_OK(client_->Delete(large.id()));
  EXPECT_EQ(DevicePointBytes(), 0u);
  EXPECT_EQ(Get().bytes().count("device_points"), 0u);
}

TEST_F(DevicePointsTest, PointsWithWeightsStayOnTheHost) {
  mesh_ = Upload(WavyGridObj(8));
  v1::CreateSceneRequest scene = SceneRequest("weighted");
  const std::vector<float> weights(9 * 9, 0.5f);
  scene.mutable_weights()->set_values(
      std::string(reinterpret_cast<const char*>(weights.data()), weights.size() * sizeof(float)));
  ASSERT_OK(Create(scene));
  v1::PointSetHeader header;
  header.set_scene("weighted");
  header.mutable_view()->set_segments(32);
  header.mutable_view()->set_normals(v1::NORMAL_MODE_NONE);

  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->Create(header, ""));

  EXPECT_GE(set.points(), PointSet::kLeastDevicePoints);
  EXPECT_EQ(DevicePointBytes(), 0u);
  v1::DeformPointSetRequest request;
  request.set_scene("weighted");
  request.set_point_set(set.id());
  EXPECT_OK(client_->Deform(request));
  EXPECT_EQ(backend_->script().calls(Step::kPointCall), 0);
}

TEST_F(DevicePointsTest, ASetThatDoesNotFitIsRefusedAndNothingIsKept) {
  ASSERT_OK_AND_ASSIGN(const v1::PointSet first, CreatePoints(kLarge));

  const absl::Status refused = CreatePoints(kLarge).status();

  ExpectRefused(refused, Code::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_EQ(error::DetailsOf(refused).asked_bytes, kLarge * ScriptedBackend::kPointBytes);
  EXPECT_EQ(DevicePointBytes(), kLarge * ScriptedBackend::kPointBytes);
  EXPECT_EQ(Get().bytes().at("point_sets"), first.bytes());
  EXPECT_OK(CreatePoints(kSmall)) << "the host has memory";
  ASSERT_OK(client_->Delete(first.id()));
  EXPECT_OK(CreatePoints(kLarge));
}

TEST_F(DevicePointsTest, ACallWithoutDeviceMemoryIsRefusedAndTheNextOneIsNot) {
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, CreatePoints(kLarge));
  backend_->script().FailNext(Step::kPointCall,
                              error::OutOfDeviceMemory("the points", 0, 480'000, 7));

  ExpectRefused(client_->Deform(set).status(), Code::kResourceExhausted, "OUT_OF_MEMORY");

  EXPECT_OK(client_->Deform(set));
}

TEST_F(DevicePointsTest, AfterAChangeOfStructureTheyAreSortedOnTheDeviceAgain) {
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, CreatePoints(PointSet::kLeastDevicePoints));
  ASSERT_OK_AND_ASSIGN(const auto before, client_->Deform(set));
  ASSERT_OK(Apply(Knot("alice", 1)));

  ASSERT_OK_AND_ASSIGN(const auto after, client_->Deform(set));

  EXPECT_EQ(after.header.structure_id(), before.header.structure_id() + 1);
  EXPECT_EQ(backend_->script().calls(Step::kPreparePoints), 2);
  EXPECT_EQ(DevicePointBytes(), PointSet::kLeastDevicePoints * ScriptedBackend::kPointBytes);
}

TEST_F(DevicePointsTest, LatticesThatAreTurnedHaveThePointsOnceEach) {
  constexpr size_t kPoints = PointSet::kLeastDevicePoints;
  v1::EditBatch batch = Move("alice", 1, 0, 0);
  batch.set_lattice(1);
  batch.set_structure_id(Get().structure_id());
  batch.clear_edits();
  v1::Lattice& turned = *batch.add_edits()->mutable_replace_lattice()->mutable_lattice();
  SetFrame(*turned.mutable_frame(), {0, -2, -1}, {3, 3, 2});
  turned.mutable_frame()->mutable_u()->set_y(3);
  turned.mutable_frame()->mutable_v()->set_x(-3);
  SetAxes(*turned.mutable_degree(), 2, 2, 2);
  ASSERT_OK(Apply(batch));

  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, CreatePoints(kPoints));

  EXPECT_EQ(DevicePointBytes(), 2 * kPoints * ScriptedBackend::kPointBytes);
  EXPECT_EQ(Get().bytes().at("device_points"), DevicePointBytes());
  ASSERT_OK(client_->Deform(set));
  EXPECT_EQ(backend_->script().calls(Step::kPointCall), 2);
  ASSERT_OK(client_->Delete(set.id()));
  EXPECT_EQ(DevicePointBytes(), 0u);
}

TEST_F(DevicePointsTest, ALostDeviceIsToldAndMakesTheServerUnhealthy) {
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, CreatePoints(kLarge));
  backend_->script().LoseDevice();

  ExpectRefused(client_->Deform(set).status(), Code::kUnavailable, "DEVICE_LOST");

  EXPECT_NE(Info().backends(0).lost(), "");
  ExpectRefused(client_->Deform(set).status(), Code::kUnavailable, "DEVICE_LOST");
  EXPECT_EQ(backend_->script().calls_after_loss(), 1);
  EXPECT_OK(client_->Delete(set.id()));
}

}  // namespace
}  // namespace latticed::testing
