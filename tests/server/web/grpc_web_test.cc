// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// gRPC-Web over real sockets: every kind of rpc, and every way that one goes wrong.
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>

#include "absl/strings/escaping.h"
#include "client/cpp/library/status.h"
#include "core/base/error.h"
#include "latticed/v1/server.pb.h"
#include "tests/server/web/web_fixture.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

std::string Reason(const GrpcWebAnswer& answer) {
  std::string details;
  const auto found = answer.trailers.find("grpc-status-details-bin");
  if (found == answer.trailers.end() || !absl::Base64Unescape(found->second, &details)) return "";
  const grpc::Status status(static_cast<grpc::StatusCode>(answer.code), "", details);
  return error::DetailsOf(client::FromGrpc(status)).reason;
}

EventLog LogOf(const GrpcWebAnswer& answer) {
  EventLog log;
  for (const std::string& message : answer.messages) {
    v1::SceneEvent event;
    EXPECT_TRUE(event.ParseFromString(message));
    log.Take(event);
  }
  return log;
}

TEST_F(WebTest, CallsAUnaryRpcWithMetadataBothWays) {
  Serve();
  WebClient client(http());

  const GrpcWebAnswer answer =
      CallGrpcWeb(client, kInfo, Frame(""), {{"latticed-request-id", "from-a-browser"}});

  EXPECT_EQ(answer.http.status, 200);
  EXPECT_EQ(answer.http.fields.at("content-type"), "application/grpc-web+proto");
  EXPECT_EQ(answer.http.fields.at("latticed-request-id"), "from-a-browser");
  EXPECT_EQ(answer.http.fields.at("latticed-node"), "test-node");
  EXPECT_EQ(answer.trailers.at("latticed-request-id"), "from-a-browser");
  EXPECT_EQ(answer.code, 0);
  ASSERT_EQ(answer.messages.size(), 1);
  v1::ServerInfo info;
  ASSERT_TRUE(info.ParseFromString(answer.messages[0]));
  EXPECT_EQ(info.node(), "test-node");
  EXPECT_EQ(CallGrpcWeb(client, kInfo, Frame("")).code, 0) << "the connection goes on";
}

TEST_F(WebTest, StreamsAnUpdate) {
  ServeScene();
  auto request = For<v1::GetUpdateRequest>();

  const GrpcWebAnswer answer =
      Call("latticed.v1.SceneService/GetUpdate", Frame(request.SerializeAsString()));

  EXPECT_EQ(answer.code, 0);
  const EventLog log = LogOf(answer);
  ASSERT_EQ(log.ends.size(), 1);
  EXPECT_EQ(log.chunks.size(), log.begins[0].chunk_count());
}

// Each method itself answers or refuses an empty message.
TEST_F(WebTest, EveryMethodOfEveryServiceIsReached) {
  ServeScene();
  int methods = 0;
  for (const auto* file :
       {v1::ListMeshesRequest::descriptor()->file(), v1::WatchRequest::descriptor()->file(),
        v1::ServerInfo::descriptor()->file()}) {
    for (int i = 0; i < file->service_count(); ++i) {
      for (int m = 0; m < file->service(i)->method_count(); ++m, ++methods) {
        const google::protobuf::MethodDescriptor& method = *file->service(i)->method(m);
        const std::string rpc = method.service()->full_name() + "/" + method.name();

        const GrpcWebAnswer answer = Call(rpc, Frame(""), {{"grpc-timeout", "60S"}});

        EXPECT_EQ(answer.http.status, 200) << rpc;
        EXPECT_NE(answer.code, 12) << rpc;
        if (answer.code == 0) {
          EXPECT_EQ(answer.messages.size(), 1) << rpc;
        } else {
          EXPECT_NE(Reason(answer), "") << rpc << " says " << answer.code;
        }
      }
    }
  }
  EXPECT_GE(methods, 23);
}

// The end of the body half-closes the stream. It then ends after the update with the last edit.
TEST_F(WebTest, ABodyOfDeformIsEditsAndTheirUpdate) {
  ServeScene();
  v1::DeformRequest request;
  *request.mutable_watch() = Watch();
  std::string body = Frame(request.SerializeAsString());
  for (uint64_t i = 1; i <= 3; ++i) {
    *request.mutable_edit() = Move(i, 62, 0.5);
    body += Frame(request.SerializeAsString());
  }

  const GrpcWebAnswer answer = Call("latticed.v1.SceneService/Deform", body);

  EXPECT_EQ(answer.code, 0);
  const EventLog log = LogOf(answer);
  EXPECT_EQ(log.results.size(), 3);
  ASSERT_FALSE(log.ends.empty());
  EXPECT_EQ(log.ends.back().revision(), 3);
  EXPECT_EQ(log.ends.back().applied_sequence(), 3);
}

