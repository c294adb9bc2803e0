// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The log: its lines, its sums of refusals, and that nobody has to read it.
#include <thread>

#include "server/base/log_line.h"
#include "server/base/refusal_log.h"
#include "tests/server/daemon/daemon_process.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// More lines than a pipe (64 KiB) and the log's queue hold.
constexpr int kCalls = 2'000;

TEST(LogTest, LinesForPeopleAndForMachines) {
  const std::initializer_list<LogField> fields = {
      {"rpc", "A/B"}, {"empty", ""}, {"error", "two \"words\"\n"}};

  EXPECT_EQ(FormatEvent("text", "call finished", fields),
            "call finished rpc=A/B error=\"two \\\"words\\\" \"");
  EXPECT_EQ(FormatEvent("json", "call finished", fields),
            "\"message\":\"call finished\",\"rpc\":\"A/B\",\"error\":\"two \\\"words\\\" \"}");
}

TEST(LogTest, ValuesThatCouldForgeOrHideALineBecomeSpaces) {
  const auto shown = [](std::string_view value) {
    return FormatEvent("text", std::string(value), {});
  };

  EXPECT_EQ(shown("a\r\n\x1B[2Jb\x7F"), "a   [2Jb ");
  EXPECT_EQ(shown("a\u202Eb\u2066c\u200Fd\u061Ce"), "a b c d e");
  EXPECT_EQ(shown("a\u0085b\u2028c"), "a b c");
  EXPECT_EQ(shown("K\u00F6rper \u6587 \U0001F600"), "K\u00F6rper \u6587 \U0001F600");
  EXPECT_EQ(shown("a\xFF"), "a\uFFFD");
  EXPECT_EQ(shown(std::string(5'000, 'x')).size(), 1'024u);
}

// Calls `count` times, which the log tells each time at level debug.
void Call(const std::string& address, int count) {
  const auto stub =
      v1::ServerService::NewStub(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  for (int i = 0; i < count; ++i) {
    grpc::ClientContext context;
    context.set_wait_for_ready(true);
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
    v1::ServerInfo info;
    ASSERT_TRUE(stub->GetServerInfo(&context, {}, &info).ok()) << "call " << i;
  }
}

const std::vector<std::string> kLoudDaemon = {"--listen=127.0.0.1:0", "--backend=cpu",
                                              "--drain-delay=0s", "--log-level=debug"};

TEST(LogTest, ALogThatNobodyReadsStopsNeitherCallsNorTheEnd) {
  Daemon daemon(kLoudDaemon);
  Call(daemon.Address(), kCalls);

  const absl::Time signalled = absl::Now();
  daemon.Signal(SIGTERM);

  EXPECT_EQ(daemon.Wait(), 0);
  EXPECT_LT(absl::Now() - signalled, absl::Seconds(30));
}

TEST(LogTest, TellsHowManyLinesWereDropped) {
  Daemon daemon(kLoudDaemon);
  const std::string address = daemon.Address();
  Call(address, kCalls);

  std::string line;
  std::thread reader([&] {
    do line = daemon.ReadLine();
    while (!line.empty() && line.find("were dropped") == std::string::npos);
  });
  Call(address, kCalls);
  daemon.Signal(SIGTERM);  // two more lines, and then the end of the log
  reader.join();

  EXPECT_THAT(line, HasSubstr("log lines were dropped: nobody read them in time lines="));
  EXPECT_EQ(daemon.Wait(), 0);
}

TEST(RefusalLogTest, TellsTheFirstOfAKindAndSumsUpTheRest) {
  RefusalLog log;
  const absl::Time start = absl::UnixEpoch();
  const auto note = [&](std::string_view address, int code, absl::Duration after) {
    return log.Note(address, "MeshService/GetMesh", code, start + after);
  };
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(note("a", 5, absl::Seconds(1)));
  for (int i = 0; i < 7; ++i) EXPECT_FALSE(note("a", 5, absl::Seconds(2)));
  EXPECT_TRUE(note("a", 16, absl::Seconds(2))) << "another code";
  EXPECT_TRUE(note("b", 5, absl::Seconds(2))) << "another address";

  EXPECT_THAT(log.TakeEnded(start + absl::Seconds(10)), IsEmpty()) << "the period runs";
  EXPECT_THAT(log.TakeEnded(start + absl::Seconds(12)),
              ElementsAre(RefusalLog::Sum{"a", "MeshService/GetMesh", 5, 7}));
  EXPECT_THAT(log.TakeEnded(start + absl::Seconds(99)), IsEmpty());
  EXPECT_TRUE(note("a", 5, absl::Seconds(99))) << "a new period";
}

TEST(RefusalLogTest, AnyNumberOfAddressesTakesBoundedMemory) {
  RefusalLog log;
  uint64_t told = 0;
  for (int i = 0; i < 3'000; ++i) told += log.Note(fmt::to_string(i), "rpc", 5, absl::UnixEpoch());

  EXPECT_EQ(told, 1'005u);
  EXPECT_THAT(log.TakeEnded(absl::InfiniteFuture()),
              ElementsAre(RefusalLog::Sum{"others", "rpc", 5, 1'995}));
}

}  // namespace
}  // namespace latticed::testing
