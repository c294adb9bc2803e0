// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/header_probe.h"

#include <grpc/grpc.h>
#include <grpc/grpc_posix.h>
#include <grpc/grpc_security.h>
#include <grpc/support/time.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string_view>

namespace latticed {
namespace {

using std::string_view_literals::operator""sv;

// RFC 9113: the preface, settings, and a call's header of one field, ":method: GET", that ends both.
constexpr std::string_view kHeader =
    "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
    "\0\0\0\4\0\0\0\0\0"
    "\0\0\1\1\5\0\0\0\1\x82"sv;
constexpr int kLooks = 200, kLookMs = 5;

gpr_timespec After(int ms) {
  return gpr_time_add(gpr_now(GPR_CLOCK_REALTIME), gpr_time_from_millis(ms, GPR_TIMESPAN));
}

// One that nobody's calls come to.
class IdleServer {
 public:
  // Takes the descriptor.
  explicit IdleServer(int connection) {
    grpc_server_register_completion_queue(server_, queue_, nullptr);
    grpc_server_start(server_);
    grpc_server_credentials* const insecure = grpc_insecure_server_credentials_create();
    grpc_server_add_channel_from_fd(server_, connection, insecure);
    grpc_server_credentials_release(insecure);
  }
  ~IdleServer() {
    grpc_server_shutdown_and_notify(server_, queue_, nullptr);
    grpc_server_cancel_all_calls(server_);
    static_cast<void>(Next(gpr_inf_future(GPR_CLOCK_REALTIME)));
    grpc_server_destroy(server_);
    grpc_completion_queue_shutdown(queue_);
    while (Next(gpr_inf_future(GPR_CLOCK_REALTIME)) != GRPC_QUEUE_SHUTDOWN) {
    }
    grpc_completion_queue_destroy(queue_);
  }
  IdleServer(const IdleServer&) = delete;
  IdleServer& operator=(const IdleServer&) = delete;

  void Work() { static_cast<void>(Next(After(kLookMs))); }

 private:
  grpc_completion_type Next(gpr_timespec until) {
    return grpc_completion_queue_next(queue_, until, nullptr).type;
  }

  grpc_completion_queue* const queue_ = grpc_completion_queue_create_for_next(nullptr);
  grpc_server* const server_ = grpc_server_create(nullptr, nullptr);
};

}  // namespace

bool SendHeader(absl::FunctionRef<bool()> seen) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return false;
  }
  grpc_init();
  {
    IdleServer server(ends[0]);
    if (send(ends[1], kHeader.data(), kHeader.size(), MSG_NOSIGNAL) ==
        static_cast<ssize_t>(kHeader.size())) {
      for (int look = 0; look < kLooks && !seen(); ++look) server.Work();
    }
  }
  grpc_shutdown();
  close(ends[1]);
  return seen();
}

}  // namespace latticed
