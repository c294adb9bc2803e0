// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// PostgreSQL crashes under edits, or accepts no writes. Edits are refused until it is back, and none is lost or doubled.
#include <atomic>
#include <functional>
#include <random>
#include <string>
#include <thread>

#include "fmt/format.h"
#include "tests/server/durability/shared_scene_test.h"

namespace latticed::testing {
namespace {

constexpr int kCrashes = 3;

class OutageTest : public SharedSceneTest {
 protected:
  // Sends the next edit, and the same again after a refusal, until it is told to stop.
  void EditUntil(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      v1::EditResult result;
      const absl::Status status = Apply(Edit(acknowledged_ + 1), &result);
      if (status.ok()) {
        EXPECT_EQ(result.revision(), acknowledged_ + 1);
        ++acknowledged_;
      } else {
        EXPECT_THAT(Reason(status), ::testing::AnyOf("STORE", "SCENE_MOVED")) << status;
        ++refused_;
        absl::SleepFor(absl::Milliseconds(10));
      }
    }
  }
  static void Await(const std::function<bool()>& done) {
    const absl::Time end = absl::Now() + absl::Minutes(1);
    while (!done() && absl::Now() < end) absl::SleepFor(absl::Milliseconds(1));
    ASSERT_TRUE(done());
  }
  // How a daemon with this URL refuses to start.
  std::string RefusalOfStart(const std::string& url) {
    Daemon daemon(SharingArguments(folder_.Write("other", url), folder_.Path("meshes"), "c"));
    std::string all, line;
    while (!(line = daemon.ReadLine()).empty()) all += line;
    EXPECT_EQ(daemon.Wait(), 1);
    EXPECT_THAT(all, ::testing::Not(::testing::HasSubstr("secret")));
    const size_t begin = all.find("latticed: ");
    return begin == std::string::npos ? all : all.substr(begin);
  }
  // The server that the stubs reach has all acknowledged edits, once.
  void CheckLattice() {
    v1::Lattice expected = states_[0].lattice();
    double* xyz = expected.mutable_control_points()->mutable_data();
    for (uint64_t n = 1; n <= acknowledged_; ++n) xyz[3 * (n % 125) + 2] += 0.01;
    const v1::LatticeState state = Lattice();
    EXPECT_EQ(state.revision(), acknowledged_);
    EXPECT_EQ(state.lattice().SerializeAsString(), expected.SerializeAsString());
  }

  std::atomic<uint64_t> acknowledged_ = kEditsBefore;
  std::atomic<uint64_t> refused_ = 0;
};

TEST_F(OutageTest, EditsGoOnAfterACrashOfPostgres) {
  const auto seed = std::random_device{}();
  SCOPED_TRACE(fmt::format("seed {}", seed));
  std::mt19937 random(seed);
  std::jthread editor([this](const std::stop_token& stop) { EditUntil(stop); });
  for (int crash = 0; crash < kCrashes; ++crash) {
    uint64_t before = acknowledged_;
    ASSERT_NO_FATAL_FAILURE(Await([&] { return acknowledged_ > before + 5; }));
    absl::SleepFor(absl::Microseconds(random() % 20'000));
    const uint64_t refused = refused_;
    PostgresServer::Shared().Crash();
    ASSERT_NO_FATAL_FAILURE(Await([&] { return refused_ > refused; }));
    before = acknowledged_;
    const absl::Time start = absl::Now();
    PostgresServer::Shared().Start();
    ASSERT_NO_FATAL_FAILURE(Await([&] { return acknowledged_ > before; }));
    printf("edits went on %.0f ms after PostgreSQL's start\n",
           absl::ToDoubleMilliseconds(absl::Now() - start));
  }
  editor.request_stop();
  editor.join();
  CheckLattice();

  a_->End(SIGKILL);
  AwaitMove();
  Reach(b_->channel());
  CheckLattice();
}

TEST_F(OutageTest, AReadOnlyPostgresIsRead) {
  absl::Status status;
  {
    const PostgresSetting read_only(url_, "default_transaction_read_only", "on");
    // PostgreSQL takes the setting a little later.
    while ((status = Apply(Edit(acknowledged_ + 1))).ok()) ++acknowledged_;
    ExpectRefusal(status, {absl::StatusCode::kUnavailable, "STORE", "", "read-only transaction"});
    absl::SleepFor(kLease * 1.5);
    ExpectRefusal(Apply(Edit(acknowledged_ + 1)),
                  {absl::StatusCode::kUnavailable, "STORE", "", "read-only transaction"});

    CheckLattice();
    WatchClient watcher(*scenes_, Watch());
    watcher.ReadUpdates(1);
    EXPECT_EQ(watcher.log.hello.head_revision(), acknowledged_);
    EXPECT_EQ(SceneCount(), 1);
    EXPECT_EQ(MeshCount(), 1);
  }
  Await([&] { return Apply(Edit(acknowledged_ + 1)).ok(); });
  ++acknowledged_;
  CheckLattice();
}

TEST_F(OutageTest, AStartIsRefusedInASentence) {
  EXPECT_EQ(RefusalOfStart("postgresql://ann:secret@127.0.0.1:1/scenes"),
            "latticed: the store fails: PostgreSQL: connection to server at \"127.0.0.1\", port 1 "
            "failed: Connection refused\n");
  EXPECT_EQ(RefusalOfStart("postgres//ann:secret@host/scenes"),
            fmt::format("latticed: {}: not a URL of PostgreSQL; write "
                        "postgresql://user:password@host:5432/database\n",
                        folder_.Path("other")));
  EXPECT_EQ(
      RefusalOfStart("postgresql://ann:pre@secret@127.0.0.1:1/scenes"),
      fmt::format("latticed: {}: percent-encode @, /, ? and # in the URL's user, password and "
                  "options: %40, %2F, %3F, %23; and write a port as a number\n",
                  folder_.Path("other")));
  ExecuteSql(url_, "UPDATE latticed.version SET number = 4");
  EXPECT_EQ(
      RefusalOfStart(url_),
      "latticed: the database has schema 4, which a newer latticed made; this one reads up to "
      "3\n");
}

}  // namespace
}  // namespace latticed::testing
