// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Backups of tenants: each gets what is its own, restores it as its own, and the audit log says so.
#include "core/base/sha256.h"
#include "tests/server/backup/backup_fixture.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

class TenantBackupTest : public BackupFixture {
 protected:
  void SetUp() override {
    Options options = TestOptions();
    options.caller_share = 1;
    options.audit_log = folder_.Path("audit");
    options.token_file =
        folder_.Write("tokens", fmt::format("{} edit ada acme\n{} edit bea other\n",
                                            Sha256Hex("of-acme"), Sha256Hex("of-other")));
    StartEmpty(nullptr, std::move(options));
    v1::Mesh mesh;
    ASSERT_OK(ServerTest::Upload(ObjHeader(kGridObj), kGridObj, &mesh, acme_));
    mesh_ = mesh.id();
    ASSERT_OK(Call(&Scenes::CreateScene, SceneRequest(), nullptr, acme_));
    ASSERT_OK(Call(&Scenes::ApplyEdits, Move("ed", 1, 5, 0.1), nullptr, acme_));
  }
  uint64_t Revision(const Metadata& metadata) {
    v1::Scene scene;
    EXPECT_OK(Call(&Scenes::GetScene, For<v1::GetSceneRequest>(), &scene, metadata));
    return scene.revision();
  }

  TemporaryFolder folder_;
  const Metadata acme_ = {{"authorization", "Bearer of-acme"}};
  const Metadata other_ = {{"authorization", "Bearer of-other"}};
};

TEST_F(TenantBackupTest, HoldsNothingOfOthers) {
  const auto all = Backup({}, other_);
  ASSERT_OK(all);
  EXPECT_TRUE(ItemsOf(*all).empty());
  EXPECT_THAT(Backup({kScene}, other_).status(), StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(Backup({std::string("acme/") + kScene}, other_).status(), ::testing::Not(IsOk()));
}

TEST_F(TenantBackupTest, IsRestoredForWhoRestoresIt) {
  const auto copy = Backup({}, acme_);
  ASSERT_OK(copy);
  ASSERT_EQ(ItemsOf(*copy).size(), 2u);

  ASSERT_OK(Restore(*copy, /*skip_existing=*/false, other_));
  ASSERT_OK(Call(&Scenes::ApplyEdits, Move("ed", 2, 5, 0.1), nullptr, other_));

  EXPECT_EQ(Revision(other_), 2u);
  EXPECT_EQ(Revision(acme_), 1u) << "it is another scene";
  const std::string log = folder_.Read("audit");
  EXPECT_THAT(log, HasSubstr(R"("event":"mesh_restored","tenant":"other","caller":"bea")"));
  EXPECT_THAT(log, HasSubstr(R"("event":"scene_restored","tenant":"other","caller":"bea")"));
}

}  // namespace
}  // namespace latticed::testing
