// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/cpu_time.h"

#include <time.h>

#include "fmt/format.h"

namespace latticed::client {

absl::Duration OwnCpuTime() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return absl::DurationFromTimespec(time);
}

absl::StatusOr<absl::Duration> CpuTimeOf(int process) {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &time) != 0) {
    return absl::NotFoundError(fmt::format("there is no process {} here", process));
  }
  return absl::DurationFromTimespec(time);
}

}  // namespace latticed::client
