// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Headers of any length, by hand: those that fit begin a call, others end their connection at once.
#include "server/edge/header_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "absl/time/clock.h"
#include "tests/server/scene_fixture.h"
#include "tests/server/unfinished_calls.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using Settings = UnfinishedCalls::Settings;

constexpr size_t kFrame = 16'384;

// A field that no table keeps, whose value has 127 to 16,510 bytes (RFC 7541).
std::string Field(size_t bytes) {
  const size_t rest = bytes - 127;
  const std::string head{
      '\0', 1, 'x', 127, static_cast<char>(rest % 128 | 128), static_cast<char>(rest / 128)};
  return head + std::string(bytes, 'y');
}
// One that the table keeps, then its number so many times: each is a field of 34 bytes.
std::string Numbers(size_t count) {
  return std::string{0x40, 1, 'x', 1, 'y'} + std::string(count, '\xBE');
}
// One of 2^28 bytes, of which so many come.
std::string PartOfField(size_t bytes) {
  return std::string{'\0', 1, 'x', 127, '\xFF', '\xFF', '\xFF', 127} + std::string(bytes, 'y');
}

class HeaderFramesTest : public SceneFixture {
 protected:
  std::unique_ptr<UnfinishedCalls> Connect(Settings settings = Settings::kAcknowledged) {
    auto result = std::make_unique<UnfinishedCalls>(
        server_->address(), "/latticed.v1.SceneService/ApplyEdits", 0, 1, settings);
    EXPECT_TRUE(result->Run([&] { return result->max_calls() > 0; }));
    return result;
  }
  // The server closes the connection, and answers others.
  void ExpectClosed(UnfinishedCalls& connection) {
    const absl::Time give_up = absl::Now() + absl::Seconds(30);
    EXPECT_FALSE(connection.Run([&] { return absl::Now() > give_up; })) << "it is still open";
    EXPECT_EQ(Info().limits().max_scenes(), 10'000);
  }
  static void ExpectOpen(UnfinishedCalls& connection) {
    EXPECT_TRUE(connection.AnswersPing());
    EXPECT_EQ(connection.ended(), 0u);
  }
};

TEST_F(HeaderFramesTest, AreBounded) { EXPECT_TRUE(HeadersAreBounded()); }

TEST_F(HeaderFramesTest, OfSomeKilobytesAreAllowed) {
  for (const Settings settings : {Settings::kAcknowledged, Settings::kIgnored}) {
    const auto connection = Connect(settings);
    connection->BeginWith("", kFrame, /*ends=*/true);
    connection->BeginWith(Field(7'000), kFrame, /*ends=*/true);
    connection->BeginWith(Numbers(200), kFrame, /*ends=*/true);
    ExpectOpen(*connection);
  }
}

// Also before the client has the server's settings, which say how much that is.
TEST_F(HeaderFramesTest, OfTooManyBytesEndTheirConnection) {
  for (const Settings settings : {Settings::kAcknowledged, Settings::kIgnored}) {
    for (const std::string& block : {Field(9'000), Field(9'000) + Field(16'000), Numbers(10'000),
                                     Field(4'000) + Field(4'000)}) {
      const auto connection = Connect(settings);
      connection->BeginWith(block, kFrame, /*ends=*/true);
      ExpectClosed(*connection);
    }
  }
}

// gRPC's clients send them none the less. What they are told of it may be lost with the connection.
TEST_F(HeaderFramesTest, OfTooManyBytesFailAStockClientsCall) {
  const auto stub = v1::ServerService::NewStub(server_->channel());
  const auto ask = [&](size_t bytes) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    context.AddMetadata("x", std::string(bytes, 'y'));
    v1::ServerInfo info;
    return stub->GetServerInfo(&context, {}, &info).error_code();
  };
  EXPECT_EQ(ask(7'000), grpc::StatusCode::OK);

  EXPECT_THAT(ask(9'000), ::testing::AnyOf(grpc::StatusCode::RESOURCE_EXHAUSTED,
                                           grpc::StatusCode::UNAVAILABLE));

  EXPECT_TRUE(testing::Becomes(2'000, [&] { return ask(7'000) == grpc::StatusCode::OK; }));
}

// The first ends between two fields or within one.
TEST_F(HeaderFramesTest, OfTwoFramesEndTheirConnection) {
  for (const size_t frame_bytes : {size_t{3}, size_t{1'200}}) {
    for (const bool ends : {false, true}) {
      const auto connection = Connect();
      connection->BeginWith(Field(1'000) + Field(1'000), frame_bytes, ends);
      ExpectClosed(*connection);
    }
  }
}

TEST_F(HeaderFramesTest, AFieldWithoutEndEndsItsConnection) {
  const auto connection = Connect();
  connection->BeginWith(PartOfField(4 * kFrame), kFrame, /*ends=*/false);
  ExpectClosed(*connection);
}

// The server allows frames of megabytes.
TEST_F(HeaderFramesTest, AFrameWithoutEndEndsItsConnection) {
  const auto connection = Connect();
  ASSERT_TRUE(connection->Run([&] { return connection->max_frame() > 4 * kFrame; }));

  connection->BeginPartOfFrame(PartOfField(2 * kFrame), connection->max_frame());

  ExpectClosed(*connection);
}

TEST_F(HeaderFramesTest, OfNoCallTheyAreBoundedToo) {
  const auto connection = Connect();
  connection->SendHeaderOfNoCall(Field(7'000));
  connection->SendHeaderOfNoCall(Field(7'000));
  connection->BeginWith(Field(7'000), kFrame, /*ends=*/true);
  ExpectOpen(*connection);

  connection->SendHeaderOfNoCall(PartOfField(9'000));
  ExpectClosed(*connection);
}

// What connections leave behind that end within a frame is nobody else's.
TEST_F(HeaderFramesTest, WhoLeavesWithinOneHarmsNobody) {
  for (int i = 0; i < 50; ++i) {
    auto gone = Connect();
    gone->BeginPartOfFrame(PartOfField(12'000), kFrame);
    absl::SleepFor(absl::Milliseconds(2));  // it is read
    gone.reset();
    const auto connection = Connect();
    connection->BeginInPieces(Field(7'000));
    ExpectOpen(*connection);
  }
}

}  // namespace
}  // namespace latticed::testing
