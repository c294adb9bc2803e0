// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The command-line client as a function, so that tests run it in their own process.
//
// Returns  0 done, or help was printed; 1 failed; 2 wrong usage; 130 and 143 interrupted by SIGINT or SIGTERM, after
//          deleting its temporary scenes and meshes; 3 `folds` has found a fold. All but 0 and 3 print one line on err
//          (failure.h)
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_LATTICECTL_APP_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_LATTICECTL_APP_H_

#include "client/cpp/latticectl/output/console.h"

namespace latticed::client {

[[nodiscard]] int RunLatticectl(int argc, const char* const* argv, Console console);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_LATTICECTL_APP_H_
