// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Two daemons, "a" and "b", over one PostgreSQL and one folder of meshes, and a scene with some edits that "a" owns.
#ifndef LATTICED_TESTS_SERVER_DURABILITY_SHARED_SCENE_TEST_H_
#define LATTICED_TESTS_SERVER_DURABILITY_SHARED_SCENE_TEST_H_

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "absl/time/clock.h"
#include "tests/server/durability/scene_owner.h"
#include "tests/server/durability/sharing_server.h"
#include "tests/server/store/postgres_server.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {

class SharedSceneTest : public StreamTest {
 protected:
  static constexpr uint64_t kEditsBefore = 3;

  // The stubs of the fixture reach "a".
  void SetUp() override {
    if (!PostgresServer::IsInstalled()) {
      ASSERT_EQ(std::getenv("LATTICED_REQUIRE_POSTGRES"), nullptr) << "PostgreSQL is not installed";
      GTEST_SKIP() << "PostgreSQL is not installed: nothing was tested with it";
    }
    url_ = PostgresServer::Shared().NewDatabase();
    const std::string url_file = folder_.Write("url", url_);
    a_ = std::make_unique<SharingServer>(url_file, folder_.Path("meshes"), "a", Lease());
    b_ = std::make_unique<SharingServer>(url_file, folder_.Path("meshes"), "b", Lease());
    Reach(a_->channel());
    ASSERT_NO_FATAL_FAILURE(CreateScene());
    for (uint64_t n = 1; n <= kEditsBefore; ++n) {
      states_.push_back(Lattice());
      ASSERT_OK(Apply(Edit(n)));
    }
    states_.push_back(Lattice());
  }
  // Of the servers.
  virtual absl::Duration Lease() const { return kLease; }
  v1::EditBatch Edit(uint64_t n, const std::string& editor = "alice") const {
    return Move(n, static_cast<uint32_t>(n % 125), 0.01, editor);
  }
  // Calls "b" until it has the scene.
  v1::Scene AwaitMove() {
    const absl::Time start = absl::Now();
    v1::Scene scene;
    auto [owner, status] = SceneOwner(b_->scenes(), &scene);
    while (!status.ok() && absl::Now() - start < absl::Minutes(1)) {
      EXPECT_EQ(Reason(status), "SCENE_MOVED") << status;
      EXPECT_EQ(owner, "a");
      absl::SleepFor(absl::Milliseconds(5));
      std::tie(owner, status) = SceneOwner(b_->scenes(), &scene);
    }
    EXPECT_OK(status);
    EXPECT_EQ(owner, "b");
    pause_ = absl::Now() - start;
    printf("the scene moved within %.0f ms\n", absl::ToDoubleMilliseconds(pause_));
    return scene;
  }

  TemporaryFolder folder_;
  std::string url_;  // of the database
  std::unique_ptr<SharingServer> a_, b_;
  std::vector<v1::LatticeState> states_;  // by the edits before
  absl::Duration pause_;                  // of AwaitMove
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_DURABILITY_SHARED_SCENE_TEST_H_
