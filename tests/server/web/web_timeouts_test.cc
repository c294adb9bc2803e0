// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Clients that leave a connection waiting. Each test shortens one timeout and waits for the end of the
// connection, without its own clock.
#include <gmock/gmock.h>

#include "tests/server/web/web_fixture.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

constexpr auto kShort = std::chrono::milliseconds(100);
// The handshake of a WebSocket, with the scene's id for {}.
constexpr char kUpgrade[] =
    "GET /ws/latticed.v1.SceneService/Deform?latticed-scene={} HTTP/1.1\r\nhost: localhost\r\n"
    "connection: upgrade\r\nupgrade: websocket\r\nsec-websocket-version: 13\r\n"
    "sec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";

class WebTimeoutsTest : public WebTest {
 protected:
  // Waits at most about 20 seconds.
  static bool Becomes(const std::function<bool()>& condition) {
    return testing::Becomes(2'000, condition);
  }
  // Whether a call of `rpc` has finished.
  bool Ended(const std::string& rpc) const {
    return server_->metrics().find(
               fmt::format("latticed_rpc_finished_total{{method=\"{}\"", rpc)) != std::string::npos;
  }
};

TEST_F(WebTimeoutsTest, AHeadThatDoesNotEnd) {
  options_.http_timeouts.head = kShort;
  Serve();
  WebClient idle(http()), slow(http());

  slow.SendBytes("GET / HTTP/1.1\r\nhost: loc");

  EXPECT_EQ(slow.ReceiveBytes(1), "");
  EXPECT_EQ(idle.Get("/").status, 200) << "it has sent nothing, and that may take longer";
}

TEST_F(WebTimeoutsTest, AnIdleConnection) {
  options_.http_timeouts.idle = kShort;
  Serve();
  WebClient silent(http());
  std::unique_ptr<WebClient> kept;
  // Repeats, because the machine may stall between the two steps for longer than the timeout.
  ASSERT_TRUE(Becomes([&] {
    kept = std::make_unique<WebClient>(http());
    return kept->Get("/").status == 200;
  }));

  EXPECT_EQ(kept->ReceiveBytes(1), "");
  EXPECT_EQ(silent.ReceiveBytes(1), "");
}

// The stream is sent nothing while an idle connection times out.
TEST_F(WebTimeoutsTest, AStreamIsNotIdle) {
  options_.http_timeouts.idle = kShort;
  ServeScene();
  std::unique_ptr<WebClient> watching;
  ASSERT_TRUE(Becomes([&] {
    watching = std::make_unique<WebClient>(http());
    return StartsWatch(*watching, Watch());
  }));

  EXPECT_EQ(WebClient(http()).ReceiveBytes(1), "");

  // The server may take a moment to notice the end of a watch that failed above.
  EXPECT_TRUE(Becomes([&] { return Metric("latticed_watchers") == 1; }));
}

TEST_F(WebTimeoutsTest, ABodyThatStallsEndsItsCall) {
  options_.http_timeouts.body = kShort;
  Serve();
  v1::UploadMeshRequest request;
  request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
  request.mutable_header()->set_total_bytes(1'000);
  WebClient client(http());

  client.SendBytes(
      "POST /latticed.v1.MeshService/UploadMesh HTTP/1.1\r\nhost: localhost\r\n"
      "content-type: application/grpc-web+proto\r\ncontent-length: 1000\r\n\r\n" +
      Frame(request.SerializeAsString()));

  while (!client.ReceiveBytes(1'000).empty()) continue;
  EXPECT_TRUE(Becomes([&] { return Ended("MeshService/UploadMesh"); }));
}

// The connection has ended when another client gets its place.
TEST_F(WebTimeoutsTest, AnAnswerThatIsNotRead) {
  constexpr size_t kBytes = size_t{64} << 20;  // more than the sockets buffer
  options_.http_timeouts.write = kShort;
  options_.transport_memory_bytes = kSixConnections;
  Serve();
  folder_.Write("web/large.bin", std::string(kBytes, 'x'));
  const auto clients = TakeSixPlaces();

  clients[0]->Send("GET", "/large.bin", {}, "");

  EXPECT_TRUE(Becomes([&] { return Get("/").status == 200; }));
  EXPECT_EQ(clients[0]->Receive().status, 0) << "not whole";
  EXPECT_EQ(clients[1]->Get("/").status, 200);
}

TEST_F(WebTimeoutsTest, AClientThatSendsOnAfterItsAnswer) {
  options_.http_timeouts.linger = kShort;
  Serve();
  WebClient client(http());
  client.SendBytes(
      "POST /latticed.v1.MeshService/UploadMesh HTTP/1.1\r\nhost: localhost\r\n"
      "content-type: text/plain\r\ncontent-length: 1000000\r\n\r\n");
  ASSERT_EQ(client.Receive().status, 415);

  EXPECT_TRUE(Becomes([&] { return !client.SendBytes("x"); }));
}

TEST_F(WebTimeoutsTest, AWebSocketThatAnswersNoPing) {
  options_.http_timeouts.silence = kShort;
  ServeScene();
  WebClient client(http());

  client.SendBytes(fmt::format(kUpgrade, kScene));
  std::string bytes;
  for (std::string more; !(more = client.ReceiveBytes(1'000)).empty();) bytes += more;

  EXPECT_THAT(bytes, HasSubstr("101 Switching Protocols"));
  EXPECT_THAT(bytes, HasSubstr(std::string("\x89\x00", 2))) << "it was pinged";
  EXPECT_TRUE(Becomes([&] { return Ended("SceneService/Deform"); }));
}

// The first message ends the call, so the server closes, maybe while it answers the ping and then finds a frame without
// a mask. Then nothing but the timeout ends the connection. Of some clients one or the other meets this.
TEST_F(WebTimeoutsTest, AWebSocketWhoseCloseMeetsAnInvalidFrame) {
  constexpr int kClients = 200;
  const std::string heartbeat("\x82\x82\0\0\0\0\x22\0", 8), ping("\x89\x80\0\0\0\0", 6),
      invalid("\x82\x01x");
  options_.http_timeouts.linger = kShort;
  ServeScene();
  std::vector<std::unique_ptr<WebClient>> clients;

  for (int i = 0; i < kClients; ++i) {
    clients.push_back(std::make_unique<WebClient>(http()));
    clients.back()->SendBytes(fmt::format(kUpgrade, kScene));
    for (std::string head; !head.ends_with("\r\n\r\n");) head += clients.back()->ReceiveBytes(1);
    clients.back()->SendBytes(heartbeat + ping + invalid);
  }

  EXPECT_TRUE(Becomes([&] { return Metric("latticed_connections{port=\"http\"}") == 0; }));
}

TEST_F(WebTlsTest, AHandshakeThatDoesNotCome) {
  options_.http_timeouts.head = kShort;
  Serve();

  EXPECT_EQ(WebClient(http()).ReceiveBytes(1), "");
}

}  // namespace
}  // namespace latticed::testing
