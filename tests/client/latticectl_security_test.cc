// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticectl against a server that asks for tokens or for client certificates: who is admitted, who is
// refused, and with which message.
#include <cstdlib>
#include <memory>

#include "core/base/sha256.h"
#include "fmt/format.h"
#include "tests/client/latticectl_fixture.h"
#include "tests/client/quiet_server.h"

namespace latticed::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class LatticectlSecurity : public LatticectlTest {
 protected:
  void Serve() {
    server_ = StartServer(options_);
    ASSERT_NE(server_, nullptr);
  }

  // The server's address, with the host name in its certificate.
  std::string Address() const {
    const std::string address = server_->address();
    return "localhost" + address.substr(address.rfind(':'));
  }

  RunResult At(std::vector<std::string> arguments, const std::vector<std::string>& more) const {
    arguments.insert(arguments.end(), {"--server", Address()});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Latticectl(arguments);
  }

  void WriteTokens() {
    std::string text;
    for (const std::string role : {"read", "edit"}) {
      text += fmt::format("{} {} {}er\n", Sha256Hex("secret-" + role), role, role);
    }
    ASSERT_OK(WriteFile(Path("tokens"), text));
    options_.token_file = Path("tokens");
  }

  // Writes NAME.key and NAME.pem, a self-signed certificate for localhost. False if openssl fails.
  bool MakeCertificate(const std::string& name) const {
    const std::string command = fmt::format(
        "cd '{}' && openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=localhost "
        "-addext subjectAltName=DNS:localhost -keyout {}.key -out {}.pem >/dev/null 2>&1",
        Path(""), name, name);
    return std::system(command.c_str()) == 0;
  }
  std::vector<std::string> Certificate(const std::string& name) const {
    return {"--tls-ca",          Path("server.pem"), "--tls-cert",
            Path(name + ".pem"), "--tls-key",        Path(name + ".key")};
  }

  Options options_ = QuietOptions();
  std::unique_ptr<InProcessServer> server_;
};

TEST_F(LatticectlSecurity, AReadTokenWatchesAndDoesNotEdit) {
  WriteTokens();
  Serve();
  const std::vector<std::string> read{"--token", "secret-read"}, edit{"--token", "secret-edit"};
  MustRun({"sample", "vase", "--resolution", "1", "-o", Path("vase.obj")});
  const RunResult made =
      At({"scene", "create", Path("vase.obj"), "--id", "scene-one", "--segments", "1"}, edit);
  ASSERT_EQ(made.code, 0) << made.err;

  const RunResult watched = At({"watch", "scene-one", "--updates", "1"}, read);
  EXPECT_EQ(watched.code, 0) << watched.err;
  EXPECT_THAT(watched.out, HasSubstr("revision 0"));

  const RunResult refused = At({"edit", "reset", "scene-one"}, read);
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("use a token with that role (PERMISSION_DENIED, request "));
  const RunResult unknown = At({"scene", "list"}, {"--token", "wrong"});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("--token"), HasSubstr("(UNAUTHENTICATED, request ")));
}

TEST_F(LatticectlSecurity, OnlyACertificateOfTheClientAuthorityIsLetIn) {
  for (const char* name : {"server", "client", "stranger"}) {
    if (!MakeCertificate(name)) GTEST_SKIP() << "the openssl program is not there";
  }
  options_.tls_cert = Path("server.pem");
  options_.tls_key = Path("server.key");
  options_.tls_client_ca = Path("client.pem");
  Serve();

  const RunResult accepted = At({"info"}, Certificate("client"));
  EXPECT_EQ(accepted.code, 0) << accepted.err;
  EXPECT_THAT(accepted.out, HasSubstr("cpu"));

  const std::vector<std::vector<std::string>> refused{
      {},                                // no TLS
      {"--tls-ca", Path("server.pem")},  // no certificate
      Certificate("stranger"),           // not signed by the client authority
      {"--tls-ca", Path("client.pem"),   // does not trust the server
       "--tls-cert", Path("client.pem"), "--tls-key", Path("client.key")}};
  for (const auto& flags : refused) {
    const RunResult result = At({"info", "--retry-for", "0"}, flags);
    EXPECT_EQ(result.code, 1) << ::testing::PrintToString(flags);
    EXPECT_THAT(result.err, HasSubstr("UNAVAILABLE"));
    EXPECT_EQ(result.out, "");
  }
  const RunResult half = At({"info"}, {"--tls-cert", Path("client.pem")});
  EXPECT_EQ(half.code, 2);
  EXPECT_THAT(half.err, HasSubstr("--tls-key"));
}

}  // namespace
}  // namespace latticed::client
