// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/store/crash/running_child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <stdexcept>

#include "absl/time/clock.h"

namespace latticed::testing {

RunningChild::RunningChild(const std::string& folder, const std::string& durability, int scenes) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const std::string count = std::to_string(scenes);
  process_ = fork();
  if (process_ < 0) throw std::runtime_error("no process");
  if (process_ == 0) {
    dup2(ends[1], STDOUT_FILENO);
    execl(LATTICED_STORE_CHILD, "store_child", folder.c_str(), durability.c_str(), count.c_str(),
          nullptr);
    _exit(127);
  }
  close(ends[1]);
  output_ = ends[0];
}

RunningChild::~RunningChild() {
  Kill();
  close(output_);
}

bool RunningChild::Work(absl::Duration time) {
  while (acknowledged_.empty()) {
    if (!ReadMore(absl::Seconds(60))) return false;
  }
  const absl::Time end = absl::Now() + time;
  while (absl::Now() < end) {
    if (!ReadMore(end - absl::Now())) return false;
  }
  return true;
}

void RunningChild::Stop() {
  kill(process_, SIGSTOP);
  waitpid(process_, nullptr, WUNTRACED);
}

void RunningChild::Kill() {
  if (process_ < 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  process_ = -1;
}

const std::map<std::string, uint64_t>& RunningChild::acknowledged() {
  pollfd ready = {.fd = output_, .events = POLLIN, .revents = 0};
  while (poll(&ready, 1, 0) > 0 && ReadMore(absl::ZeroDuration())) {
  }
  return acknowledged_;
}

bool RunningChild::ReadMore(absl::Duration patience) {
  pollfd ready = {.fd = output_, .events = POLLIN, .revents = 0};
  if (poll(&ready, 1, static_cast<int>(absl::ToInt64Milliseconds(patience))) == 0) return true;
  std::array<char, 65'536> buffer;
  const ssize_t size = read(output_, buffer.data(), buffer.size());
  if (size <= 0) return false;
  rest_.append(buffer.data(), static_cast<size_t>(size));
  size_t begin = 0;
  for (size_t end; (end = rest_.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const size_t space = rest_.find(' ', begin);
    acknowledged_[rest_.substr(begin, space - begin)] =
        std::strtoull(rest_.c_str() + space, nullptr, 10);
  }
  rest_.erase(0, begin);
  return true;
}

}  // namespace latticed::testing
