// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A server with --http and --admin on free ports, one mesh and one scene, and a folder for files.
#ifndef LATTICED_TESTS_SERVER_WEB_WEB_FIXTURE_H_
#define LATTICED_TESTS_SERVER_WEB_WEB_FIXTURE_H_

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "tests/server/stream_support.h"
#include "tests/server/web/web_client.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {

class WebTest : public StreamTest {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::path(::testing::TempDir()) / fmt::format("latticed-web-{}", getpid());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_ / "web");
    Write("web/index.html", "<!doctype html>viewer");
    options_.backend = "cpu";
    options_.threads = 2;
    options_.log_level = "off";
    options_.node = "test-node";
    options_.heartbeat_interval = kHeartbeat;
    options_.drain_delay = absl::ZeroDuration();
    options_.http = "127.0.0.1:0";
    options_.admin = "127.0.0.1:0";
    options_.web_root = (folder_ / "web").string();
  }
  void TearDown() override {
    server_.reset();
    std::filesystem::remove_all(folder_);
  }

  void Serve() {
    server_.reset();
    auto server = InProcessServer::Start(options_);
    ASSERT_OK(server);
    server_ = *std::move(server);
    meshes_ = v1::MeshService::NewStub(server_->channel());
    scenes_ = v1::SceneService::NewStub(server_->channel());
  }
  void ServeScene(int cells = 8) {
    ASSERT_NO_FATAL_FAILURE(Serve());
    ASSERT_NO_FATAL_FAILURE(CreateScene(cells));
  }
  // One token, "secret-edit".
  void AskForTokens() {
    Write("tokens", fmt::format("{} edit editor\n", Sha256Hex("secret-edit")));
    options_.token_file = (folder_ / "tokens").string();
  }

  std::string http() const { return server_->http_address(); }
  WebAnswer Get(const std::string& target, const WebFields& fields = {}) const {
    return WebClient(http()).Get(target, fields);
  }
  WebAnswer Admin(const std::string& target, const std::string& method = "GET") const {
    return WebClient(server_->admin_address()).Ask(method, target);
  }
  GrpcWebAnswer Call(const std::string& rpc, const std::string& body,
                     const WebFields& fields = {}) const {
    WebClient client(http());
    return CallGrpcWeb(client, rpc, body, fields);
  }

  void Write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::string Read(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  std::filesystem::path folder_;
  Options options_;
};

// The same over TLS, with a certificate of "localhost".
class WebTlsTest : public WebTest {
 protected:
  void SetUp() override {
    WebTest::SetUp();
    ASSERT_TRUE(MakeCertificate("server"));
    options_.tls_cert = Path("server.pem");
    options_.tls_key = Path("server.pem");
  }

  void ServeScene() {
    ASSERT_NO_FATAL_FAILURE(Serve());
    grpc::ChannelArguments arguments;
    arguments.SetSslTargetNameOverride("localhost");
    const auto credentials = grpc::SslCredentials({.pem_root_certs = Read("server.crt")});
    const auto channel = grpc::CreateCustomChannel(server_->address(), credentials, arguments);
    meshes_ = v1::MeshService::NewStub(channel);
    scenes_ = v1::SceneService::NewStub(channel);
    ASSERT_NO_FATAL_FAILURE(CreateScene(8));
  }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  // NAME.pem: a key, and a certificate signed by itself.
  bool MakeCertificate(const std::string& name) const {
    const std::string command = fmt::format(
        "cd '{0}' && openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost "
        "-keyout {1}.pem -out {1}.crt >/dev/null 2>&1 && cat {1}.crt >>{1}.pem",
        folder_.string(), name);
    return std::system(command.c_str()) == 0;
  }
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_WEB_WEB_FIXTURE_H_
