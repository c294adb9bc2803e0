// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where the time goes from an edit to its update at an editor, and what is the next bottleneck:
//
//   apply | wait for a turn | evaluate | encode | send | on the way | decode
//
// Medians of each by itself, so that their sum is near the median of the whole, and not the same.
//
// Units    milliseconds
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LOAD_TIME_SHARES_H_
#define LATTICED_CLIENT_CPP_LOAD_TIME_SHARES_H_

#include <string>
#include <vector>

#include "client/cpp/load/load_report.h"

namespace latticed::client {

struct TimeShare {
  std::string key, name;  // for programs and for people
  double ms = 0;
};

// The longest first: the bottleneck. Without decoding where nothing was decoded; empty where no update
// was timed.
[[nodiscard]] std::vector<TimeShare> TimeShares(const LoadReport& report);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_TIME_SHARES_H_
