// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Cuts connections that have more calls open than they may.
//
// gRPC 1.51 holds a client to kMaxCallsPerConnection once it has acknowledged the settings that say
// so, and no quota counts what a call takes: one that never acknowledges begins 65,000 a second, of
// 12 KB each. So what connections receive is looked at, and where that is enough for many calls,
// gRPC's own count of them. Cut is who has
//
//   more than eight times as many    at once
//   more than twice as many          at two looks, 50 ms apart
//   more                             for two seconds
//
// for a call that its client knows has ended may count for a moment: on two cores that others took up,
// 128 threads of calls that do nothing counted as 220 in most seconds, and as 257 in one of a hundred;
// as more than 128 for 0.16 s at most, in 15 times 3 s.
//
// Threads  safe; it has one of its own
#ifndef LATTICED_SERVER_EDGE_CALL_GUARD_H_
#define LATTICED_SERVER_EDGE_CALL_GUARD_H_

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"
#include "server/edge/open_calls.h"

namespace latticed {

class CallGuard {
 public:
  // Descriptors, each with the inode of the socket that it was; it may be another by now, or none.
  using Sockets = std::vector<std::pair<int, uint64_t>>;

  // Asks for the connections every 50 ms, on its thread.
  explicit CallGuard(std::function<Sockets()> connections);
  ~CallGuard();

  // Connections cut since the start.
  uint64_t cut() const { return cut_.load(); }

 private:
  using Clock = std::chrono::steady_clock;
  // What is known of a connection; another inode has another's descriptor.
  struct Looked {
    uint64_t inode = 0;
    SocketNumber number = kNoSocket;
    uint64_t received = 0;  // when so much had come that it was asked about
    int64_t calls = 0;      // when it was asked about last
    Clock::time_point again = Clock::time_point::max();       // when it is asked about next
    Clock::duration wait{};                                   // and how long after that, if again
    Clock::time_point over_since = Clock::time_point::max();  // more calls than it may have
    bool far_over = false;                                    // when it was asked about last
    bool cut = false;
  };
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  void LookAround();
  void Receive(Looked& here, uint64_t received, Clock::time_point now);
  void Ask(int descriptor, Looked& here, Clock::time_point now);
  // False where the process has no descriptor left for it.
  bool Cut(int descriptor, uint64_t inode, int64_t calls);

  const std::function<Sockets()> connections_;
  // Of the thread.
  std::map<int, Looked> looked_;  // by descriptor
  bool kernel_counts_ = false;    // what connections receive
  OpenCalls open_calls_;
  Clock::time_point logs_again_;

  std::atomic<uint64_t> cut_ = 0;

  Mutex mutex_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it uses the rest
};

// Of the socket that a descriptor is, which no other has; 0 where it is none.
[[nodiscard]] uint64_t SocketInode(int descriptor);

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_CALL_GUARD_H_
