// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs latticectl's commands and latticectl-bench in this process. Each test has a temporary folder.
#ifndef LATTICED_TESTS_CLIENT_LATTICECTL_FIXTURE_H_
#define LATTICED_TESTS_CLIENT_LATTICECTL_FIXTURE_H_

#include <sstream>
#include <string>
#include <vector>

#include "client/cpp/latticectl/geometry/files.h"
#include "client/cpp/latticectl/latticectl_app.h"
#include "client/cpp/load/bench_app.h"
#include "tests/support/status_matchers.h"
#include "tests/support/temporary_folder.h"

namespace latticed::client {

struct RunResult {
  int code = 0;
  std::string out, err;
};

class LatticectlTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_.Path(name); }

  static int RunAt(Console console, const std::vector<std::string>& arguments) {
    std::vector<const char*> argv{"latticectl"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    const int argc = static_cast<int>(argv.size());
    if (argc == 1 || arguments[0] != "bench") return RunLatticectl(argc, argv.data(), console);
    return RunLatticectlBench(argc - 1, argv.data() + 1, console);
  }

  static RunResult Latticectl(const std::vector<std::string>& arguments) {
    std::ostringstream out, err;
    const int code = RunAt({.out = out, .err = err}, arguments);
    return {code, out.str(), err.str()};
  }

  // Returns the standard output. Fails the test if the command fails.
  static std::string MustRun(const std::vector<std::string>& arguments) {
    const RunResult result = Latticectl(arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    return result.out;
  }

 private:
  testing::TemporaryFolder folder_;
};

}  // namespace latticed::client

#endif  // LATTICED_TESTS_CLIENT_LATTICECTL_FIXTURE_H_
