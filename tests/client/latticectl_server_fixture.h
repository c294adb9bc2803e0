// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs latticectl's commands against a real server in this process, which they reach by its address.
#ifndef LATTICED_TESTS_CLIENT_LATTICECTL_SERVER_FIXTURE_H_
#define LATTICED_TESTS_CLIENT_LATTICECTL_SERVER_FIXTURE_H_

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/client/latticectl_fixture.h"
#include "tests/client/quiet_server.h"

namespace latticed::client {

class LatticectlServer : public LatticectlTest {
 protected:
  void SetUp() override {
    LatticectlTest::SetUp();
    ASSERT_NE(server_, nullptr);
    MustRun({"sample", "vase", "--resolution", "1", "-o", Path("vase.obj")});
  }

  std::string address() const { return server_->address(); }
  std::vector<std::string> AtServer(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--server", address()});
    return arguments;
  }
  std::string Run(std::vector<std::string> arguments) const {
    return MustRun(AtServer(std::move(arguments)));
  }
  // Expects the command to fail with exit code 1 and an error output that matches `why`.
  void ExpectFailure(std::vector<std::string> arguments,
                     const ::testing::Matcher<std::string>& why) const {
    const RunResult result = Latticectl(AtServer(std::move(arguments)));
    EXPECT_EQ(result.code, 1);
    EXPECT_THAT(result.err, why);
  }
  nlohmann::json RunJson(std::vector<std::string> arguments) const {
    arguments.push_back("--json");
    return nlohmann::json::parse(Run(std::move(arguments)), nullptr, /*allow_exceptions=*/false);
  }

 private:
  const std::unique_ptr<InProcessServer> server_ = StartServer();
};

}  // namespace latticed::client

#endif  // LATTICED_TESTS_CLIENT_LATTICECTL_SERVER_FIXTURE_H_
