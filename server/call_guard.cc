// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/call_guard.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <utility>
#include <vector>

#include "absl/time/time.h"
#include "core/base/limits.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/open_calls.h"

namespace latticed {
namespace {

constexpr auto kTick = std::chrono::milliseconds(50);
constexpr int64_t kAllowed = limits::kMaxCallsPerConnection, kMost = 2 * kAllowed;
constexpr auto kMostOver = std::chrono::seconds(2);
// A call takes the head of an HTTP/2 frame at least.
constexpr uint64_t kLeastCallBytes = 9;
// Long after gRPC has read what came, and so often is it asked meanwhile.
constexpr auto kReadBy = std::chrono::seconds(10);
constexpr auto kAskEvery = std::chrono::milliseconds(250);
constexpr auto kLogEvery = std::chrono::seconds(1);

// 0 where nothing came, and where the kernel does not say (before Linux 4.1).
uint64_t BytesReceived(int socket) {
  tcp_info info = {};
  socklen_t size = sizeof(info);
  return getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 ? info.tcpi_bytes_received
                                                                      : 0;
}

}  // namespace

uint64_t SocketInode(int descriptor) {
  struct stat state = {};
  return fstat(descriptor, &state) == 0 && S_ISSOCK(state.st_mode) ? state.st_ino : 0;
}

CallGuard::CallGuard(std::function<Sockets()> connections)
    : connections_(std::move(connections)), thread_([this] { Run(); }) {}

CallGuard::~CallGuard() {
  {
    const MutexLock lock(&mutex_);
    stopped_ = true;
  }
  thread_.join();
}

void CallGuard::Run() {
  const auto stopped = [this]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return stopped_; };
  while (true) {
    {
      const MutexLock lock(&mutex_);
      if (mutex_.AwaitFor(stopped, absl::FromChrono(kTick))) return;
    }
    try {
      LookAround();
    } catch (const std::exception& error) {  // no memory, above all
      LogEvent(spdlog::level::err, "connections were not looked at", {{"error", error.what()}});
    }
  }
}

void CallGuard::LookAround() {
  const Clock::time_point now = Clock::now();
  std::map<uint64_t, Looked> looked;  // without those that have ended
  std::vector<Sockets::value_type> due;
  for (const auto& [descriptor, inode] : connections_()) {
    Looked& here = looked[inode] = looked_[inode];
    if (IsDue(here, BytesReceived(descriptor), now)) due.emplace_back(descriptor, inode);
  }
  looked_ = std::move(looked);
  if (due.empty()) return;
  const OpenCalls open;
  for (const auto& [descriptor, inode] : due) {
    const int64_t calls = open.Of(Connection::Of(descriptor));
    Looked& here = looked_[inode];
    here.cut = IsExcess(here, calls, now);
    if (here.cut) Cut(descriptor, inode, calls);
  }
}

bool CallGuard::IsDue(Looked& looked, uint64_t received, Clock::time_point now) {
  if (looked.cut) return false;  // gRPC is about to close it
  const int64_t room = std::max<int64_t>(kMost + 1 - looked.calls, 1);
  if (received >= looked.received + kLeastCallBytes * static_cast<uint64_t>(room)) {
    looked.received = received;
    looked.again = now + kAskEvery;
    looked.until = now + kReadBy;
    return true;
  }
  const bool asks = now < looked.until || looked.calls > kAllowed || received == 0;
  if (!asks || now < looked.again) return false;
  looked.again = now + kAskEvery;
  return true;
}

bool CallGuard::IsExcess(Looked& looked, int64_t calls, Clock::time_point now) {
  looked.calls = calls;
  looked.over_since =
      calls <= kAllowed ? Clock::time_point::max() : std::min(looked.over_since, now);
  return calls > kMost || now - looked.over_since > kMostOver;
}

void CallGuard::Cut(int descriptor, uint64_t inode, int64_t calls) {
  const int same = dup(descriptor);  // what gRPC closes meanwhile is not someone else's then
  if (same < 0) return;
  if (SocketInode(same) == inode) {
    const Clock::time_point now = Clock::now();
    if (now >= logs_again_) {  // who comes again and again must not fill the log
      logs_again_ = now + kLogEvery;
      LogEvent(spdlog::level::warn, "a connection is cut, it has more calls open than it may",
               {{"peer", Connection::Of(same).remote.Name()}, {"calls", fmt::to_string(calls)}});
    }
    ++cut_;
    shutdown(same, SHUT_RDWR);
  }
  close(same);
}

}  // namespace latticed
