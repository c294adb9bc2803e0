// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Connections: TLS, limits, bytes that are no HTTP, and how connections end.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/server/web/web_fixture.h"
#include "tests/support/becomes.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST_F(WebTlsTest, ServesOverTls) {
  Serve();
  WebClient client(http(), folder_.Path("server.crt"));

  EXPECT_EQ(client.Get("/").status, 200);
  EXPECT_EQ(CallGrpcWeb(client, kInfo, Frame("")).code, 0);
  EXPECT_EQ(CallGrpcWeb(client, kInfo, Frame(""), {{"origin", "https://localhost"}}).code, 0);
  EXPECT_EQ(CallGrpcWeb(client, kInfo, Frame(""), {{"origin", "http://localhost"}}).http.status,
            403)
      << "a page without TLS is another site";
  EXPECT_EQ(Get("/").status, 0) << "and nothing without TLS";
  EXPECT_EQ(Admin("/healthz").status, 200) << "the operator's port has none";
}

TEST_F(WebTlsTest, AsksForAClientCertificate) {
  ASSERT_TRUE(MakeCertificate("client"));
  options_.tls_client_ca = folder_.Path("client.crt");
  Serve();

  EXPECT_EQ(WebClient(http(), folder_.Path("server.crt")).Get("/").status, 0);
  EXPECT_EQ(
      WebClient(http(), folder_.Path("server.crt"), folder_.Path("client.pem")).Get("/").status,
      200);
}

TEST_F(WebTlsTest, NewConnectionsUseNewCertificates) {
  ASSERT_TRUE(MakeCertificate("next"));
  Serve();
  WebClient open(http(), folder_.Path("server.crt"));
  ASSERT_EQ(open.Get("/").status, 200);
  ASSERT_TRUE(GrpcTakes("server.crt"));

  folder_.Write("server.pem", folder_.Read("next.pem"));
  ASSERT_OK(server_->Reload(options_));

  EXPECT_EQ(WebClient(http(), folder_.Path("next.crt")).Get("/").status, 200);
  EXPECT_EQ(WebClient(http(), folder_.Path("server.crt")).Get("/").status, 0);
  EXPECT_EQ(open.Get("/").status, 200) << "an open connection stays";
  EXPECT_TRUE(Becomes(300, [&] { return GrpcTakes("next.crt"); }));
}

TEST_F(WebTlsTest, FilesThatDoNotFitChangeNothing) {
  ASSERT_TRUE(MakeCertificate("next"));
  options_.tls_cert = folder_.Path("server.crt");
  Serve();
  const auto refused = [this](const std::string& why) {
    EXPECT_THAT(server_->Reload(options_),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(why)));
  };

  folder_.Write("server.pem", folder_.Read("next.pem"));
  refused("--tls-key");
  std::filesystem::remove(folder_.Path("server.pem"));
  refused("No such file");
  std::filesystem::create_directory(folder_.Path("server.pem"));
  refused("it is a folder");

  EXPECT_TRUE(GrpcTakes("server.crt"));
  EXPECT_EQ(WebClient(http(), folder_.Path("server.crt")).Get("/").status, 200);
}

TEST_F(WebTest, TakenPortsAreRefusedByName) {
  Serve();
  Options options = options_;
  options.http = http();

  EXPECT_THAT(InProcessServer::Start(options),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("--http: cannot serve")));
  options.http = "";
  options.admin = server_->admin_address();
  EXPECT_THAT(InProcessServer::Start(options),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr("--admin: cannot serve")));
}

TEST_F(WebTest, NothingListensUnlessAsked) {
  options_.http = "";
  options_.admin = "";
  Serve();

  EXPECT_EQ(server_->http_address(), "");
  EXPECT_EQ(server_->admin_address(), "");
}

