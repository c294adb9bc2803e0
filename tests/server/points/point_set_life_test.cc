// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How point sets are counted and limited, and how they end.
#include "core/base/limits.h"
#include "core/cpu/cpu_backend.h"
#include "fmt/format.h"
#include "server/store/memory_store.h"
#include "tests/server/points/point_set_client.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using Code = absl::StatusCode;

class PointSetLifeTest : public OneSceneTest {
 protected:
  void SetUp() override {
    OneSceneTest::SetUp();
    client_ = std::make_unique<PointSetClient>(server_->channel());
  }
  std::unique_ptr<PointSetClient> client_;
  const std::vector<Vec3d> world_ = std::vector<Vec3d>(1'000, Vec3d{1, 1, 0});
};

TEST_F(PointSetLifeTest, ItsMemoryIsTheScenesUntilItIsDeleted) {
  EXPECT_EQ(Get().bytes().count("point_sets"), 0u);
  ASSERT_OK_AND_ASSIGN(const v1::PointSet first, client_->CreateWorld(world_));
  ASSERT_OK_AND_ASSIGN(const v1::PointSet second, client_->CreateWorld(world_, world_));

  EXPECT_GE(first.bytes(), 28'000u);
  EXPECT_GE(second.bytes(), 52'000u);
  EXPECT_EQ(Get().bytes().at("point_sets"), first.bytes() + second.bytes());
  ASSERT_OK_AND_ASSIGN(const auto listed, client_->List());
  ASSERT_EQ(listed.point_sets_size(), 2);
  EXPECT_EQ(listed.point_sets(0).id(), first.id());
  EXPECT_EQ(listed.point_sets(1).id(), second.id());
  EXPECT_TRUE(listed.point_sets(1).has_normals());

  ASSERT_OK(client_->Delete(first.id()));
  ExpectRefused(client_->Deform(first).status(), Code::kNotFound, "NOT_FOUND");
  ExpectRefused(client_->Delete(first.id()), Code::kNotFound, "NOT_FOUND");
  EXPECT_EQ(Get().bytes().at("point_sets"), second.bytes());
}

TEST_F(PointSetLifeTest, ItEndsWithItsScene) {
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->CreateWorld(world_));
  ASSERT_OK(DeleteScene());
  ExpectRefused(client_->Deform(set).status(), Code::kNotFound, "NOT_FOUND");
  ExpectRefused(client_->List().status(), Code::kNotFound, "NOT_FOUND");
  ASSERT_OK(Create(SceneRequest()));
  ExpectRefused(client_->Deform(set).status(), Code::kNotFound, "NOT_FOUND");
}

TEST_F(PointSetLifeTest, AnotherScenesSetIsNotFound) {
  ASSERT_OK(Create(SceneRequest("scene-two")));
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set, client_->CreateWorld(world_));
  auto request = For<v1::DeformPointSetRequest>("scene-two");
  request.set_point_set(set.id());
  ExpectRefused(client_->Deform(request).status(), Code::kNotFound, "NOT_FOUND");
}

TEST_F(PointSetLifeTest, ASceneHasAtMostSixtyFour) {
  const std::vector<Vec3d> one(1);
  for (int i = 0; i < limits::kMaxPointSetsPerScene; ++i) ASSERT_OK(client_->CreateWorld(one));
  ExpectRefused(client_->CreateWorld(one).status(), Code::kResourceExhausted, "LIMIT_EXCEEDED");
  ASSERT_OK_AND_ASSIGN(const auto listed, client_->List());
  EXPECT_EQ(listed.point_sets_size(), limits::kMaxPointSetsPerScene);
  ASSERT_OK(client_->Delete(listed.point_sets(7).id()));
  EXPECT_OK(client_->CreateWorld(one));
}

TEST_F(PointSetLifeTest, WithoutMemoryNothingIsKept) {
  StartServer({.memory_bytes = uint64_t{8} << 20});
  ASSERT_OK(Create(SceneRequest()));
  PointSetClient client(server_->channel());
  const auto before = Get().bytes();

  auto header = For<v1::PointSetHeader>();
  header.mutable_world()->set_points(limits::kMaxPointSetPoints);
  const absl::Status refused = client.Create(header, "").status();
  ExpectRefused(refused, Code::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_EQ(error::DetailsOf(refused).asked_bytes, 24 * limits::kMaxPointSetPoints);
  // The bytes fit, the sorted points beside them do not.
  const std::vector<Vec3d> many(200'000, Vec3d{1, 1, 0});
  ExpectRefused(client.CreateWorld(many).status(), Code::kResourceExhausted, "OUT_OF_MEMORY");
  EXPECT_EQ(Get().bytes().count("point_sets"), 0u);
  // The set fits, an answer of thirty directions does not.
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set,
                       client.CreateWorld(std::vector<Vec3d>(20'000, Vec3d{1, 1, 0})));
  auto request = For<v1::ApplyJacobianRequest>();
  request.set_point_set(set.id());
  request.set_tangents(std::string(64 * 24 * 30, '\0'));
  ExpectRefused(client.ApplyJacobian(request).status(), Code::kResourceExhausted, "OUT_OF_MEMORY");
  request.set_tangents(std::string(64 * 24, '\0'));
  EXPECT_OK(client.ApplyJacobian(request));
  ASSERT_OK(client.Delete(set.id()));
  EXPECT_EQ(Get().bytes().count("point_sets"), before.count("point_sets"));
}

TEST_F(PointSetLifeTest, ARestartForgetsIt) {
  const auto store = std::make_shared<MemoryStore>();
  StartServerOn(MakeCpuBackend({.threads = 1}), TestOptions(), store);
  mesh_ = Upload(kGridObj);
  ASSERT_OK(Create(SceneRequest()));
  ASSERT_OK_AND_ASSIGN(const v1::PointSet set,
                       PointSetClient(server_->channel()).CreateWorld(world_));

  StartServerOn(MakeCpuBackend({.threads = 1}), TestOptions(), store);

  PointSetClient client(server_->channel());
  ExpectRefused(client.Deform(set).status(), Code::kNotFound, "NOT_FOUND");
  EXPECT_EQ(Get().bytes().count("point_sets"), 0u);
  EXPECT_OK(client.CreateWorld(world_));
}

}  // namespace
}  // namespace latticed::testing
