// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server with --http and --admin on free ports, and a folder for files. ServeScene adds a scene.
#ifndef LATTICED_TESTS_SERVER_WEB_WEB_FIXTURE_H_
#define LATTICED_TESTS_SERVER_WEB_WEB_FIXTURE_H_

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "tests/server/support/server_test.h"
#include "tests/server/web/web_client.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {

class WebTest : public StreamTest {
 protected:
  void SetUp() override {
    folder_.Write("web/index.html", "<!doctype html>viewer");
    options_.backend = "cpu";
    options_.threads = 2;
    options_.log_level = "off";
    options_.node = "test-node";
    options_.heartbeat_interval = kHeartbeat;
    options_.drain_delay = absl::ZeroDuration();
    options_.http = "127.0.0.1:0";
    options_.admin = "127.0.0.1:0";
    options_.web_root = folder_.Path("web");
  }
  void TearDown() override { server_.reset(); }

  void Serve() { ServerTest::StartServer(options_); }
  void ServeScene(int cells = 8) {
    ASSERT_NO_FATAL_FAILURE(Serve());
    ASSERT_NO_FATAL_FAILURE(CreateScene(cells));
  }
  // Calls then need the token "secret-edit".
  void AskForTokens() {
    options_.token_file =
        folder_.Write("tokens", fmt::format("{} edit editor\n", Sha256Hex("secret-edit")));
  }

  // Memory for six connections of 2.5 MiB.
  static constexpr uint64_t kSixConnections = uint64_t{16} << 20;
  // Six clients that use all six connections.
  std::vector<std::unique_ptr<WebClient>> TakeSixPlaces() const {
    std::vector<std::unique_ptr<WebClient>> clients;
    for (int i = 0; i < 6; ++i) {
      clients.push_back(std::make_unique<WebClient>(http()));
      EXPECT_EQ(clients.back()->Get("/").status, 200) << i;
    }
    return clients;
  }
  // Calls Watch. Returns whether the reply has begun.
  bool StartsWatch(WebClient& client, const v1::WatchRequest& request,
                   WebFields fields = {}) const {
    fields["content-type"] = "application/grpc-web+proto";
    client.Send("POST", "/latticed.v1.SceneService/Watch", fields,
                Frame(request.SerializeAsString()));
    return !client.ReceiveBytes(1).empty();
  }
  std::string http() const { return server_->http_address(); }
  WebAnswer Get(const std::string& target, const WebFields& fields = {}) const {
    return WebClient(http()).Get(target, fields);
  }
  WebAnswer Admin(const std::string& target, const std::string& method = "GET") const {
    return WebClient(server_->admin_address()).Ask(method, target);
  }
  using StreamTest::Call;
  GrpcWebAnswer Call(const std::string& rpc, const std::string& body,
                     const WebFields& fields = {}) const {
    WebClient client(http());
    return CallGrpcWeb(client, rpc, body, fields);
  }

  TemporaryFolder folder_;
  Options options_;
};

// The same over TLS, with a certificate for "localhost".
class WebTlsTest : public WebTest {
 protected:
  void SetUp() override {
    WebTest::SetUp();
    ASSERT_TRUE(MakeCertificate("server"));
    options_.tls_cert = options_.tls_key = folder_.Path("server.pem");
  }

  void ServeScene() {
    ASSERT_NO_FATAL_FAILURE(Serve());
    Reach(GrpcChannel("server.crt"));
    ASSERT_NO_FATAL_FAILURE(CreateScene(8));
  }

  // A channel of its own that trusts the certificate in this file.
  std::shared_ptr<grpc::Channel> GrpcChannel(const std::string& issuer) const {
    grpc::ChannelArguments arguments;
    arguments.SetSslTargetNameOverride("localhost");
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    const auto credentials = grpc::SslCredentials({.pem_root_certs = folder_.Read(issuer)});
    return grpc::CreateCustomChannel(server_->address(), credentials, arguments);
  }
  // Whether a new connection of gRPC answers to who trusts this certificate.
  bool GrpcTakes(const std::string& issuer) const {
    grpc::ClientContext context;
    v1::ServerInfo info;
    return v1::ServerService::NewStub(GrpcChannel(issuer))->GetServerInfo(&context, {}, &info).ok();
  }

  // Makes NAME.crt, a self-signed certificate, and NAME.pem, its key and the certificate.
  bool MakeCertificate(const std::string& name) const {
    const std::string command = fmt::format(
        "cd '{0}' && openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost "
        "-keyout {1}.pem -out {1}.crt >/dev/null 2>&1 && cat {1}.crt >>{1}.pem",
        folder_.path().string(), name);
    return std::system(command.c_str()) == 0;
  }
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_WEB_WEB_FIXTURE_H_
