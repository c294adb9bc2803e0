// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/session/session.h"
#include "client/cpp/latticectl/command_line/value_types.h"

#include <CLI/CLI.hpp>
#include <string_view>
#include <utility>

#include "client/cpp/latticectl/command_line/failure.h"
#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/options.h"
#include "server/in_process.h"

namespace latticed::client {
namespace {

constexpr double kLongestRetry = 86'400;  // seconds: a day

absl::StatusOr<Connection> ToConnection(const SessionFlags& flags) {
  const bool tls = flags.tls || !flags.tls_ca.empty() || !flags.tls_cert.empty();
  Connection connection{.address = flags.server,
                        .token = flags.token,
                        .tls = tls,
                        .retry_for = absl::Seconds(flags.retry_for)};
  const std::pair<const std::string&, std::string&> files[] = {
      {flags.tls_ca, connection.tls_ca_pem},
      {flags.tls_cert, connection.tls_cert_pem},
      {flags.tls_key, connection.tls_key_pem}};
  for (const auto& [path, pem] : files) {
    if (path.empty()) continue;
    LATTICED_ASSIGN_OR_RETURN(pem, ReadFile(path));
  }
  return connection;
}

absl::Status Unavailable(std::string_view message, const std::string& advice) {
  return error::WithDetails(absl::UnavailableError(std::string(message)),
                            {.reason = "UNAVAILABLE", .metadata = {{kAdviceKey, advice}}});
}

}  // namespace

void AddSessionFlags(CLI::App& command, SessionFlags& flags, ServerChoice choice) {
  CLI::Option* server = command.add_option("--server", flags.server, "Address of a running server");
  if (choice == ServerChoice::kRequired) {
    flags.server = Options{}.listen;
    server->envname("LATTICED_SERVER")->capture_default_str();
  } else {
    server->description("Address of a running server; without it one runs in this process");
    CLI::Option* backend =
        command.add_option("--backend", flags.backend, "Backend of the server in this process")
            ->check(CLI::IsMember({"auto", "cpu", "cuda"}))
            ->capture_default_str();
    backend->excludes(server);
  }
  command.add_option("--token", flags.token, "Bearer token")->envname("LATTICED_TOKEN");
  command
      .add_option("--retry-for", flags.retry_for,
                  "Seconds for which it tries to reach a server that does not answer")
      ->check(CLI::Range(0.0, kLongestRetry))
      ->envname("LATTICED_RETRY_FOR")
      ->capture_default_str();
  command.add_flag("--tls", flags.tls, "Use TLS with the system's roots");
  command.add_option("--tls-ca", flags.tls_ca, "PEM file of roots to trust; implies TLS")
      ->type_name(kFileType);
  CLI::Option* cert =
      command.add_option("--tls-cert", flags.tls_cert, "PEM file of the client's certificate")
          ->type_name(kFileType);
  CLI::Option* key =
      command.add_option("--tls-key", flags.tls_key, "PEM file of its key")->type_name(kFileType);
  cert->needs(key);
  key->needs(cert);
}

Session::Session() = default;
Session::Session(Session&&) noexcept = default;
Session::~Session() {
  client_.reset();  // its channel must close before the server stops
}

absl::StatusOr<Session> Session::Open(const SessionFlags& flags, std::stop_token stop,
                                      ReachabilityObserver observer) {
  Session session;
  if (!flags.server.empty()) {
    LATTICED_ASSIGN_OR_RETURN(session.connection_, ToConnection(flags));
  } else {
    Options options;
    options.backend = flags.backend;
    options.log_level = "warn";  // the server logs to this program's standard error
    options.drain_delay = absl::ZeroDuration();
    options.max_connections = 1'000'000;  // only this program connects
    LATTICED_ASSIGN_OR_RETURN(session.server_, InProcessServer::Start(options));
    session.connection_.address = session.server_->address();
  }
  Connection observed = session.connection_;
  observed.observer = std::move(observer);
  session.client_ = Client::Connect(observed, std::move(stop));
  return session;
}

std::unique_ptr<Client> Session::NewClient() const {
  Connection connection = connection_;
  connection.alone = true;
  return Client::Connect(connection);
}

absl::Status Session::Explain(const absl::Status& status) const {
  if (!absl::IsUnavailable(status) || server_ != nullptr) return status;
  // If a server answered, for instance while it drains, its message says enough.
  if (error::DetailsOf(status).metadata.contains("request_id")) return status;
  const std::string& address = connection_.address;
  const std::string_view text(status.message().data(), status.message().size());
  const auto says = [text](std::string_view part) { return text.find(part) != text.npos; };
  // gRPC tells these causes only in its messages.
  if (says("http1.x server")) {
    return Unavailable(fmt::format("{} speaks HTTP, not gRPC", address),
                       "give the port of the server's --listen");
  }
  if (says("wrong version number")) {
    return Unavailable(fmt::format("{} does not speak TLS", address),
                       "leave out --tls and --tls-ca");
  }
  if (connection_.tls && says("empty address list")) {
    return Unavailable("the TLS files cannot be used", "check --tls-ca, --tls-cert and --tls-key");
  }
  return Unavailable(text, fmt::format("no answer from {0}: start a server there with 'latticed "
                                       "--listen {0}', or name another one with --server",
                                       address));
}

absl::Status WithSession(const SessionFlags& flags, const CommandLine& line,
                         const std::stop_token& stop,
                         const std::function<absl::Status(Session&)>& use) {
  const ReachabilityObserver say = [&](const absl::Status& trouble) {
    PrintNotice(trouble.ok()
                    ? "the server answers again"
                    : fmt::format("server unreachable, trying for {:g} s …", flags.retry_for),
                line.as_json, line.console.err);
  };
  LATTICED_ASSIGN_OR_RETURN(auto session, Session::Open(flags, stop, say));
  return session.Explain(use(session));
}

}  // namespace latticed::client
