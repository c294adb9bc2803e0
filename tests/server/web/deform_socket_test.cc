// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Deform over a WebSocket: the same edits and updates as through the stub, the end of a stream as a page
// sees it, and many windows on one server.
#include <gmock/gmock.h>

#include <thread>

#include "absl/strings/escaping.h"
#include "tests/server/web/web_fixture.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string Target(const std::string& scene) {
  return "/ws/latticed.v1.SceneService/Deform?latticed-scene=" + scene;
}

// A page that watches and edits.
class Window {
 public:
  explicit Window(const std::string& address, const std::string& scene,
                  const std::string& protocols = "latticed.v1", const std::string& ca = "")
      : socket(address, Target(scene), protocols, {}, ca) {}

  bool Open(const v1::WatchRequest& watch) {
    v1::DeformRequest message;
    *message.mutable_watch() = watch;
    return socket.Send(message.SerializeAsString());
  }
  bool Send(const v1::EditBatch& batch) {
    v1::DeformRequest message;
    *message.mutable_edit() = batch;
    return socket.Send(message.SerializeAsString());
  }
  bool Read() {
    const auto bytes = socket.Read();
    if (!bytes.has_value()) return false;
    v1::SceneEvent event;
    EXPECT_TRUE(event.ParseFromString(*bytes));
    log.Take(event);
    return true;
  }
  void ReadUntilRevision(uint64_t revision) {
    while (log.ends.empty() || log.ends.back().revision() < revision) {
      ASSERT_TRUE(Read()) << socket.close_code() << " " << socket.close_reason();
    }
  }
  void ReadToEnd() {
    while (Read()) continue;
  }

  WebSocketClient socket;
  EventLog log;
};

TEST_F(WebTest, EditsOverAWebSocketAsThroughTheStub) {
  ServeScene();
  Window window(http(), kScene);
  ASSERT_EQ(window.socket.status(), 101);
  EXPECT_EQ(window.socket.protocol(), "latticed.v1");
  ASSERT_TRUE(window.Open(Watch("page")));
  window.ReadUntilRevision(0);
  const auto rest = window.log.chunks;

  ASSERT_TRUE(window.Send(Move(1, 62, 0.25, "page")));
  window.ReadUntilRevision(1);

  ASSERT_EQ(window.log.results.size(), 1);
  EXPECT_EQ(window.log.results[0].status().code(), 0);
  EXPECT_EQ(window.log.ends.back().applied_sequence(), 1);
  EXPECT_NE(window.log.chunks, rest);
  EventLog native;
  ASSERT_OK(Update(For<v1::GetUpdateRequest>(), native));
  EXPECT_EQ(window.log.chunks, native.chunks);
}

TEST_F(WebTlsTest, EditsOverAWebSocketOverTlsAsThroughTheStub) {
  ServeScene();
  Window window(http(), kScene, "latticed.v1", folder_.Path("server.crt"));
  ASSERT_EQ(window.socket.status(), 101);
  ASSERT_TRUE(window.Open(Watch("page")));
  window.ReadUntilRevision(0);

  ASSERT_TRUE(window.Send(Move(1, 62, 0.25, "page")));
  window.ReadUntilRevision(1);

  EventLog native;
  ASSERT_OK(Update(For<v1::GetUpdateRequest>(), native));
  EXPECT_EQ(window.log.chunks, native.chunks);
  window.socket.Close();
  EXPECT_EQ(window.socket.close_code(), 1000);
  EXPECT_NE(Window(http(), kScene).socket.status(), 101) << "and none without TLS";
}

TEST_F(WebTest, TheEndOfASocketIsTheStatusOfTheCall) {
  AskForTokens();
  Serve();
  const std::string good = "bearer." + absl::WebSafeBase64Escape("secret-edit");
  auto watch = For<v1::WatchRequest>("no-such-scene");

  struct Case {
    const char* scene;  // in the address
    std::string protocols;
    int code;
    const char* reason;
  };
  for (const Case& c :
       {Case{"no-such-scene", "latticed.v1", 4016, "UNAUTHENTICATED: "},
        Case{"no-such-scene", "latticed.v1, bearer.d3Jvbmc", 4016, "UNAUTHENTICATED: "},
        Case{"no-such-scene", "latticed.v1, " + good, 4005, "NOT_FOUND: "},
        Case{"another-scene", "latticed.v1," + good, 4003, "SCENE_MISMATCH: "}}) {
    Window window(http(), c.scene, c.protocols);
    window.Open(watch);
    window.ReadToEnd();
    EXPECT_EQ(window.socket.close_code(), c.code) << c.protocols;
    EXPECT_THAT(window.socket.close_reason(), StartsWith(c.reason));
    EXPECT_LE(window.socket.close_reason().size(), 123);
  }
}

