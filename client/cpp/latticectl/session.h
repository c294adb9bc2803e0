// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How a command reaches a server: at an address, or one that it runs in its own process, over a
// real gRPC channel either way.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_SESSION_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_SESSION_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/interruption.h"
#include "client/cpp/library/latticed_client.h"

namespace CLI {
class App;
}

namespace latticed {
class InProcessServer;  // server/in_process.h
}

namespace latticed::client {

struct SessionFlags {
  std::string server;  // empty: in this process, where the command may
  std::string backend = "auto";
  std::string token;
  bool tls = false;
  std::string tls_ca, tls_cert, tls_key;  // PEM files
};

enum class ServerChoice {
  kRequired,   // --server, by default $LATTICED_SERVER, else the daemon's own default address
  kInProcess,  // as well, without --server: --backend names what runs here
};
void AddSessionFlags(CLI::App& command, SessionFlags& flags, ServerChoice choice);

class Session {
 public:
  // With an interruption its signals cancel the calls to a server at an address; a server in this
  // process ends with it, and so does what was made there.
  [[nodiscard]] static absl::StatusOr<Session> Open(const SessionFlags& flags,
                                                    Interruption* interruption = nullptr);
  // The same with a token, which cancels the calls to either kind of server.
  [[nodiscard]] static absl::StatusOr<Session> Open(const SessionFlags& flags,
                                                    std::stop_token stop);
  Session(Session&&) noexcept;
  ~Session();

  Client& client() { return *client_; }
  // Another client of the server, with a connection of its own, which no interruption cancels.
  [[nodiscard]] std::unique_ptr<Client> NewClient() const;
  // A counter of a server in this process, as its /metrics has it; none of another server.
  std::optional<uint64_t> Counter(std::string_view name) const;
  // Adds to an error what a person can do about it.
  absl::Status Explain(const absl::Status& status) const;

 private:
  Session();
  std::string address_;    // empty: in this process
  Connection connection_;  // of further clients
  std::unique_ptr<InProcessServer> server_;
  std::unique_ptr<Client> client_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_SESSION_H_
