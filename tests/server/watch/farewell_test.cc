// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a Deform ends with an error. Behind a proxy, which x-forwarded-for shows, its client is told in a goaway and has a
// second to half-close, because some proxies replace the status of a call that ends before.
#include <algorithm>
#include <functional>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

const Metadata kProxied{{"x-forwarded-for", "192.0.2.7"}};
constexpr absl::Duration kSoon = absl::Milliseconds(800), kFarewell = absl::Seconds(1);

class FarewellTest : public StreamTest {
 protected:
  // The time of an attempt that took less than kSoon, or the least of several: the machine may stall in one.
  static absl::Duration Least(const std::function<absl::Duration()>& attempt) {
    absl::Duration least = absl::InfiniteDuration();
    for (int i = 0; i < 5 && least >= kSoon; ++i) least = std::min(least, attempt());
    return least;
  }
  // Expects this goaway to be the stream's next event but hello and updates.
  static void ExpectFarewell(DeformClient& client, absl::StatusCode code, const std::string& reason,
                             const std::string& field = "") {
    ASSERT_NO_FATAL_FAILURE(client.ReadUntil([&] { return !client.log.goaways.empty(); }));
    const v1::Goaway& goaway = client.log.goaways[0];
    EXPECT_EQ(goaway.reason(), v1::GOAWAY_REASON_UNSPECIFIED);
    ExpectRefused(client::FromRpc(goaway.status()), code, reason, field);
  }
};

TEST_F(FarewellTest, ARefusalIsToldAndComesWithTheHalfClose) {
  CreateScene();
  v1::WatchRequest unknown = Watch();
  unknown.set_scene("no-such-scene");
  const absl::Duration pause = Least([&] {
    DeformClient client(*scenes_, unknown, kProxied);
    ExpectFarewell(client, absl::StatusCode::kNotFound, "NOT_FOUND");

    const absl::Time closed = absl::Now();
    client.HalfClose();
    ExpectRefused(client.Finish(), absl::StatusCode::kNotFound, "NOT_FOUND");
    const absl::Time ended = absl::Now();
    EXPECT_EQ(client.log.events.size(), 1u);
    return ended - closed;
  });
  EXPECT_LT(pause, kSoon);
}

TEST_F(FarewellTest, AClientThatDoesNotHalfCloseWaitsASecond) {
  CreateScene();
  DeformClient client(*scenes_, Watch(), kProxied);
  client.ReadUpdates(1);
  const absl::Time deleted = absl::Now();
  ASSERT_OK(DeleteScene());
  ExpectFarewell(client, absl::StatusCode::kNotFound, "NOT_FOUND");
  // What it sends meanwhile is neither taken nor answered.
  ASSERT_TRUE(client.Send(Move(1, 62, 0.1)));
  ASSERT_TRUE(client.Send(Move(2, 62, 0.1)));

  ExpectRefused(client.Finish(), absl::StatusCode::kNotFound, "NOT_FOUND");
  EXPECT_GE(absl::Now() - deleted, kFarewell);
  EXPECT_TRUE(client.log.results.empty());
}

TEST_F(FarewellTest, ABadMessageEndsTheStreamInTheSameWay) {
  CreateScene();
  DeformClient client(*scenes_, Watch(), kProxied);
  client.ReadUpdates(1);
  ASSERT_TRUE(client.Open(Watch()));
  ExpectFarewell(client, absl::StatusCode::kInvalidArgument, "INVALID_FIELD", "watch");

  client.HalfClose();
  EXPECT_THAT(client.Finish(), StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST_F(FarewellTest, WithoutAProxyOnlyTheStatusTells) {
  const absl::Duration pause = Least([&] {
    CreateScene();
    DeformClient client(*scenes_, Watch());
    client.ReadUpdates(1);
    const absl::Time deleted = absl::Now();
    EXPECT_OK(DeleteScene());

    ExpectRefused(client.Finish(), absl::StatusCode::kNotFound, "NOT_FOUND");
    const absl::Time ended = absl::Now();
    EXPECT_TRUE(client.log.goaways.empty());
    return ended - deleted;
  });
  EXPECT_LT(pause, kSoon);
}

TEST_F(FarewellTest, ACancelledStreamEndsAtOnce) {
  const absl::Duration pause = Least([&] {
    StartServer(kHeartbeat);
    CreateScene();
    DeformClient client(*scenes_, Watch(), kProxied);
    client.ReadUpdates(1);
    EXPECT_OK(DeleteScene());
    ExpectFarewell(client, absl::StatusCode::kNotFound, "NOT_FOUND");
    const absl::Time cancelled = absl::Now();
    client.Cancel();

    EXPECT_THAT(client.Finish(), StatusIs(absl::StatusCode::kCancelled));
    server_.reset();  // waits for the call
    return absl::Now() - cancelled;
  });
  EXPECT_LT(pause, kSoon);
}

TEST_F(FarewellTest, AWrongTokenIsToldToo) {
  const TemporaryFolder folder;
  Options options = TestOptions();
  options.token_file = folder.Write("tokens", fmt::format("{} edit ed\n", Sha256Hex("token-e")));
  ServerTest::StartServer(options);
  Metadata wrong = kProxied;
  wrong["authorization"] = "Bearer token-x";
  DeformClient client(*scenes_, Watch(), wrong);
  ExpectFarewell(client, absl::StatusCode::kUnauthenticated, "UNAUTHENTICATED");

  client.HalfClose();
  EXPECT_THAT(client.Finish(), StatusIs(absl::StatusCode::kUnauthenticated));
}

}  // namespace
}  // namespace latticed::testing
