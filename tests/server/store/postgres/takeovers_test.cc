// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene is taken from an owner that keeps writing, again and again. The fence keeps all that the owner acknowledged:
// without it, an append under way is acknowledged after the next owner has read the log.
// LATTICED_TAKEOVERS sets the number of takeovers: 30, and 300 in a whole run.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "fmt/format.h"
#include "gtest/gtest.h"
#include "server/store/postgres_store.h"
#include "tests/server/store/postgres_server.h"
#include "tests/server/store/store_family.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

constexpr uint64_t kAppendsBetween = 3;  // at least
constexpr int kAttempts = 5;             // an owner that is stuck ends one before a record is lost

// Appends are under way for some milliseconds after they have passed the fence.
constexpr char kSlowAppends[] =
    "CREATE FUNCTION slow() RETURNS trigger LANGUAGE plpgsql AS "
    "$$ BEGIN PERFORM pg_sleep(random() * 0.01); RETURN NEW; END $$; "
    "CREATE TRIGGER slow BEFORE INSERT ON latticed.record FOR EACH ROW EXECUTE FUNCTION slow()";

int Takeovers() {
  const char* takeovers = std::getenv("LATTICED_TAKEOVERS");
  return takeovers == nullptr ? 30 : std::atoi(takeovers);
}

// Appends records to a scene, one after the other, until one is refused.
class Owner {
 public:
  // `log` is what the store has.
  Owner(Store& store, std::vector<std::string> log)
      : log_(std::move(log)), thread_([this, &store] {
          while (Append(store)) ++appended_;
          ended_ = true;
        }) {}

  // False: it was refused before.
  bool AwaitAppends() const {
    while (appended_ < kAppendsBetween && !ended_) absl::SleepFor(absl::Milliseconds(1));
    return appended_ >= kAppendsBetween;
  }
  // The log as it was acknowledged, once a record is refused.
  std::vector<std::string> Acknowledged() {
    thread_.join();
    return std::move(log_);
  }

 private:
  bool Append(Store& store) {
    std::string record = fmt::format("record {} of {}", log_.size() + 1, fmt::ptr(this));
    const absl::Status status = AppendTo(store, "gear", log_.size() + 1, record);
    if (!status.ok()) {
      EXPECT_THAT(status, StatusIs(absl::StatusCode::kAborted));
      return false;
    }
    log_.push_back(std::move(record));
    return true;
  }

  std::vector<std::string> log_;
  std::atomic<uint64_t> appended_ = 0;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

class PostgresTakeovers : public ::testing::Test {
 protected:
  void SetUp() override {
    if (PostgresServer::IsInstalled()) return;
    ASSERT_EQ(std::getenv("LATTICED_REQUIRE_POSTGRES"), nullptr) << "PostgreSQL is not installed";
    GTEST_SKIP() << "PostgreSQL is not installed: no takeover was tested";
  }
  // Numbers of takeovers; 0: none.
  struct Outcome {
    int lost = 0;   // an acknowledged record was lost
    int stuck = 0;  // nothing was, but the next owner could not go on
  };
  Outcome TakeUntilALoss(bool fence) {
    const std::string url = PostgresServer::Shared().NewDatabase();
    std::array<std::unique_ptr<Store>, 2> stores = {Open(url, "a", fence), Open(url, "b", fence)};
    ExecuteSql(url, kSlowAppends);
    EXPECT_OK(stores[0]->CreateScene("gear", ""));
    auto owner = std::make_unique<Owner>(*stores[0], std::vector<std::string>());
    int takeover = 1;
    for (; takeover <= Takeovers() && owner->AwaitAppends(); ++takeover) {
      Store& next = *stores[static_cast<size_t>(takeover % 2)];
      Take(next, url, takeover % 2 == 1 ? "a" : "b");
      const absl::StatusOr<SceneLog> log = next.ReadScene("gear");
      EXPECT_OK(log.status());
      const std::vector<std::string> acknowledged = owner->Acknowledged();
      acknowledged_ = acknowledged.size();
      if (!log.ok()) return {.stuck = takeover};
      if (!IsBeginningOf(acknowledged, log->records)) return {.lost = takeover};
      owner = std::make_unique<Owner>(next, log->records);
    }
    const bool goes_on = owner->AwaitAppends();
    ExecuteSql(url, "UPDATE latticed.session SET fenced = true");  // refuses the next record
    (void)owner->Acknowledged();
    return {.stuck = goes_on ? 0 : takeover};
  }

  size_t acknowledged_ = 0;  // before the last takeover

 private:
  static bool IsBeginningOf(const std::vector<std::string>& acknowledged,
                            const std::vector<std::string>& log) {
    return acknowledged.size() <= log.size() &&
           std::equal(acknowledged.begin(), acknowledged.end(), log.begin());
  }
  // Ends the owner's lease, as if it had not renewed it, and claims the scene.
  static void Take(Store& next, const std::string& url, std::string_view owner) {
    absl::StatusOr<SceneClaim> claim;
    do {  // the owner may renew it in between, and at first every lease is good
      ExecuteSql(url, fmt::format("UPDATE latticed.session SET expires = clock_timestamp() - "
                                  "interval '1 s' WHERE name = '{}' AND NOT fenced",
                                  owner));
      claim = next.ClaimScene("gear");
    } while (claim.ok() && !claim->owner.empty());
    EXPECT_OK(claim.status());
  }
  std::unique_ptr<Store> Open(const std::string& url, const std::string& name, bool fence) {
    auto store = OpenPostgresStore({.url_file = folder_.Write("url", url),
                                    .mesh_store = folder_.Path("meshes"),
                                    .name = name,
                                    .lease = absl::Seconds(2),
                                    .fence = fence});
    EXPECT_OK(store.status());
    return *std::move(store);
  }

  const TemporaryFolder folder_;
};

TEST_F(PostgresTakeovers, LoseNothingThatWasAcknowledged) {
  const Outcome outcome = TakeUntilALoss(true);
  EXPECT_EQ(outcome.lost, 0);
  EXPECT_EQ(outcome.stuck, 0);
  EXPECT_GE(acknowledged_, static_cast<size_t>(Takeovers()) * kAppendsBetween);
  printf("%d takeovers, %zu acknowledged records\n", Takeovers(), acknowledged_);
}

TEST_F(PostgresTakeovers, LoseRecordsWithoutTheFence) {
  Outcome outcome;
  int attempt = 0;
  while (outcome.lost == 0 && attempt < kAttempts) {
    outcome = TakeUntilALoss(false);
    ++attempt;
  }
  EXPECT_GT(outcome.lost, 0) << "the test above would not notice a loss";
  printf("a record was lost at takeover %d, attempt %d\n", outcome.lost, attempt);
}

}  // namespace
}  // namespace latticed::testing
