// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Calls whose clients take nothing end after --write-timeout, whatever they are.
#include "server/rpc/stalled_calls.h"

#include "tests/server/support/server_test.h"
#include "tests/server/support/unfinished_calls.h"

namespace latticed::testing {
namespace {

class StalledCallsTest : public SceneFixture {
 protected:
  void SetUp() override {
    StartServer({.write_timeout = absl::Seconds(1)});
    ASSERT_OK(Create(SceneRequest()));
  }
};

TEST_F(StalledCallsTest, EveryKindOfCallEnds) {
  auto file = For<v1::ExportRequest>();
  file.set_format(v1::EXPORT_FORMAT_PLY);
  v1::DeformRequest deform;
  *deform.mutable_watch() = For<v1::WatchRequest>();
  for (const auto& [rpc, request] :
       {std::pair("GetScene", For<v1::GetSceneRequest>().SerializeAsString()),
        {"Export", file.SerializeAsString()},
        {"Watch", For<v1::WatchRequest>().SerializeAsString()},
        {"Deform", deform.SerializeAsString()}}) {
    SCOPED_TRACE(rpc);
    UnfinishedCalls calls(server_->address(), std::string("/latticed.v1.SceneService/") + rpc,
                          request);
    for (int i = 0; i < 3; ++i) calls.Begin();

    EXPECT_TRUE(calls.Run([&] { return calls.ended() == 3; }));
  }
  EXPECT_EQ(Get().revision(), 0u) << "and others are answered";
}

TEST_F(StalledCallsTest, AReaderIsLeftAlone) {
  WatchClient reader(*scenes_, For<v1::WatchRequest>());
  reader.ReadUpdates(1);
  UnfinishedCalls stalled(server_->address(), "/latticed.v1.SceneService/Watch",
                          For<v1::WatchRequest>().SerializeAsString());
  stalled.Begin();
  ASSERT_TRUE(stalled.Run([&] { return stalled.ended() == 1; }))
      << "more than the time limit later";

  ASSERT_OK(Apply(Move("alice", 1, 0, 0.1)));

  reader.ReadUntilRevision(1);
}

}  // namespace
}  // namespace latticed::testing