TEST_F(WebTest, ANativeClientMaySendItsTokenAsAField) {
  AskForTokens();
  Serve();
  WebSocketClient socket(http(), Target("no-such-scene"), "",
                         {{"authorization", "Bearer secret-edit"}});
  v1::DeformRequest message;
  message.mutable_watch()->set_scene("no-such-scene");

  socket.Send(message.SerializeAsString());

  EXPECT_EQ(socket.protocol(), "");
  EXPECT_FALSE(socket.Read().has_value());
  EXPECT_EQ(socket.close_code(), 4005);
}

TEST_F(WebTest, WhatIsNoMessageEndsTheSocket) {
  ServeScene();

  Window text(http(), kScene);
  text.socket.Send("{}", true);
  text.ReadToEnd();
  Window garbage(http(), kScene);
  garbage.socket.Send("\xff\xff\xff");
  garbage.ReadToEnd();
  Window huge(http(), kScene);
  huge.socket.Send(std::string((size_t{1} << 20) + 1, '\0'));
  huge.ReadToEnd();

  EXPECT_EQ(text.socket.close_code(), 4003);
  EXPECT_THAT(text.socket.close_reason(), HasSubstr("binary"));
  EXPECT_EQ(garbage.socket.close_code(), 4003) << garbage.socket.close_reason();
  EXPECT_EQ(huge.socket.close_code(), 1009);
}

TEST_F(WebTest, HandshakesThatAreNoneAreRefused) {
  Serve();

  EXPECT_EQ(Get("/ws/latticed.v1.SceneService/Deform").status, 426);
  WebFields upgrade = {{"connection", "Upgrade"},
                       {"upgrade", "websocket"},
                       {"sec-websocket-version", "13"},
                       {"sec-websocket-key", "dGhlIHNhbXBsZSBub25jZQ=="}};
  EXPECT_EQ(Get("/ws/latticed.v1.SceneService/Deform?x=1", upgrade).status, 400);
  EXPECT_EQ(Get("/ws/latticed.v1.SceneService/Watch", upgrade).status, 404);
  upgrade["origin"] = "https://evil.example";
  EXPECT_EQ(Get(Target("a-scene"), upgrade).status, 403);
  upgrade.erase("origin");
  upgrade["sec-websocket-protocol"] = "graphql-ws";
  EXPECT_EQ(Get(Target("a-scene"), upgrade).status, 400);
  // gRPC ends the process at a call whose metadata is not printable.
  for (const char* token : {"\x8c", "secret-edit\n", "secret-edit\x7f", "\xc3\xa9"}) {
    upgrade["sec-websocket-protocol"] = "latticed.v1, bearer." + absl::WebSafeBase64Escape(token);
    EXPECT_EQ(Get(Target("a-scene"), upgrade).status, 400) << token;
  }
  upgrade.erase("sec-websocket-protocol");
  EXPECT_EQ(Get(Target("%8c"), upgrade).status, 400);
}

TEST_F(WebTest, EditsThatAPageSendsAsItClosesStillCount) {
  ServeScene();
  {
    Window window(http(), kScene);
    window.Open(Watch("page"));
    window.ReadUntilRevision(0);
    window.Send(Move(1, 62, 0.25, "page"));
    window.socket.Close();
  }

  auto request = For<v1::GetUpdateRequest>();
  request.set_min_revision(1);
  EventLog log;
  ASSERT_OK(Update(request, log));
  EXPECT_EQ(log.ends.back().revision(), 1);
}

TEST_F(WebTest, ASocketThatBreaksEndsItsCall) {
  options_.max_watchers = 1;
  ServeScene();
  Window leaving(http(), kScene);
  leaving.Open(Watch("page"));
  leaving.ReadUntilRevision(0);

  leaving.socket.Break();

  const auto opens = [this] {
    Window next(http(), kScene);
    next.Open(Watch("other"));
    return next.Read();
  };
  EXPECT_TRUE(Becomes(2000, opens)) << "the place was given back";
}

