// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Many Watch streams of one scene, each on a connection of its own, that parse no chunks: readers
// that are prompt, slow, or do not read at all.
//
// Threads  safe; streams end with their crowd
#ifndef LATTICED_TESTS_SERVER_WATCH_CROWD_H_
#define LATTICED_TESTS_SERVER_WATCH_CROWD_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "latticed/v1/scene.pb.h"

namespace latticed::testing {

class WatchCrowd {
 public:
  struct Options {
    int count = 1;
    bool reads = true;     // false: takes nothing before ReadOn
    absl::Duration pause;  // after every message
    // Called at every update_end, from many threads.
    std::function<void(uint64_t revision)> on_update = [](uint64_t) {};
  };
  WatchCrowd(const std::string& address, const v1::WatchRequest& request, Options options);
  ~WatchCrowd();
  WatchCrowd(const WatchCrowd&) = delete;  // its streams hold its address
  WatchCrowd& operator=(const WatchCrowd&) = delete;

  void ReadOn();
  // False when one of them does not get there in time, or ends.
  bool WaitForRevision(uint64_t revision, absl::Duration most) const;
  // Over all of them.
  uint64_t updates() const;
  uint64_t restarts() const;

 private:
  class Stream;
  std::vector<std::unique_ptr<Stream>> streams_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_WATCH_CROWD_H_
