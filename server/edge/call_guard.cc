// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/edge/call_guard.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "absl/time/time.h"
#include "core/base/limits.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"
#include "server/edge/open_calls.h"

namespace latticed {
namespace {

constexpr auto kTick = std::chrono::milliseconds(50);
constexpr int64_t kAllowed = limits::kMaxCallsPerConnection, kMost = 2 * kAllowed,
                  kMostAtOnce = 8 * kAllowed;
constexpr auto kMostOver = std::chrono::seconds(2);
// A call takes the head of an HTTP/2 frame at least.
constexpr uint64_t kLeastCallBytes = 9;
// gRPC may not have read all that came: it is asked again after kAskEvery, then after kLonger times as
// long, and so on up to kReadBy, so that it was asked after any pause that a client can keep it in;
// where too many calls are open, or the kernel does not say what came, every kAskEvery.
constexpr auto kAskEvery = std::chrono::milliseconds(250),
               kReadBy = std::chrono::milliseconds(16'000);
constexpr int kLonger = 4;
static_assert(kReadBy + kReadBy / kLonger >=
              std::chrono::milliseconds(limits::kKeepaliveTimeoutMs));
constexpr auto kLogEvery = std::chrono::seconds(1);

// 0 where nothing came, where it has ended, and where the kernel does not say (before Linux 4.1).
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
  pthread_setname_np(pthread_self(), "call-guard");  // as many_connections.py knows it, and top
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
  bool listed = false;
  for (const auto& [descriptor, inode] : connections_()) {
    Looked& here = looked_[descriptor];
    if (here.inode != inode) here = {.inode = inode};
    Receive(here, BytesReceived(descriptor), now);
    if (here.again > now) continue;
    if (here.number == kNoSocket && !std::exchange(listed, true)) open_calls_.List();
    Ask(descriptor, here, now);
  }
}

void CallGuard::Receive(Looked& here, uint64_t received, Clock::time_point now) {
  if (here.cut) return;  // gRPC is about to close it
  kernel_counts_ |= received > 0;
  const auto room = static_cast<uint64_t>(std::max<int64_t>(kMost + 1 - here.calls, 1));
  const bool asked_soon = here.again != Clock::time_point::max();
  if (kernel_counts_ ? received < here.received + kLeastCallBytes * room : asked_soon) return;
  here.received = received;
  here.again = now;
  here.wait = kAskEvery;
}

void CallGuard::Ask(int descriptor, Looked& here, Clock::time_point now) {
  if (SocketInode(descriptor) != here.inode) {  // it has ended
    here.again = Clock::time_point::max();
    return;
  }
  if (here.number == kNoSocket) here.number = open_calls_.NumberOf(Connection::Of(descriptor));
  const auto calls = OpenCalls::Of(here.number);
  if (!calls.has_value()) here.number = kNoSocket;  // not known yet, or of one that had its address
  here.calls = calls.value_or(0);
  const bool over = here.calls > kAllowed, far_over = here.calls > kMost;
  const bool twice = std::exchange(here.far_over, far_over) && far_over;
  here.over_since = over ? std::min(here.over_since, now) : Clock::time_point::max();
  if (twice || here.calls > kMostAtOnce || now - here.over_since > kMostOver) {
    here.cut = Cut(descriptor, here.inode, here.calls);
    here.again = here.cut ? Clock::time_point::max() : now + kAskEvery;
    return;
  }
  if (far_over) {
    here.again = now;  // at the next tick
    return;
  }
  if (over || !kernel_counts_) here.wait = kAskEvery;
  here.again = here.wait > kReadBy ? Clock::time_point::max() : now + here.wait;
  here.wait *= kLonger;
}

bool CallGuard::Cut(int descriptor, uint64_t inode, int64_t calls) {
  const int same = dup(descriptor);  // what gRPC closes meanwhile is not someone else's then
  if (same < 0) return false;
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
  return true;
}

}  // namespace latticed
