// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// GetServerInfo, and the metadata that every reply carries.
#include <array>

#include "core/base/limits.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

std::string Value(const std::multimap<grpc::string_ref, grpc::string_ref>& metadata,
                  const char* key) {
  const auto found = metadata.find(key);
  return found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
}

using ServerServiceTest = SmallServerTest;

TEST_F(ServerServiceTest, InfoNamesBackendAbilitiesAndEveryLimit) {
  const v1::ServerInfo info = Info();

  ASSERT_EQ(info.backends_size(), 1);
  EXPECT_EQ(info.backends(0).name(), "cpu");
  EXPECT_EQ(info.backends(0).devices_size(), 1);
  EXPECT_EQ(info.version(), "0.1.0");
  EXPECT_EQ(info.node(), "test-node");
  EXPECT_EQ(info.boot_id().size(), 32u);
  EXPECT_EQ(info.encodings_size(), 6);
  EXPECT_EQ(info.mesh_formats_size(), 6);
  EXPECT_EQ(info.export_formats_size(), 6);
  EXPECT_EQ(info.pipelines_size(), 4);
  EXPECT_EQ(info.heartbeat().seconds(), 20);  // as StartServer sets it
  EXPECT_FALSE(info.durable());
  EXPECT_EQ(info.limits().max_part_bytes(), 786'432u);
  EXPECT_EQ(info.limits().max_mesh_bytes(), 16u << 20);
  EXPECT_EQ(info.limits().max_segments(), 32);
  EXPECT_EQ(info.limits().max_control_points(), 32'768);
  EXPECT_EQ(info.limits().max_scenes(), 10'000);
  EXPECT_EQ(info.limits().max_watchers_per_scene(), 1'000);
  EXPECT_EQ(info.limits().max_evaluate_points(), 4'096);
  EXPECT_EQ(info.limits().upload_idle_timeout().seconds(), 3'600);
}

TEST_F(ServerServiceTest, AProbeHasAsManyBytesAsAskedForAndNoPattern) {
  v1::GetServerInfoRequest request;
  v1::ServerInfo info;
  EXPECT_EQ(Info().probe(), "");

  request.set_probe_bytes(limits::kMaxPartBytes);
  ASSERT_OK(Call(&Infos::GetServerInfo, request, &info));
  EXPECT_EQ(info.probe().size(), 786'432u);
  std::array<int, 256> counts{};
  for (const char byte : info.probe()) ++counts[static_cast<uint8_t>(byte)];
  EXPECT_THAT(counts, ::testing::Each(::testing::AllOf(::testing::Gt(2'700), ::testing::Lt(3'450))))
      << "3,072 each, within seven standard deviations";

  request.set_probe_bytes(limits::kMaxPartBytes + 1);
  ExpectRefused(Call(&Infos::GetServerInfo, request, &info), absl::StatusCode::kInvalidArgument,
                "OUT_OF_RANGE", "probe_bytes");
}

TEST_F(ServerServiceTest, FeaturesNameHttpWhereItIsServed) {
  EXPECT_THAT(Info().features(), ::testing::ElementsAre(v1::FEATURE_DRAG_POINTS, v1::FEATURE_PICK,
                                                        v1::FEATURE_PRESENCE));
  Options options = TestOptions();
  options.http = "127.0.0.1:0";
  StartServer(options);
  EXPECT_THAT(Info().features(), ::testing::Contains(v1::FEATURE_HTTP));
}

TEST_F(ServerServiceTest, TwoStartsHaveTwoBootIds) {
  const std::string first = Info().boot_id();
  StartServer(TestOptions());
  EXPECT_NE(Info().boot_id(), first);
}

TEST_F(ServerServiceTest, EveryReplyCarriesRequestIdAndNode) {
  grpc::ClientContext context, refused;
  v1::ServerInfo info;
  v1::Mesh mesh;

  ASSERT_TRUE(infos_->GetServerInfo(&context, {}, &info).ok());
  ASSERT_FALSE(meshes_->GetMesh(&refused, {}, &mesh).ok());

  for (const auto& metadata :
       {context.GetServerInitialMetadata(), refused.GetServerTrailingMetadata()}) {
    EXPECT_EQ(Value(metadata, "latticed-request-id").size(), 16u);
    EXPECT_EQ(Value(metadata, "latticed-node"), "test-node");
  }
}

TEST_F(ServerServiceTest, SaneRequestIdsAreKeptOthersReplaced) {
  grpc::ClientContext sane, insane;
  sane.AddMetadata("latticed-request-id", "web-42");
  insane.AddMetadata("latticed-request-id", "two words");
  v1::ServerInfo info;

  ASSERT_TRUE(infos_->GetServerInfo(&sane, {}, &info).ok());
  ASSERT_TRUE(infos_->GetServerInfo(&insane, {}, &info).ok());

  EXPECT_EQ(Value(sane.GetServerInitialMetadata(), "latticed-request-id"), "web-42");
  EXPECT_EQ(Value(insane.GetServerInitialMetadata(), "latticed-request-id").size(), 16u);
}

}  // namespace
}  // namespace latticed::testing