TEST_F(WebTest, DrainingSaysGoawayAndClosesInOrder) {
  ServeScene();
  Window window(http(), kScene);
  window.Open(Watch("page"));
  window.ReadUntilRevision(0);

  std::thread drain([this] { server_->Drain(); });
  window.ReadToEnd();
  drain.join();

  EXPECT_EQ(window.log.goaways.size(), 1);
  EXPECT_EQ(window.socket.close_code(), 1000) << window.socket.close_reason();
}

// A page that stops reading stops only its own stream. It later gets the newest state at once.
TEST_F(WebTest, ASocketThatIsNotReadIsSentNoQueue) {
  constexpr int kEdits = 30;
  ServeScene(24);
  v1::WatchRequest watch = Watch("slow");
  watch.mutable_view()->set_encoding(v1::ENCODING_RAW);
  watch.mutable_view()->set_segments(8);
  Window slow(http(), kScene), quick(http(), kScene);
  slow.Open(watch);
  watch.set_editor_id("quick");
  quick.Open(watch);

  for (uint64_t i = 1; i <= kEdits; ++i) {
    quick.Send(Move(i, 62, 0.01, "quick"));
    ASSERT_NO_FATAL_FAILURE(quick.ReadUntilRevision(i));
  }
  slow.ReadUntilRevision(kEdits);

  EXPECT_LT(slow.log.ends.size(), kEdits / 2);
  EXPECT_EQ(slow.log.chunks, quick.log.chunks);
}

// A message waits in the server until the page reads again. The call ends after it, and holds nothing then.
TEST_F(WebTest, AnErrorDuringAnUpdateToASlowPageLeavesNothing) {
  ServeScene(24);
  v1::WatchRequest watch = Watch("page");
  watch.mutable_view()->set_encoding(v1::ENCODING_RAW);
  watch.mutable_view()->set_segments(16);
  Window window(http(), kScene);
  ASSERT_TRUE(window.Open(watch));
  ASSERT_TRUE(Becomes(2'000, [this] { return Metric("latticed_updates_begun_total") > 0; }));

  ASSERT_TRUE(window.socket.Send("\xff"));  // while the update is on its way
  window.ReadToEnd();

  EXPECT_EQ(window.socket.close_code(), 4003) << window.socket.close_reason();
  EXPECT_TRUE(Becomes(500, [this] { return Metric("latticed_watchers") == 0; }));
}

TEST_F(WebTest, TwelveWindowsOnOneServerStillEdit) {
  constexpr uint64_t kWindows = 12;
  ServeScene();
  std::vector<std::unique_ptr<Window>> windows;
  for (uint64_t i = 0; i < kWindows; ++i) {
    windows.push_back(std::make_unique<Window>(http(), kScene));
    ASSERT_TRUE(windows.back()->Open(Watch(fmt::format("window-{}", i))));
    windows.back()->ReadUntilRevision(0);
  }

  for (uint64_t i = 0; i < kWindows; ++i) {
    windows[i]->Send(Move(1, static_cast<uint32_t>(i), 0.1, fmt::format("window-{}", i)));
  }
  std::vector<std::unique_ptr<WebClient>> calls;  // beside the sockets, all at once
  auto request = For<v1::GetUpdateRequest>();
  request.set_min_revision(kWindows);
  for (uint64_t i = 0; i < kWindows; ++i) {
    calls.push_back(std::make_unique<WebClient>(http()));
    calls.back()->Send("POST", "/latticed.v1.SceneService/GetUpdate",
                       {{"content-type", "application/grpc-web+proto"}},
                       Frame(request.SerializeAsString()));
  }

  for (const auto& window : windows) {
    ASSERT_NO_FATAL_FAILURE(window->ReadUntilRevision(kWindows));
    ASSERT_EQ(window->log.results.size(), 1);
    EXPECT_EQ(window->log.results[0].status().code(), 0);
    EXPECT_EQ(window->log.deltas, kWindows) << "each sees what all have done";
    EXPECT_EQ(window->log.chunks, windows[0]->log.chunks);
  }
  for (const auto& call : calls) EXPECT_EQ(ReadFrames(call->Receive()).code, 0);
}

}  // namespace
}  // namespace latticed::testing