// Browsers cannot stream a request, but one body may hold several messages.
TEST_F(WebTest, UploadsSeveralMessagesInOneBody) {
  Serve();
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  v1::UploadMeshRequest request;
  request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
  request.mutable_header()->set_total_bytes(obj.size());
  std::string body = Frame(request.SerializeAsString());
  for (const char c : obj) {
    request.set_data(std::string(1, c));
    body += Frame(request.SerializeAsString());
  }

  const GrpcWebAnswer answer = Call("latticed.v1.MeshService/UploadMesh", body);

  EXPECT_EQ(answer.code, 0) << answer.trailers.at("grpc-message");
  ASSERT_EQ(answer.messages.size(), 1);
  v1::Mesh mesh;
  ASSERT_TRUE(mesh.ParseFromString(answer.messages[0]));
  EXPECT_EQ(mesh.faces(), 1);
}

TEST_F(WebTest, HealthAndReflectionAreRpcsLikeAny) {
  Serve();

  const GrpcWebAnswer health = Call("grpc.health.v1.Health/Check", Frame(""));
  const GrpcWebAnswer services =
      Call("grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", Frame("\x3a\x01*"));

  ASSERT_EQ(health.messages.size(), 1);
  EXPECT_EQ(health.messages[0], "\x08\x01");
  EXPECT_EQ(services.code, 0);
  ASSERT_EQ(services.messages.size(), 1);
  EXPECT_THAT(services.messages[0], HasSubstr("latticed.v1.SceneService"));
}

TEST_F(WebTest, AnUnknownMethodIsToldInTheTrailers) {
  Serve();

  EXPECT_EQ(Call("latticed.v1.ServerService/NoSuchMethod", Frame("")).code, 12);
  EXPECT_EQ(Call("no.such.Service/Method", Frame("")).code, 12);
}

TEST_F(WebTest, ARefusalHasItsDetails) {
  Serve();
  auto request = For<v1::GetSceneRequest>("no-such-scene");

  const GrpcWebAnswer answer =
      Call("latticed.v1.SceneService/GetScene", Frame(request.SerializeAsString()));

  EXPECT_EQ(answer.http.status, 200);
  EXPECT_EQ(answer.code, 5);
  EXPECT_THAT(answer.trailers.at("grpc-message"), HasSubstr("no-such-scene"));
  EXPECT_EQ(Reason(answer), "NOT_FOUND");
  EXPECT_EQ(answer.trailers.at("latticed-node"), "test-node");
}

struct BadBody {
  std::string name;
  std::string body;
  int code;
  std::string words;
};

TEST_F(WebTest, BadFramesAreRefusedInTheTrailers) {
  Serve();
  std::string huge(5, '\0');
  huge[1] = 0x01;  // 16 MiB announced
  std::string compressed = Frame("x");
  compressed[0] = 1;
  std::string flags = Frame("x");
  flags[0] = 0x40;

  for (const BadBody& bad :
       {BadBody{"too large", huge, 8, "1048576"},
        {"compressed", compressed, 12, "compression"},
        {"flags", flags, 3, "0x40"},
        {"cut", Frame("cut off").substr(0, 8), 3, "ends in the middle of a frame"},
        {"no message", "", 3, "cannot be parsed"},
        {"no protobuf", Frame("\xff\xff\xff"), 3, "cannot be parsed"}}) {
    GrpcWebAnswer answer = Call(kInfo, bad.body);
    EXPECT_EQ(answer.http.status, 200) << bad.name;
    EXPECT_EQ(answer.code, bad.code) << bad.name << ": " << answer.trailers["grpc-message"];
    EXPECT_THAT(answer.trailers["grpc-message"], HasSubstr(bad.words)) << bad.name;
  }
}

TEST_F(WebTest, AMessageAsLargeAsAllowedIsTaken) {
  Serve();
  v1::GetSceneRequest request;
  request.set_scene(std::string((size_t{1} << 20) - 4, 'x'));
  ASSERT_EQ(request.ByteSizeLong(), size_t{1} << 20);

  const GrpcWebAnswer answer =
      Call("latticed.v1.SceneService/GetScene", Frame(request.SerializeAsString()));

  EXPECT_EQ(answer.code, 5);
}

