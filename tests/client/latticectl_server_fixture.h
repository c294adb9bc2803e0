// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs latticectl's commands against a real server in this process that they reach by address.
#ifndef LATTICED_TESTS_CLIENT_LATTICECTL_SERVER_FIXTURE_H_
#define LATTICED_TESTS_CLIENT_LATTICECTL_SERVER_FIXTURE_H_

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "server/in_process.h"
#include "tests/client/latticectl_fixture.h"

namespace latticed::client {

class LatticectlServer : public LatticectlTest {
 protected:
  void SetUp() override {
    LatticectlTest::SetUp();
    Options options;
    options.backend = "cpu";
    options.log_level = "off";
    options.drain_delay = absl::ZeroDuration();
    auto server = InProcessServer::Start(options);
    ASSERT_OK(server);
    server_ = *std::move(server);
    MustRun({"sample", "vase", "--resolution", "1", "-o", Path("vase.obj")});
  }

  std::vector<std::string> AtServer(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--server", server_->address()});
    return arguments;
  }
  std::string Run(std::vector<std::string> arguments) const {
    return MustRun(AtServer(std::move(arguments)));
  }
  nlohmann::json RunJson(std::vector<std::string> arguments) const {
    arguments.push_back("--json");
    return nlohmann::json::parse(Run(std::move(arguments)), nullptr, /*allow_exceptions=*/false);
  }

 private:
  std::unique_ptr<InProcessServer> server_;
};

}  // namespace latticed::client

#endif  // LATTICED_TESTS_CLIENT_LATTICECTL_SERVER_FIXTURE_H_
