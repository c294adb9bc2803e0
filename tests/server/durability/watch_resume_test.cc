// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A watcher whose server is started again on the same folder is sent what it misses and no more, if the new server makes
// the same bytes from the same lattice; else everything.
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu/cpu_backend.h"
#include "server/base/version.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kCorner = 0, kMiddle = 62, kOpposite = 124;  // of 5 x 5 x 5

class VersionedBackend : public Backend {
 public:
  explicit VersionedBackend(std::string version) : version_(std::move(version)) {}
  std::string_view name() const override { return inner_->name(); }
  std::string description() const override { return inner_->description(); }
  std::vector<DeviceState> devices() const override { return inner_->devices(); }
  std::string Arithmetic(Pipeline /*pipeline*/) const override { return version_; }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override {
    return inner_->Prepare(std::move(plan), pipeline);
  }

 private:
  const std::string version_;
  const std::unique_ptr<Backend> inner_ = MakeCpuBackend({.threads = 1});
};

class WatchResumeTest : public StreamTest {
 protected:
  void SetUp() override {
    if (Commit() == "unknown")
      GTEST_SKIP() << "built outside of git: no build is known to be the same";
    Restart();
    CreateScene(/*cells=*/32);
  }
  // With an evaluator whose library has this version.
  void Restart(const std::string& version = "1") {
    server_.reset();
    Options options = TestOptions();
    options.heartbeat_interval = kHeartbeat;
    options.data_dir = folder_.Path("data");
    StartServerOn(std::make_unique<VersionedBackend>(version), options);
  }
  // What a watcher has at the newest revision, and its token.
  EventLog Seen(const v1::WatchRequest& request) {
    WatchClient watcher(*scenes_, request);
    watcher.ReadUntilRevision(revision_);
    return watcher.log;
  }
  void Edit(uint32_t point) { ASSERT_OK(Apply(Move(++revision_, point, 0.05))); }
  // Watches again with the token of `before`, and compares the chunks with those of a watcher that has no token. Returns
  // how many of all chunks were sent.
  struct Resumed {
    bool resumed;
    size_t sent, all;
  };
  Resumed Resume(v1::WatchRequest request, const EventLog& before) {
    request.set_resume_token(before.ends.back().resume_token());
    const EventLog again = Seen(request);
    request.clear_resume_token();
    const EventLog fresh = Seen(request);
    std::map<uint32_t, std::string> chunks;
    if (again.hello.resumed()) chunks = before.chunks;
    for (const auto& [index, data] : again.chunks) chunks[index] = data;
    EXPECT_EQ(chunks, fresh.chunks);
    EXPECT_EQ(again.begins.size(), 1u);
    return {again.hello.resumed(), again.begins.back().chunk_count(), fresh.chunks.size()};
  }

  TemporaryFolder folder_;
  uint64_t revision_ = 0;
};

TEST_F(WatchResumeTest, NothingIsSentAgainAfterARestart) {
  Edit(kCorner);
  const EventLog before = Seen(Watch());

  Restart();
  const Resumed resumed = Resume(Watch(), before);

  EXPECT_TRUE(resumed.resumed);
  EXPECT_EQ(resumed.sent, 0u);
  EXPECT_GT(resumed.all, 10u);
}

TEST_F(WatchResumeTest, AllIsSentByAnotherVersionOfALibrary) {
  Edit(kCorner);
  const EventLog before = Seen(Watch());

  Restart("2");
  const Resumed resumed = Resume(Watch(), before);

  EXPECT_FALSE(resumed.resumed);
  EXPECT_EQ(resumed.sent, resumed.all);
}

TEST_F(WatchResumeTest, EditsBeforeAndAfterTheRestartAreSent) {
  Edit(kCorner);
  const EventLog before = Seen(Watch());
  Edit(kOpposite);  // nobody watches

  Restart();
  const Resumed one = Resume(Watch(), before);
  EXPECT_TRUE(one.resumed);
  EXPECT_GT(one.sent, 0u);
  EXPECT_LT(one.sent, one.all);

  const EventLog since = Seen(Watch());
  Edit(kMiddle);
  Restart();
  Edit(kCorner);
  const Resumed two = Resume(Watch(), since);
  EXPECT_TRUE(two.resumed);
  EXPECT_GT(two.sent, 0u);
}

TEST_F(WatchResumeTest, AnUndoneMoveIsSent) {
  Edit(kCorner);
  const EventLog before = Seen(Watch());
  v1::EditBatch undo = Move(++revision_, kCorner, 0);
  undo.clear_edits();
  undo.add_edits()->mutable_undo();
  ASSERT_OK(Apply(undo));

  Restart();
  const Resumed resumed = Resume(Watch(), before);

  EXPECT_TRUE(resumed.resumed);
  EXPECT_GT(resumed.sent, 0u);
  EXPECT_LT(resumed.sent, resumed.all);
}

// Chunks that an edit does not reach may change there.
TEST_F(WatchResumeTest, WithAToleranceAllIsSent) {
  v1::WatchRequest request = Watch();
  request.mutable_view()->set_tolerance(0.001);
  const EventLog before = Seen(request);

  Restart();
  const Resumed resumed = Resume(request, before);

  EXPECT_FALSE(resumed.resumed);
  EXPECT_EQ(resumed.sent, resumed.all);
}

// As after a loss of power without durable commits, or a failover that lost some.
TEST_F(WatchResumeTest, AStoreThatWentBackSendsAll) {
  Edit(kCorner);
  server_.reset();
  std::filesystem::copy(folder_.Path("data"), folder_.Path("older"),
                        std::filesystem::copy_options::recursive);
  Restart();
  Edit(kMiddle);
  const EventLog before = Seen(Watch());
  server_.reset();
  std::filesystem::remove_all(folder_.Path("data"));
  std::filesystem::rename(folder_.Path("older"), folder_.Path("data"));
  Restart();
  --revision_;
  Edit(kOpposite);  // the same revision
  Edit(kCorner);

  EXPECT_FALSE(Resume(Watch(), before).resumed);
}

TEST_F(WatchResumeTest, ATokenOfASceneThatWasMadeAgainResumesNothing) {
  const EventLog before = Seen(Watch());
  v1::DeleteSceneRequest request;
  request.set_scene(kScene);
  ASSERT_OK(Call(&Scenes::DeleteScene, request, nullptr));
  Restart();
  CreateScene(/*cells=*/32);

  EXPECT_FALSE(Resume(Watch(), before).resumed);
}

}  // namespace
}  // namespace latticed::testing
