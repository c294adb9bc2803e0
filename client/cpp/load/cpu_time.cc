// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/cpu_time.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>

#include "fmt/format.h"

namespace latticed::client {

absl::Duration OwnCpuTime() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return absl::DurationFromTimeval(usage.ru_utime) + absl::DurationFromTimeval(usage.ru_stime);
}

// Of /proc/<process>/stat (proc(5)): "pid (name) state …", utime and stime are the fields 14 and 15.
absl::StatusOr<absl::Duration> CpuTimeOf(int process) {
  constexpr int kFieldsBetweenNameAndTimes = 11;
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string line, field;
  std::getline(file, line);
  std::istringstream fields(line.substr(line.rfind(')') + 1));  // a name may hold anything
  for (int i = 0; i < kFieldsBetweenNameAndTimes; ++i) fields >> field;
  int64_t user = 0, system = 0;
  if (!(fields >> user >> system)) {
    return absl::NotFoundError(fmt::format("there is no process {} here", process));
  }
  return absl::Seconds(user + system) / sysconf(_SC_CLK_TCK);
}

}  // namespace latticed::client
