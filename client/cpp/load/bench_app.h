// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// latticectl-bench, the load generator, as a function, so that tests run it in their own process.
// Users start it as 'latticectl bench'. Returns the exit codes of RunLatticectl.
#ifndef LATTICED_CLIENT_CPP_LOAD_BENCH_APP_H_
#define LATTICED_CLIENT_CPP_LOAD_BENCH_APP_H_

#include "client/cpp/latticectl/output/console.h"

namespace latticed::client {

[[nodiscard]] int RunLatticectlBench(int argc, const char* const* argv, Console console);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_BENCH_APP_H_
