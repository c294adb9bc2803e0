// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Who gets a place among the connections of HTTP.
#include "server/web/connection_set.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/limits.h"
#include "tests/server/support/server_test.h"
#include "tests/server/web/web_client.h"

namespace latticed::testing {
namespace {

using web::ConnectionSet;

class HeldConnection final : public web::Connection {
 public:
  void Drain() override {}
  void Abort() override { aborted = true; }
  bool aborted = false;
};

TEST(ConnectionSetTest, OneAddressLeavesPlacesToOthers) {
  ConnectionSet set(4, 2);
  std::vector<std::shared_ptr<ConnectionSet::Place>> places;
  for (const char* address : {"10.0.0.1", "10.0.0.1", "10.0.0.1", "10.0.0.2", "", ""}) {
    places.push_back(set.Enter(address));
  }

  std::vector<bool> served;
  for (const auto& place : places) served.push_back(place->served());
  EXPECT_EQ(served, (std::vector<bool>{true, true, false, true, true, false}));
  EXPECT_EQ(set.counts().refused, 2u);
  places.erase(places.begin());
  EXPECT_TRUE(set.Enter("10.0.0.1")->served());
}

TEST(ConnectionSetTest, AFullSetMayReplaceItsOldest) {
  ConnectionSet set(2, ConnectionSet::kReplaceOldest);
  std::vector<std::shared_ptr<ConnectionSet::Place>> places;
  std::vector<std::shared_ptr<HeldConnection>> held;
  for (int i = 0; i < 3; ++i) {
    places.push_back(set.Enter(""));
    ASSERT_TRUE(places.back()->served()) << i;
    held.push_back(std::make_shared<HeldConnection>());
    places.back()->Hold(held.back());
  }

  EXPECT_TRUE(held[0]->aborted);
  EXPECT_FALSE(held[1]->aborted);
  EXPECT_FALSE(held[2]->aborted);
}

using AdminPortTest = SmallServerTest;

TEST_F(AdminPortTest, TheAdminPortCannotBeFilled) {
  Options options = TestOptions();
  options.admin = "127.0.0.1:0";
  StartServer(options);
  std::vector<std::unique_ptr<WebClient>> silent;
  for (size_t i = 0; i < 3 * limits::kMaxAdminConnections; ++i) {
    silent.push_back(std::make_unique<WebClient>(server_->admin_address()));
  }

  EXPECT_EQ(WebClient(server_->admin_address()).Get("/healthz").status, 200);
}

}  // namespace
}  // namespace latticed::testing
