// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a server says about itself, and what every reply carries.
#include "core/base/limits.h"
#include "tests/server/test_env.h"
#include "tests/support/status_matchers.h"

namespace latticed {
namespace {

using ::latticed::testing::TestEnv;

std::string Value(const std::multimap<grpc::string_ref, grpc::string_ref>& metadata,
                  const char* key) {
  const auto found = metadata.find(key);
  return found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
}

TEST(ServerServiceTest, InfoNamesBackendAbilitiesAndEveryLimit) {
  TestEnv env;
  grpc::ClientContext context;
  v1::ServerInfo info;

  ASSERT_TRUE(env.info().GetServerInfo(&context, {}, &info).ok());

  ASSERT_EQ(info.backends_size(), 1);
  EXPECT_EQ(info.backends(0).name(), "cpu");
  EXPECT_EQ(info.backends(0).devices_size(), 1);
  EXPECT_EQ(info.version(), "0.1.0");
  EXPECT_EQ(info.node(), "test-node");
  EXPECT_EQ(info.boot_id().size(), 32u);
  EXPECT_EQ(info.encodings_size(), 4);
  EXPECT_EQ(info.mesh_formats_size(), 6);
  EXPECT_EQ(info.export_formats_size(), 6);
  EXPECT_EQ(info.pipelines_size(), 4);
  EXPECT_EQ(info.heartbeat().seconds(), 10);
  EXPECT_FALSE(info.durable());
  EXPECT_EQ(info.limits().max_part_bytes(), 786'432u);
  EXPECT_EQ(info.limits().max_mesh_bytes(), 16u << 20);
  EXPECT_EQ(info.limits().max_segments(), 32);
  EXPECT_EQ(info.limits().max_control_points(), 32'768);
  EXPECT_EQ(info.limits().upload_idle_timeout().seconds(), 3'600);
}

TEST(ServerServiceTest, TwoStartsHaveTwoBootIds) {
  TestEnv one, two;
  grpc::ClientContext context_one, context_two;
  v1::ServerInfo info_one, info_two;

  ASSERT_TRUE(one.info().GetServerInfo(&context_one, {}, &info_one).ok());
  ASSERT_TRUE(two.info().GetServerInfo(&context_two, {}, &info_two).ok());

  EXPECT_NE(info_one.boot_id(), info_two.boot_id());
}

TEST(MetadataTest, EveryReplyCarriesRequestIdAndNode) {
  TestEnv env;
  grpc::ClientContext context, refused;
  v1::ServerInfo info;
  v1::Mesh mesh;

  ASSERT_TRUE(env.info().GetServerInfo(&context, {}, &info).ok());
  ASSERT_FALSE(env.meshes().GetMesh(&refused, {}, &mesh).ok());

  EXPECT_EQ(Value(context.GetServerInitialMetadata(), "latticed-request-id").size(), 16u);
  EXPECT_EQ(Value(context.GetServerInitialMetadata(), "latticed-node"), "test-node");
  EXPECT_EQ(Value(refused.GetServerTrailingMetadata(), "latticed-request-id").size(), 16u);
  EXPECT_EQ(Value(refused.GetServerTrailingMetadata(), "latticed-node"), "test-node");
}

TEST(MetadataTest, SaneRequestIdsAreKeptOthersReplaced) {
  TestEnv env;
  grpc::ClientContext sane, insane;
  sane.AddMetadata("latticed-request-id", "web-42");
  insane.AddMetadata("latticed-request-id", "two words");
  v1::ServerInfo info;

  ASSERT_TRUE(env.info().GetServerInfo(&sane, {}, &info).ok());
  ASSERT_TRUE(env.info().GetServerInfo(&insane, {}, &info).ok());

  EXPECT_EQ(Value(sane.GetServerInitialMetadata(), "latticed-request-id"), "web-42");
  EXPECT_EQ(Value(insane.GetServerInitialMetadata(), "latticed-request-id").size(), 16u);
}

}  // namespace
}  // namespace latticed
