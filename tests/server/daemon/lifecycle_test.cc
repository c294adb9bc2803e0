// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Start, health, reflection, TLS, drain and stop, and the daemon as a process.
#include <signal.h>

#include <cstdlib>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "tests/server/daemon/daemon_process.h"
#include "tests/server/support/raw_call.h"
#include "tests/server/support/server_test.h"
#include "tests/server/support/unfinished_calls.h"
#include "tests/support/becomes.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

using LifecycleTest = SmallServerTest;

TEST_F(LifecycleTest, HealthKnowsEveryServiceByName) {
  for (const char* service : kHealthNames) {
    EXPECT_EQ(Health(server_->channel(), service), "1") << service;
  }
  EXPECT_EQ(Health(server_->channel(), "latticed.v1.Nothing"), "code 5");
}

TEST_F(LifecycleTest, ARunningUploadIsCancelledAtTheDeadlineOfADrain) {
  StartServer({.drain_delay = absl::ZeroDuration(), .drain_timeout = absl::Milliseconds(100)});
  grpc::ClientContext context;
  v1::Mesh mesh;
  const auto writer = meshes_->UploadMesh(&context, &mesh);
  v1::UploadMeshRequest request;
  *request.mutable_header() = ObjHeader(CubeObj());
  ASSERT_TRUE(writer->Write(request));
  ASSERT_EQ(Health(server_->channel(), ""), "1");

  server_->Drain();

  EXPECT_FALSE(writer->Finish().ok());
}

TEST_F(LifecycleTest, StopsTwiceWithoutHarm) {
  Upload(CubeObj());

  server_->Stop();
  server_->Stop();

  EXPECT_THAT(Call(&Infos::GetServerInfo, {}), StatusIs(absl::StatusCode::kUnavailable));
}

TEST_F(LifecycleTest, TakenPortIsRefused) {
  Options options = TestOptions();
  options.listen = server_->address();

  EXPECT_THAT(InProcessServer::Serve(options),
              StatusIs(absl::StatusCode::kUnavailable, HasSubstr(options.listen)));
}

TEST_F(LifecycleTest, ServesOnAUnixSocket) {
  Options options = TestOptions();
  const TemporaryFolder folder;
  options.listen = "unix:" + folder.Path("latticed.socket");
  const auto server = InProcessServer::Serve(options);
  ASSERT_OK(server);
  Reach((*server)->channel());

  EXPECT_EQ((*server)->address(), options.listen);
  EXPECT_OK(Call(&Infos::GetServerInfo, {}));
}

TEST(StartTest, CudaByNameSaysWhyNot) {
  Options options = TestOptions();
  options.backend = "cuda";

  const auto server = InProcessServer::Start(options);

  if (server.ok()) GTEST_SKIP() << "this build has CUDA, and there is a device";
  EXPECT_THAT(server.status().message(), HasSubstr("--backend cuda"));
}

