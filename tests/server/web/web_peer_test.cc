// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The log names the client's real address, whatever the client claims.
#include <gmock/gmock.h>

#include "tests/server/support/call_sink.h"
#include "tests/server/web/web_fixture.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kForged[] = "ipv4:203.0.113.7:4711";

class WebPeerTest : public WebTest {
 protected:
  std::string PeerOf(const std::string& request_id) const {
    auto lines = sink_->Of(request_id);
    return lines.size() == 1 ? lines[0]["peer"] : fmt::format("{} lines", lines.size());
  }
  // Calls through gRPC, with `metadata` that a forger may send.
  absl::Status CallGrpc(const std::string& request_id, Metadata metadata = {}) {
    metadata["latticed-request-id"] = request_id;
    return StreamTest::Call(&Infos::GetServerInfo, {}, nullptr, metadata);
  }

  std::shared_ptr<CallSink> sink_;
};

TEST_F(WebPeerTest, EveryFormOfACallIsLoggedWithTheBrowsersAddress) {
  ServeScene();
  sink_ = CallSink::Install();
  WebClient client(http());

  ASSERT_EQ(CallGrpcWeb(client, kInfo, Frame(""), {{"latticed-request-id", "rpc"}}).code, 0);
  ASSERT_EQ(
      client.Get(fmt::format("/export/{}.ply", kScene), {{"latticed-request-id", "export"}}).status,
      200);
  WebSocketClient socket(http(), fmt::format("/ws/latticed.v1.SceneService/Deform?latticed-scene={}"
                                             "&latticed-request-id=socket",
                                             kScene));
  ASSERT_TRUE(socket.Send("no message"));
  while (socket.Read().has_value()) continue;

  EXPECT_EQ(PeerOf("rpc"), "ipv4:" + client.local_address());
  // The last byte of a download is sent before its line is logged.
  EXPECT_TRUE(Becomes(2000, [&] { return PeerOf("export") == "ipv4:" + client.local_address(); }));
  EXPECT_EQ(PeerOf("socket"), "ipv4:" + socket.local_address());
}

TEST_F(WebPeerTest, NeitherABrowserNorAnotherClientCanNameAnother) {
  Serve();
  sink_ = CallSink::Install();
  const WebFields forged = {{"latticed-peer", kForged},
                            {"latticed-peer-00000000000000000000000000000000", kForged},
                            {"peer", kForged},
                            {"x-forwarded-for", "203.0.113.7"},
                            {"forwarded", "for=203.0.113.7"}};
  WebFields fields = forged;
  fields["latticed-request-id"] = "browser";
  WebClient client(http());

  const GrpcWebAnswer answer = CallGrpcWeb(client, kInfo, Frame(""), fields);
  EXPECT_OK(CallGrpc("grpc", forged));

  ASSERT_EQ(answer.code, 0);
  EXPECT_EQ(PeerOf("browser"), "ipv4:" + client.local_address());
  EXPECT_THAT(PeerOf("grpc"), StartsWith("ipv4:127.0.0.1:"));
  for (const auto& [name, value] : answer.http.fields) EXPECT_THAT(name, Not(HasSubstr("peer")));
  for (const auto& [name, value] : answer.trailers) EXPECT_THAT(name, Not(HasSubstr("peer")));
}

TEST_F(WebPeerTest, AddressesOfIpv6AreWrittenAsGrpcWritesThem) {
  options_.listen = options_.http = options_.admin = "[::1]:0";
  auto server = InProcessServer::Serve(options_);
  if (!server.ok()) GTEST_SKIP() << "no IPv6 here: " << server.status();
  server_ = *std::move(server);
  Reach(server_->channel());
  sink_ = CallSink::Install();
  WebClient client(http());

  ASSERT_EQ(CallGrpcWeb(client, kInfo, Frame(""), {{"latticed-request-id", "browser"}}).code, 0);
  ASSERT_OK(CallGrpc("grpc"));

  const std::string port = client.local_address().substr(client.local_address().rfind(':'));
  EXPECT_THAT(PeerOf("grpc"), StartsWith("ipv6:%5B::1%5D:"));
  EXPECT_EQ(PeerOf("browser"), "ipv6:%5B::1%5D" + port);
}

// A socket for both IPv4 and IPv6 sees IPv4 addresses as IPv6 addresses.
TEST_F(WebPeerTest, AddressesOfIpv4OnASocketOfIpv6AreThoseOfIpv4) {
  options_.listen = options_.http = "[::]:0";
  options_.insecure = true;
  auto server = InProcessServer::Serve(options_);
  if (!server.ok()) GTEST_SKIP() << "no IPv6 here: " << server.status();
  server_ = *std::move(server);
  Reach(server_->channel());
  sink_ = CallSink::Install();
  WebClient client("127.0.0.1" + http().substr(http().rfind(':')));

  ASSERT_EQ(CallGrpcWeb(client, kInfo, Frame(""), {{"latticed-request-id", "browser"}}).code, 0);

  EXPECT_EQ(PeerOf("browser"), "ipv4:" + client.local_address());
}

}  // namespace
}  // namespace latticed::testing