TEST_F(WebTest, ABadTimeoutOrValueIsRefused) {
  Serve();

  const GrpcWebAnswer timeout = Call(kInfo, Frame(""), {{"grpc-timeout", "soon"}});
  const GrpcWebAnswer accent = Call(kInfo, Frame(""), {{"latticed-scene", "caf\xc3\xa9"}});

  EXPECT_EQ(timeout.code, 3);
  EXPECT_THAT(timeout.trailers.at("grpc-message"), HasSubstr("grpc-timeout"));
  EXPECT_EQ(accent.code, 3);
  EXPECT_THAT(accent.trailers.at("grpc-message"), HasSubstr("latticed-scene"));
}

TEST_F(WebTest, ACompressedRequestIsRefused) {
  Serve();

  for (const std::string encoding : {"gzip", "deflate", "br"}) {
    EXPECT_EQ(Call(kInfo, Frame(""), {{"grpc-encoding", encoding}}).code, 12) << encoding;
  }
  EXPECT_EQ(Call(kInfo, Frame(""), {{"grpc-encoding", "identity"}}).code, 0);
}

TEST_F(WebTest, OtherFormsOfGrpcAreNotTaken) {
  Serve();

  for (const std::string type :
       {"application/grpc", "application/grpc-web-text", "application/json"}) {
    EXPECT_EQ(Call(kInfo, Frame(""), {{"content-type", type}}).http.status, 415) << type;
  }
}

TEST_F(WebTest, TheDeadlineEndsAStream) {
  ServeScene();

  const GrpcWebAnswer answer = Call("latticed.v1.SceneService/Watch",
                                    Frame(Watch().SerializeAsString()), {{"grpc-timeout", "300m"}});

  EXPECT_EQ(answer.code, 4);
}

TEST_F(WebTest, TokensAreThoseOfGrpc) {
  AskForTokens();
  Serve();

  EXPECT_EQ(Call(kInfo, Frame("")).code, 16);
  EXPECT_EQ(Call(kInfo, Frame(""), {{"authorization", "Bearer wrong"}}).code, 16);
  EXPECT_EQ(Call(kInfo, Frame(""), {{"authorization", "Bearer secret-edit"}}).code, 0);
  EXPECT_EQ(Get("/").status, 200) << "the viewer itself is no secret";
}

TEST_F(WebTest, ABrowserThatGoesAwayEndsItsCall) {
  options_.max_watchers = 1;
  ServeScene();
  const std::string watch = Frame(Watch().SerializeAsString());
  WebClient leaving(http());
  ASSERT_TRUE(StartsWatch(leaving, Watch()));
  const WebFields late = {{"grpc-timeout", "60S"}}, soon = {{"grpc-timeout", "100m"}};
  ASSERT_EQ(Call("latticed.v1.SceneService/Watch", watch, late).code, 8) << "one place, taken";

  leaving.Close();

  int code = 8;
  EXPECT_TRUE(testing::Becomes(2000, [&] {
    code = Call("latticed.v1.SceneService/Watch", watch, soon).code;
    return code != 8;
  }));
  EXPECT_EQ(code, 4) << "the place was given back";
}

// Another watcher sees every revision. A reader that does not read stops only its own stream. It later
// gets the newest state, not all that it has missed.
TEST_F(WebTest, AReaderThatDoesNotReadIsSentNoQueue) {
  constexpr int kEdits = 30;
  ServeScene(24);
  v1::WatchRequest request = Watch("reader");
  request.mutable_view()->set_encoding(v1::ENCODING_RAW);
  request.mutable_view()->set_segments(8);
  WebClient slow(http());
  slow.Send("POST", "/latticed.v1.SceneService/Watch",
            {{"content-type", "application/grpc-web+proto"}, {"grpc-timeout", "120S"}},
            Frame(request.SerializeAsString()));
  DeformClient quick(*scenes_);
  request.set_editor_id("quick");
  quick.Open(request);
  size_t update_bytes = 0;
  for (uint64_t i = 1; i <= kEdits; ++i) {
    ASSERT_OK(Apply(Move(i, 62, 0.01)));
    quick.ReadUntilRevision(i);
  }
  for (const auto& [index, data] : quick.log.chunks) update_bytes += data.size();
  ASSERT_GT(update_bytes * kEdits, size_t{60} << 20) << "beyond what sockets buffer";

  ASSERT_OK(DeleteScene());
  const GrpcWebAnswer stream = ReadFrames(slow.Receive());

  size_t updates = 0;
  for (const std::string& message : stream.messages) {
    v1::SceneEvent event;
    ASSERT_TRUE(event.ParseFromString(message));
    if (event.has_update_begin()) ++updates;
  }
  EXPECT_GT(updates, 0);
  EXPECT_LT(updates, kEdits / 2);
}

}  // namespace
}  // namespace latticed::testing
