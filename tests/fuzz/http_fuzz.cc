// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sends bytes to the whole server as one client of --http: HTTP/1.1, gRPC-Web, WebSocket, downloads. At each "<cut>" in
// the input the client waits until the server has answered what it could. Then it closes, and the connection must end.
// No answer may be INTERNAL or UNKNOWN, and another client must be answered afterwards.
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

#include "absl/time/clock.h"
#include "server/web/connection_set.h"
#include "server/web/http_connection.h"
#include "server/web/router.h"
#include "tests/fuzz/fuzz_server.h"
#include "tests/fuzz/http_input.h"
#include "tests/fuzz/open_answers.h"

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace latticed::fuzz {
namespace {

namespace net = boost::asio;

// How long an answer that is not complete may be silent: a stream, or one whose request is not complete.
constexpr std::chrono::microseconds kPatience(1'000);
constexpr absl::Duration kMostEnding = absl::Seconds(10);

// Folder of the viewer's files, with two of them and a compressed copy.
std::string MakeWebRoot() {
  const auto root =
      std::filesystem::temp_directory_path() / ("http_fuzz." + std::to_string(getpid()));
  std::filesystem::create_directories(root / "docs");
  std::ofstream(root / "index.html") << "<!doctype html><p>latticed";
  std::ofstream(root / "docs" / "a.js") << std::string(100'000, 'a');
  std::ofstream(root / "docs" / "a.js.br") << "brotli";
  return root;
}

// What the fuzzer's connections share.
class HttpSide {
 public:
  explicit HttpSide(const std::string& root) : root_(root) {}
  ~HttpSide() { std::filesystem::remove_all(root_); }

  // Serves one connection of the client that sends `input`.
  void Run(std::string_view input, FuzzServer& server);

 private:
  bool Receive(int client);
  void Settle(int client);
  void Send(int client, std::string_view piece);
  void CheckAnswers() const;

  const std::string root_;
  net::io_context context_;
  web::ConnectionSet connections_{1, 1};
  OpenAnswers open_;
  std::string received_;
};

// Takes what the server has sent. Returns false if there is nothing.
bool HttpSide::Receive(int client) {
  char buffer[16 << 10];
  bool any = false;
  for (ssize_t n = 0; (n = recv(client, buffer, sizeof(buffer), MSG_DONTWAIT)) > 0; any = true) {
    received_.append(buffer, static_cast<size_t>(n));
  }
  return any;
}

void HttpSide::Settle(int client) {
  const absl::Time latest = absl::Now() + kMostEnding;
  while (absl::Now() < latest) {
    context_.restart();
    if (context_.poll() > 0 || Receive(client)) continue;
    if (!open_.any() || context_.run_one_for(kPatience) == 0) return;
  }
}

void HttpSide::Send(int client, std::string_view piece) {
  while (!piece.empty()) {
    const ssize_t sent = send(client, piece.data(), piece.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && errno != EAGAIN) return;  // the server has closed the connection
    if (sent > 0) piece.remove_prefix(static_cast<size_t>(sent));
    Settle(client);
    if (sent < 0) return;  // it reads no more
  }
}

void HttpSide::CheckAnswers() const {
  for (const char* status :
       {"grpc-status: 13", "grpc-status:13", "grpc-status: 2\r", "grpc-status:2\r"}) {
    if (received_.find(status) != std::string::npos) Fail(received_);
  }
}

void HttpSide::Run(std::string_view input, FuzzServer& server) {
  Options options = server.options();
  options.web_root = root_;
  web::Router router(options, server.channel());
  const web::HttpHandler handler = [&](const std::shared_ptr<web::HttpExchange>& exchange) {
    router.Answer(open_.Follow(exchange));
  };
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) Fail("no sockets");
  net::ip::tcp::socket socket(context_);
  socket.assign(net::ip::tcp::v4(), ends[0]);
  web::ServeConnection(web::Transport(std::move(socket), nullptr), connections_.Enter(""),
                       options.http_timeouts, handler);
  for (const std::string_view piece : Pieces(input)) Send(ends[1], piece);
  shutdown(ends[1], SHUT_WR);
  Settle(ends[1]);
  close(ends[1]);
  const absl::Time latest = absl::Now() + kMostEnding;
  while (connections_.counts().open > 0) {
    if (absl::Now() > latest) Fail("the connection does not end");
    context_.restart();
    context_.run_one_for(kPatience);
  }
  CheckAnswers();
  received_.clear();
  open_.Clear();
}

}  // namespace
}  // namespace latticed::fuzz

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  latticed::fuzz::SetOptions(argc, argv);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace latticed::fuzz;
  FuzzServer& server = FuzzServer::Get();
  static HttpSide http(MakeWebRoot());
  server.Begin();
  http.Run({reinterpret_cast<const char*>(data), size}, server);
  server.End();
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned int seed) {
  size = LLVMFuzzerMutate(data, size, max_size);
  if (seed % 2 == 0) return size;
  const std::string input =
      latticed::fuzz::WithTrueLengths({reinterpret_cast<const char*>(data), size});
  if (input.size() > max_size) return size;
  std::memcpy(data, input.data(), input.size());
  return input.size();
}
