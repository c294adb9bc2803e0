// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A process of store_child.cc, and what it says is acknowledged.
#ifndef LATTICED_TESTS_SERVER_STORE_CRASH_RUNNING_CHILD_H_
#define LATTICED_TESTS_SERVER_STORE_CRASH_RUNNING_CHILD_H_

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <string>

#include "absl/time/time.h"

namespace latticed::testing {

class RunningChild {
 public:
  RunningChild(const std::string& folder, const std::string& durability, int scenes);
  ~RunningChild();
  RunningChild(const RunningChild&) = delete;  // one process
  RunningChild& operator=(const RunningChild&) = delete;

  // Lets it work for so long after its first acknowledgement. Returns false if it ended by itself.
  [[nodiscard]] bool Work(absl::Duration time);
  // Stops all its threads (SIGSTOP), and returns when they have stopped.
  void Stop();
  void Kill();

  // The last acknowledged record of each scene. What it said before Stop or Kill is in it.
  const std::map<std::string, uint64_t>& acknowledged();

 private:
  // Reads what there is, for up to `patience`. Returns false at the end.
  bool ReadMore(absl::Duration patience);

  pid_t process_ = -1;
  int output_ = -1;
  std::string rest_;  // of a line
  std::map<std::string, uint64_t> acknowledged_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_STORE_CRASH_RUNNING_CHILD_H_
