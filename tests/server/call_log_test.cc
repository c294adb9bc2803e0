// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Every stream leaves one line in the log, as every unary call does.

#include "tests/server/call_sink.h"
#include "tests/server/stream_support.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using Line = CallSink::Line;

constexpr char kTrace[] = "0123456789abcdef0123456789abcdef";

class CallLogTest : public StreamTest {
 protected:
  void SetUp() override {
    StreamTest::SetUp();
    CreateScene();
    sink_ = CallSink::Install();
    ASSERT_NE(sink_, nullptr);
  }

  static void Name(grpc::ClientContext& context, const std::string& request_id) {
    context.AddMetadata("latticed-request-id", request_id);
    context.AddMetadata("traceparent", std::string("00-") + kTrace + "-0123456789abcdef-01");
  }
  // One line, whole.
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
  {
    grpc::ClientContext context;
    Name(context, "update-1");
    v1::GetUpdateRequest request;
    request.set_scene(kScene);
    const auto reader = scenes_->GetUpdate(&context, request);
    v1::SceneEvent event;
    while (reader->Read(&event)) continue;
    ASSERT_TRUE(reader->Finish().ok());
  }
  {
    grpc::ClientContext context;
    Name(context, "export-1");
    v1::ExportRequest request;
    request.set_scene(kScene);
    request.set_format(v1::EXPORT_FORMAT_OBJ);
    const auto reader = scenes_->Export(&context, request);
    v1::ExportResponse part;
    while (reader->Read(&part)) continue;
    ASSERT_TRUE(reader->Finish().ok());
  }
  {
    grpc::ClientContext context;
    Name(context, "deform-1");
    const auto stream = scenes_->Deform(&context);
    v1::DeformRequest request;
    *request.mutable_watch() = Watch();
    stream->Write(request);
    stream->WritesDone();
    v1::SceneEvent event;
    while (stream->Read(&event)) continue;
    ASSERT_TRUE(stream->Finish().ok());
  }

  ExpectLine("update-1", "SceneService/GetUpdate", "OK");
  ExpectLine("export-1", "SceneService/Export", "OK");
  ExpectLine("deform-1", "SceneService/Deform", "OK");
}

TEST_F(CallLogTest, StreamsThatAreRefusedOrCancelled) {
  {
    grpc::ClientContext context;
    Name(context, "topology-1");
    v1::GetTopologyRequest request;
    request.set_scene(kScene);
    request.set_topology_id("none");
    const auto reader = scenes_->GetTopology(&context, request);
    v1::TopologyPart part;
    EXPECT_FALSE(reader->Read(&part));
    EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  }
  {
    grpc::ClientContext context;
    Name(context, "watch-1");
    v1::WatchRequest request = Watch();
    const auto reader = scenes_->Watch(&context, request);
    v1::SceneEvent event;
    EXPECT_TRUE(reader->Read(&event));
    context.TryCancel();
    while (reader->Read(&event)) continue;
    (void)reader->Finish();
  }
  // The client does not wait for the server to hear that it has gone.
  EXPECT_TRUE(testing::Becomes(1'000, [this] { return !sink_->Of("watch-1").empty(); }));

  ExpectLine("topology-1", "SceneService/GetTopology", "NOT_FOUND");
  ExpectLine("watch-1", "SceneService/Watch", "CANCELLED");
}

TEST_F(CallLogTest, WhatIsNoIdIsNotLogged) {
  const std::string scene(500'000, 'x');
  {
    grpc::ClientContext context;
    Name(context, "topology-2");
    v1::GetTopologyRequest request;
    request.set_scene(scene);
    const auto reader = scenes_->GetTopology(&context, request);
    EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  }
  {
    grpc::ClientContext context;
    Name(context, "watch-2");
    v1::WatchRequest request;
    request.set_scene(scene);
    EXPECT_EQ(scenes_->Watch(&context, request)->Finish().error_code(),
              grpc::StatusCode::NOT_FOUND);
  }
  {
    grpc::ClientContext context;
    Name(context, "deform-2");
    const auto stream = scenes_->Deform(&context);
    v1::DeformRequest request;
    request.mutable_watch()->set_scene(scene);
    stream->Write(request);
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
  }

  for (const char* id : {"topology-2", "watch-2", "deform-2"}) {
    std::vector<Line> lines = sink_->Of(id);
    ASSERT_EQ(lines.size(), 1u) << id;
    EXPECT_EQ(lines[0]["scene"], "") << id;
    EXPECT_EQ(lines[0]["code"], "NOT_FOUND") << id;
    for (const auto& [name, value] : lines[0]) EXPECT_LE(value.size(), 1'024u) << id << " " << name;
  }
}

}  // namespace
}  // namespace latticed::testing
