// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Where a command writes: results on out, progress and errors on err.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_CONSOLE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_CONSOLE_H_

#include <iosfwd>

namespace latticed::client {

struct Console {
  std::ostream& out;
  std::ostream& err;
  bool err_is_terminal = false;  // progress bars only there
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_CONSOLE_H_
