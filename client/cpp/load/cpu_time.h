// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Processor time of processes of this machine, user and system together.
//
// Errors   kNotFound for a process that is not there
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LOAD_CPU_TIME_H_
#define LATTICED_CLIENT_CPP_LOAD_CPU_TIME_H_

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace latticed::client {

[[nodiscard]] absl::Duration OwnCpuTime();
[[nodiscard]] absl::StatusOr<absl::Duration> CpuTimeOf(int process);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_CPU_TIME_H_