TEST(StartTest, UnreadableKeyIsRefused) {
  Options options = TestOptions();
  options.tls_cert = "/no/such/cert.pem";
  options.tls_key = "/no/such/key.pem";

  EXPECT_THAT(InProcessServer::Start(options),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--tls-cert")));
}

TEST(StartTest, AFolderIsNoTokenFile) {
  const TemporaryFolder folder;
  Options options = TestOptions();
  options.token_file = folder.path().string();

  EXPECT_THAT(InProcessServer::Start(options),
              StatusIs(absl::StatusCode::kInvalidArgument,
                       AllOf(HasSubstr("--token-file"), HasSubstr("it is a folder"))));
}

TEST_F(LifecycleTest, ServesOverTlsOnly) {
  const TemporaryFolder folder;
  const std::string cert = folder.Path("cert.pem"), key = folder.Path("key.pem");
  const std::string command = fmt::format(
      "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost "
      "-addext subjectAltName=DNS:localhost -keyout {} -out {} >/dev/null 2>&1",
      key, cert);
  if (std::system(command.c_str()) != 0) GTEST_SKIP() << "the openssl program is not there";
  Options options = TestOptions();
  options.tls_cert = cert;
  options.tls_key = key;
  StartServer(options);
  EXPECT_THAT(Call(&Infos::GetServerInfo, {}), StatusIs(absl::StatusCode::kUnavailable));

  grpc::SslCredentialsOptions tls{.pem_root_certs = folder.Read("cert.pem")};
  grpc::ChannelArguments arguments;
  arguments.SetSslTargetNameOverride("localhost");
  Reach(grpc::CreateCustomChannel(server_->address(), grpc::SslCredentials(tls), arguments));
  EXPECT_OK(Call(&Infos::GetServerInfo, {}));
}

TEST(DaemonTest, BothSignalsDrainAndExitZero) {
  for (const int signal : {SIGTERM, SIGINT}) {
    Daemon daemon(
        {"--listen=127.0.0.1:0", "--backend=cpu", "--drain-delay=0s", "--log-format=json"});
    EXPECT_THAT(daemon.ReadLine(), HasSubstr("--data-dir"));
    EXPECT_THAT(daemon.ReadLine(), HasSubstr("\"message\":\"serving\""));

    daemon.Signal(signal);

    EXPECT_THAT(daemon.ReadLine(), HasSubstr("\"message\":\"draining\""));
    EXPECT_THAT(daemon.ReadLine(), HasSubstr("\"message\":\"stopped\""));
    EXPECT_EQ(daemon.Wait(), 0);
  }
}

TEST(DaemonTest, TakesNoMoreConnectionsThanItMayOpenFiles) {
  constexpr rlim_t kMostFiles = 64;
  Daemon daemon({"--listen=127.0.0.1:0", "--backend=cpu", "--threads=1", "--drain-delay=0s"},
                kMostFiles);
  const std::string address = daemon.Address();
  std::vector<std::unique_ptr<UnfinishedCalls>> connections;
  for (rlim_t i = 0; i < kMostFiles; ++i) {
    connections.push_back(std::make_unique<UnfinishedCalls>(address, "", 0, 0));
  }
  EXPECT_FALSE(connections.back()->Run([] { return false; })) << "closed at once, not left to wait";
  EXPECT_LT(daemon.OpenFiles(), kMostFiles);

  connections.clear();
  {
    const auto stub = v1::ServerService::NewStub(
        grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
    grpc::ClientContext context;
    context.set_wait_for_ready(true);
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    v1::ServerInfo info;
    EXPECT_TRUE(stub->GetServerInfo(&context, {}, &info).ok());
  }

  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
}

TEST(DaemonTest, HangupReadsTokensAndLogLevelAgain) {
  const TemporaryFolder folder;
  const auto line = [](const std::string& token) {
    return fmt::format("{} edit {}\n", Sha256Hex(token), token);
  };
  const std::string tokens = folder.Write("tokens", line("first"));
  const std::string config = folder.Write("latticed.toml", "log-level = \"info\"\n");
  Daemon daemon({"--listen=127.0.0.1:0", "--backend=cpu", "--threads=1", "--drain-delay=0s",
                 "--token-file=" + tokens, "--config=" + config});
  const auto channel = grpc::CreateChannel(daemon.Address(), grpc::InsecureChannelCredentials());
  const auto code = [&](const std::string& token) {
    return RawCall(channel, "/latticed.v1.ServerService/GetServerInfo", "", nullptr,
                   "Bearer " + token)
        .error_code();
  };
  ASSERT_EQ(code("first"), grpc::StatusCode::OK);
  ASSERT_EQ(code("second"), grpc::StatusCode::UNAUTHENTICATED);

  folder.Write("tokens", line("second"));
  folder.Write("latticed.toml", "log-level = \"debug\"\n");
  daemon.Signal(SIGHUP);
  EXPECT_THAT(daemon.ReadLine(), HasSubstr("UNAUTHENTICATED"));
  EXPECT_THAT(daemon.ReadLine(), HasSubstr("read again"));

  EXPECT_EQ(code("first"), grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_THAT(daemon.ReadLine(), HasSubstr("UNAUTHENTICATED"));
  EXPECT_EQ(code("second"), grpc::StatusCode::OK);
  EXPECT_THAT(daemon.ReadLine(), HasSubstr("debug"));

  folder.Write("tokens", "nonsense\n");
  daemon.Signal(SIGHUP);
  EXPECT_THAT(daemon.ReadLine(), HasSubstr("token file, line 1"));
  EXPECT_EQ(code("second"), grpc::StatusCode::OK) << "the tokens stay";
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
}

TEST(DaemonTest, AnOpenPortIsLoggedWithTheProxy) {
  Daemon daemon({"--listen=0.0.0.0:0", "--insecure", "--backend=cpu", "--drain-delay=0s"});

  EXPECT_THAT(daemon.ReadLine(), HasSubstr("docker/haproxy.cfg"));
  EXPECT_THAT(daemon.ReadLine(), HasSubstr("--data-dir"));
  EXPECT_THAT(daemon.ReadLine(), HasSubstr("serving"));
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
}

TEST(DaemonTest, UsageErrorsExitTwoInOneSentence) {
  Daemon daemon({"--listen=0.0.0.0:0"});

  EXPECT_THAT(daemon.ReadLine(), HasSubstr("latticed: --listen"));
  EXPECT_EQ(daemon.ReadLine(), "");
  EXPECT_EQ(daemon.Wait(), 2);
}

}  // namespace
}  // namespace latticed::testing
