// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_OUTPUT_CONSOLE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_OUTPUT_CONSOLE_H_

#include <iosfwd>

namespace latticed::client {

// A command writes results to out, and progress and errors to err.
struct Console {
  std::ostream& out;
  std::ostream& err;
  bool err_is_terminal = false;  // progress bars are shown only on a terminal
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_OUTPUT_CONSOLE_H_
