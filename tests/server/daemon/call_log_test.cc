// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Every stream leaves one line in the log, as every unary call does.
#include "tests/server/support/call_sink.h"
#include "tests/server/support/server_test.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using Line = CallSink::Line;

constexpr char kTrace[] = "0123456789abcdef0123456789abcdef";

class CallLogTest : public SceneStreamTest {
 protected:
  void SetUp() override {
    SceneStreamTest::SetUp();
    sink_ = CallSink::Install();
    ASSERT_NE(sink_, nullptr);
  }

  static Metadata Named(const std::string& request_id) {
    return {{"latticed-request-id", request_id},
            {"traceparent", std::string("00-") + kTrace + "-0123456789abcdef-01"}};
  }
  // Expects one line with all its fields.
  void ExpectLine(const std::string& request_id, const std::string& rpc, const std::string& code) {
    const std::vector<Line> lines = sink_->Of(request_id);
    ASSERT_EQ(lines.size(), 1u) << rpc;
    Line line = lines[0];
    EXPECT_EQ(line["rpc"], rpc);
    EXPECT_EQ(line["code"], code);
    EXPECT_EQ(line["scene"], kScene);
    EXPECT_EQ(line["trace_id"], kTrace);
    EXPECT_GE(std::stod(line["ms"]), 0);
  }

  std::shared_ptr<CallSink> sink_;
};

TEST_F(CallLogTest, StreamsThatEndWell) {
  EXPECT_OK(ReadAll(&Scenes::GetUpdate, For<v1::GetUpdateRequest>(), nullptr, Named("update")));
  EXPECT_OK(ReadAll(&Scenes::Export, For<v1::ExportRequest>(), nullptr, Named("export")));
  DeformClient deform(*scenes_, Watch(), Named("deform"));
  deform.HalfClose();
  EXPECT_OK(deform.Finish());

  ExpectLine("update", "SceneService/GetUpdate", "OK");
  ExpectLine("export", "SceneService/Export", "OK");
  ExpectLine("deform", "SceneService/Deform", "OK");
}

TEST_F(CallLogTest, StreamsThatAreRefusedOrCancelled) {
  EXPECT_THAT(
      ReadAll(&Scenes::GetTopology, For<v1::GetTopologyRequest>(), nullptr, Named("topology")),
      StatusIs(absl::StatusCode::kNotFound));
  WatchClient watch(*scenes_, Watch(), Named("watch"));
  EXPECT_TRUE(watch.Read());
  watch.Cancel();
  // The client does not wait until the server notices the cancellation.
  EXPECT_TRUE(Becomes(1'000, [this] { return !sink_->Of("watch").empty(); }));

  ExpectLine("topology", "SceneService/GetTopology", "NOT_FOUND");
  ExpectLine("watch", "SceneService/Watch", "CANCELLED");
}

TEST_F(CallLogTest, ManyRefusalsOfAKindAreCountedInsteadOfTold) {
  const auto id = [](int i) { return fmt::format("refused-{}", i); };
  for (int i = 0; i < 7; ++i) {
    EXPECT_THAT(ReadAll(&Scenes::GetTopology, For<v1::GetTopologyRequest>(), nullptr, Named(id(i))),
                StatusIs(absl::StatusCode::kNotFound));
  }

  for (int i = 0; i < 7; ++i) EXPECT_EQ(sink_->Of(id(i)).size(), i < 5 ? 1u : 0u) << i;
}

TEST_F(CallLogTest, WhatIsNoIdIsNotLogged) {
  const std::string scene(500'000, 'x');
  const auto watch = For<v1::WatchRequest>(scene);
  EXPECT_THAT(
      ReadAll(&Scenes::GetTopology, For<v1::GetTopologyRequest>(scene), nullptr, Named("topology")),
      StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(WatchClient(*scenes_, watch, Named("watch")).Finish(),
              StatusIs(absl::StatusCode::kNotFound));
  EXPECT_THAT(DeformClient(*scenes_, watch, Named("deform")).Finish(),
              StatusIs(absl::StatusCode::kNotFound));

  for (const char* id : {"topology", "watch", "deform"}) {
    std::vector<Line> lines = sink_->Of(id);
    ASSERT_EQ(lines.size(), 1u) << id;
    EXPECT_EQ(lines[0]["scene"], "") << id;
    EXPECT_EQ(lines[0]["code"], "NOT_FOUND") << id;
    for (const auto& [name, value] : lines[0]) EXPECT_LE(value.size(), 1'024u) << id << " " << name;
  }
}

}  // namespace
}  // namespace latticed::testing