bool Has(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

TEST_F(WebTest, ConnectionsAboveTheLimitAreToldSo) {
  options_.transport_memory_bytes = kSixConnections;
  Serve();
  auto clients = TakeSixPlaces();

  const WebAnswer answer = Get("/");
  const WebAnswer after_body = WebClient(http()).Ask("POST", fmt::format("/{}", kInfo),
                                                     {{"content-type", "application/grpc-web"}},
                                                     std::string(size_t{4} << 20, 'x'));
  clients.pop_back();
  const bool free = testing::Becomes(2000, [this] { return Get("/").status == 200; });

  EXPECT_EQ(answer.status, 503);
  EXPECT_EQ(answer.fields.at("retry-after"), "1");
  EXPECT_EQ(answer.fields.at("connection"), "close");
  EXPECT_THAT(answer.body, HasSubstr("reached its limit of connections"));
  EXPECT_EQ(after_body.status, 503) << "it reaches a client that still sends";
  EXPECT_TRUE(free) << "one has left";
  const std::string metrics = Admin("/metrics").body;
  EXPECT_TRUE(Has(metrics, "latticed_connections_limit{port=\"http\"} 6\n"));
  EXPECT_TRUE(Has(metrics, "latticed_connections_refused_total{port=\"http\"} "));
  EXPECT_FALSE(Has(metrics, "latticed_connections_refused_total{port=\"http\"} 0\n"));
  EXPECT_EQ(clients[0]->Get("/").status, 200);
}

// At most 64 connections above the limit are answered. Further ones are closed.
TEST_F(WebTest, ConnectionsFarAboveTheLimitAreClosed) {
  options_.transport_memory_bytes = kSixConnections;
  options_.http_timeouts.head = std::chrono::seconds(60);
  Serve();
  std::vector<std::unique_ptr<WebClient>> clients;
  for (int i = 0; i < 6 + 64; ++i) {
    clients.push_back(std::make_unique<WebClient>(http()));
    ASSERT_TRUE(clients.back()->SendBytes("GET / HTTP/1.1\r\n"));
  }

  const WebAnswer answer = Get("/");
  for (const auto& client : clients) client->SendBytes("host: localhost\r\n\r\n");

  EXPECT_EQ(answer.status, 0);
  for (size_t i = 0; i < clients.size(); ++i) {
    EXPECT_EQ(clients[i]->Receive().status, i < 6 ? 200 : 503) << i;
  }
}

TEST_F(WebTest, WhatIsNoHttpIsRefused) {
  Serve();

  WebClient garbage(http());
  garbage.SendBytes("\x16\x03\x01 hello\r\n\r\n");
  WebClient large(http());
  large.SendBytes("GET / HTTP/1.1\r\nhost: localhost\r\nx: " + std::string(20'000, 'x') +
                  "\r\n\r\n");
  WebClient hostless(http());
  hostless.SendBytes("GET / HTTP/1.1\r\n\r\n");

  EXPECT_EQ(garbage.Receive().status, 400);
  EXPECT_EQ(large.Receive().status, 431);
  EXPECT_EQ(hostless.Receive().status, 403);
}

TEST_F(WebTest, HeadsThatAProxyCouldReadInAnotherWayAreRefused) {
  Serve();
  const std::string post = fmt::format(
      "POST /{} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/grpc-web\r\n", kInfo);
  const std::string next = "GET /docs/ HTTP/1.1\r\nhost: localhost\r\n\r\n";

  for (const std::string& head :
       {post + "host: other\r\ncontent-length: 5\r\n\r\n",
        post + "transfer-encoding: xchunked\r\n\r\n",
        post + "transfer-encoding: gzip, chunked\r\n\r\n",
        post + "transfer-encoding: chunked\r\ntransfer-encoding: chunked\r\n\r\n",
        post + "transfer-encoding: chunked\r\ncontent-length: 5\r\n\r\n",
        post + "content-length: 5\r\ncontent-length: 6\r\n\r\n"}) {
    WebClient client(http());
    client.SendBytes(head + next);
    EXPECT_EQ(client.Receive().status, 400) << head;
    EXPECT_EQ(client.ReceiveBytes(1), "") << "a second answer to " << head;
  }
}

TEST_F(WebTest, RequestsMayBeSentBeforeTheirTurn) {
  Serve();
  WebClient client(http());

  client.SendBytes(
      "GET / HTTP/1.1\r\nhost: localhost\r\n\r\nGET /no HTTP/1.1\r\nhost: localhost\r\n\r\n"
      "GET / HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n");

  EXPECT_EQ(client.Receive().status, 200);
  EXPECT_EQ(client.Receive().status, 404);
  const WebAnswer last = client.Receive();
  EXPECT_EQ(last.status, 200);
  EXPECT_EQ(last.fields.at("connection"), "close");
  EXPECT_EQ(client.ReceiveBytes(1), "") << "closed as asked";
}

TEST_F(WebTest, ABodyMayComeInPiecesAndAfterAWord) {
  Serve();
  WebClient client(http());

  client.SendBytes(
      fmt::format("POST /{} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/grpc-web\r\n"
                  "transfer-encoding: chunked\r\nexpect: 100-continue\r\n\r\n",
                  kInfo));
  EXPECT_THAT(client.ReceiveBytes(25), StartsWith("HTTP/1.1 100 Continue"));
  client.SendBytes(std::string("2\r\n\0\0\r\n", 7));
  client.SendBytes(std::string("3\r\n\0\0\0\r\n0\r\n\r\n", 13));

  EXPECT_EQ(ReadFrames(client.Receive()).code, 0);
}

// The answer reaches a client that still sends.
TEST_F(WebTest, ARefusalInTheMiddleOfABodyIsRead) {
  Serve();
  WebClient client(http());

  client.Send("POST", fmt::format("/{}", kInfo), {{"content-type", "text/plain"}},
              std::string(size_t{4} << 20, 'x'));

  const WebAnswer answer = client.Receive();
  EXPECT_EQ(answer.status, 415);
  EXPECT_EQ(answer.fields.at("connection"), "close");
}

TEST_F(WebTlsTest, ARefusalInTheMiddleOfABodyIsReadOverTls) {
  options_.max_mesh_bytes = uint64_t{1} << 20;
  Serve();
  v1::UploadMeshRequest request;
  request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
  request.mutable_header()->set_total_bytes(uint64_t{4} << 20);
  std::string body = Frame(request.SerializeAsString());
  request.set_data(std::string(size_t{512} << 10, '#'));
  for (int i = 0; i < 8; ++i) body += Frame(request.SerializeAsString());
  WebClient client(http(), folder_.Path("server.crt"));

  const GrpcWebAnswer answer = CallGrpcWeb(client, "latticed.v1.MeshService/UploadMesh", body);

  EXPECT_EQ(answer.http.status, 200);
  EXPECT_EQ(answer.http.fields.at("connection"), "close");
  EXPECT_EQ(answer.code, 3) << answer.trailers.at("grpc-message");
}

TEST_F(WebTest, OldHttpIsAnsweredToTheEndOfTheConnection) {
  Serve();
  WebClient client(http());

  client.SendBytes(fmt::format("POST /{} HTTP/1.0\r\nhost: localhost\r\ncontent-type: "
                               "application/grpc-web\r\ncontent-length: 5\r\n\r\n",
                               kInfo) +
                   Frame(""));

  const GrpcWebAnswer answer = ReadFrames(client.Receive());
  EXPECT_EQ(answer.http.fields.count("transfer-encoding"), 0);
  EXPECT_EQ(answer.code, 0);
}

TEST_F(WebTest, StoppingEndsWhatRuns) {
  ServeScene();
  WebClient watching(http());
  ASSERT_TRUE(StartsWatch(watching, Watch()));
  WebClient idle(http());
  ASSERT_EQ(idle.Get("/").status, 200);

  server_->Stop();
  server_->Stop();

  EXPECT_EQ(idle.ReceiveBytes(1), "");
}

}  // namespace
}  // namespace latticed::testing
