// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The program latticed as a child process.
#ifndef LATTICED_TESTS_SERVER_DAEMON_DAEMON_PROCESS_H_
#define LATTICED_TESTS_SERVER_DAEMON_DAEMON_PROCESS_H_

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "fmt/format.h"

namespace latticed::testing {

// The daemon as a child process, with its standard error in a pipe.
class Daemon {
 public:
  // `most_files` limits its open files; 0: the limit of this process.
  explicit Daemon(std::vector<std::string> arguments, rlim_t most_files = 0) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) std::abort();
    pid_ = fork();
    if (pid_ == 0) {
      dup2(ends[1], STDERR_FILENO);
      close(ends[0]);
      const rlimit files{.rlim_cur = most_files, .rlim_max = most_files};
      if (most_files > 0) setrlimit(RLIMIT_NOFILE, &files);
      std::vector<char*> argv{const_cast<char*>(LATTICED_BINARY)};
      for (std::string& argument : arguments) argv.push_back(argument.data());
      argv.push_back(nullptr);
      execv(LATTICED_BINARY, argv.data());
      _exit(127);
    }
    close(ends[1]);
    log_ = fdopen(ends[0], "r");
  }
  ~Daemon() { fclose(log_); }

  std::string ReadLine() {
    std::array<char, 4'096> line{};
    return fgets(line.data(), line.size(), log_) == nullptr ? "" : line.data();
  }
  // The address of --listen. Reads the log up to the line that says "serving".
  std::string Address() {
    std::string line, key = "address=";
    do line = ReadLine();
    while (!line.empty() && line.find(key) == std::string::npos);
    const size_t begin = std::min(line.find(key), line.size() - key.size()) + key.size();
    return line.substr(begin, line.find(' ', begin) - begin);
  }
  void Signal(int signal) { kill(pid_, signal); }
  size_t OpenFiles() const {
    const std::filesystem::directory_iterator files(fmt::format("/proc/{}/fd", pid_));
    return static_cast<size_t>(std::distance(begin(files), end(files)));
  }
  int Wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t pid_ = -1;
  FILE* log_ = nullptr;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_DAEMON_DAEMON_PROCESS_H_
