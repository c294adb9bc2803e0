// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a command reaches a server: at an address, or in the command's own process. Both use a real
// gRPC channel.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SESSION_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SESSION_H_

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client/cpp/latticectl/command_line/command_line.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/retries/reachability.h"

namespace CLI {
class App;
}

namespace latticed {
class InProcessServer;  // server/in_process.h
}

namespace latticed::client {

struct SessionFlags {
  std::string server;  // empty: a server in this process, for commands that may run one
  std::string backend = "auto";
  std::string token;
  bool tls = false;
  std::string tls_ca, tls_cert, tls_key;                // PEM files
  double retry_for = absl::ToDoubleSeconds(kRetryFor);  // seconds
};

// Flags of every command that needs a running server.
struct ServerFlags {
  SessionFlags session;
  bool json = false;
};

enum class ServerChoice {
  kRequired,   // --server, by default $LATTICED_SERVER, else the daemon's own default address
  kInProcess,  // without --server the command runs one itself, on --backend
};
void AddSessionFlags(CLI::App& command, SessionFlags& flags, ServerChoice choice);

class Session {
 public:
  // A request of `stop` cancels the calls of client(). The observer is that of client().
  [[nodiscard]] static absl::StatusOr<Session> Open(const SessionFlags& flags, std::stop_token stop,
                                                    ReachabilityObserver observer);
  Session(Session&&) noexcept;
  ~Session();

  Client& client() { return *client_; }
  // Makes another client with its own connection, without the observer. A request of `stop` does not
  // cancel its calls.
  [[nodiscard]] std::unique_ptr<Client> NewClient() const;
  // Adds advice for the user to an error: how to reach a server that did not answer.
  absl::Status Explain(const absl::Status& status) const;

 private:
  Session();
  Connection connection_;  // for NewClient
  std::unique_ptr<InProcessServer> server_;
  std::unique_ptr<Client> client_;
};

// Opens a session and runs `use` on it. Applies Explain to the error of `use`. Prints a line when the
// server does not answer, and one when it does again.
[[nodiscard]] absl::Status WithSession(const SessionFlags& flags, const CommandLine& line,
                                       const std::stop_token& stop,
                                       const std::function<absl::Status(Session&)>& use);

// Adds the options of ServerFlags to a command, and makes run(flags, client, console) its action.
template <typename Flags, typename Run>
void SetServerAction(CLI::App& command, const std::shared_ptr<Flags>& flags, CommandLine& line,
                     Run run) {
  AddJsonFlag(command, flags->json);
  AddSessionFlags(command, flags->session, ServerChoice::kRequired);
  SetAction(command, line, [flags, run, &line] {
    return WithSession(flags->session, line, {}, [&](Session& session) {
      return run(*flags, session.client(), line.console);
    });
  });
}

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SESSION_H_
