// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shares of callers: mallory takes all that she can of each limit, and ed still has what he needs.
#include "server/stores/callers.h"

#include <gmock/gmock.h>

#include "core/base/limits.h"
#include "core/base/sha256.h"
#include "fmt/format.h"
#include "server/base/address.h"
#include "server/base/auth/token_throttle.h"
#include "server/engine/memory/memory_budget.h"
#include "tests/server/support/raw_call.h"
#include "tests/server/support/server_test.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

constexpr auto kExhausted = absl::StatusCode::kResourceExhausted;

TEST(AddressTest, KnowsThisMachine) {
  for (const char* peer : {"ipv4:127.0.0.1:5", "ipv4:127.8.9.1:5", "ipv6:%5B::1%5D:5",
                           "ipv6:[::1]:5", "unix:", "unix:/run/x", "inproc", ""}) {
    EXPECT_TRUE(IsOfThisMachine(peer)) << peer;
  }
  for (const char* peer : {"ipv4:10.0.0.1:5", "ipv6:%5B2001::1%5D:5", "ipv4:12.7.0.1:5"}) {
    EXPECT_FALSE(IsOfThisMachine(peer)) << peer;
  }
  EXPECT_EQ(WithoutPort("ipv6:%5B2001::1%5D:5"), "ipv6:%5B2001::1%5D");
  EXPECT_EQ(IpOf("ipv6:%5B2001::1%5D:5"), "2001::1");
  EXPECT_EQ(IpOf("ipv4:10.0.0.1:5"), "10.0.0.1");
  EXPECT_EQ(IpOf("unix:/run/x"), "");
  EXPECT_EQ(NetworkOf("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
  EXPECT_EQ(NetworkOf("10.0.0.1"), "10.0.0.1");
  EXPECT_TRUE(IsIp("::1"));
  EXPECT_FALSE(IsIp("1.2.3.4:5678"));
}

TEST(CallersTest, NamesAndAddressesOfOthersHaveShares) {
  Callers callers(0.5, {.memory = 1'000, .requests = 100, .replies = 10});

  const auto named = callers.Of("ed", "ipv4:127.0.0.1:5");
  EXPECT_EQ(callers.Of("ed", "ipv4:10.0.0.1:6"), named) << "wherever he calls from";
  EXPECT_EQ(named->memory->most_bytes(), 500u);
  EXPECT_EQ(named->replies->most_bytes(), 5u);
  EXPECT_EQ(named->ShareOf(64), 32u);
  EXPECT_EQ(named->ShareOf(1), 1u);
  const auto remote = callers.Of("", "ipv4:10.0.0.1:5");
  EXPECT_EQ(callers.Of("", "ipv4:10.0.0.1:77"), remote);
  EXPECT_NE(callers.Of("", "ipv4:10.0.0.2:5"), remote);
  EXPECT_EQ(remote->ShareOf(64), 32u);
  EXPECT_EQ(callers.Of("", "ipv4:127.0.0.1:5")->ShareOf(64), 64u) << "this machine's own";
  EXPECT_EQ(callers.Of("", "ipv4:127.0.0.1:0", true)->ShareOf(64), 32u) << "as a proxy says";
  EXPECT_EQ(callers.Of("", "ipv6:%5B2001::1%5D:5"), callers.Of("", "ipv6:%5B2001::2%5D:6"))
      << "one network";
}

TEST(CallersTest, AnAccountIsForgottenOnceNothingIsChargedToIt) {
  Callers callers(0.5, {.memory = 1'000});
  const auto budget = std::make_shared<MemoryBudget>(1'000);
  auto account = callers.Of("ed", "");
  auto reservation = budget->Reserve("it", 400, account->memory);
  ASSERT_OK(reservation);
  account = nullptr;

  callers.DropUnused();
  EXPECT_EQ(callers.Of("ed", "")->memory->used_bytes(), 400u);

  *reservation = MemoryReservation();
  callers.DropUnused();
  EXPECT_EQ(callers.Of("ed", "")->memory->used_bytes(), 0u);
}

TEST(CallersTest, CallsOfASecondAreCounted) {
  Callers callers(0.5, {});
  const absl::Time now = absl::FromUnixSeconds(1'000);
  const auto ed = callers.Of("ed", "");
  for (uint64_t i = 0; i < limits::kMaxCallsPerSecond; ++i) ASSERT_TRUE(ed->TakeCall(now)) << i;

  EXPECT_FALSE(ed->TakeCall(now + absl::Milliseconds(999)));
  EXPECT_TRUE(callers.Of("rita", "")->TakeCall(now));
  EXPECT_TRUE(ed->TakeCall(now + absl::Seconds(1)));
}

TEST(MemoryAccountTest, AShareIsRefusedWithWhatIsFreeOfIt) {
  const auto budget = std::make_shared<MemoryBudget>(1'000);
  const auto account = std::make_shared<MemoryAccount>(500);
  auto first = budget->Reserve("the first", 300, account);
  ASSERT_OK(first);

  const auto refused = budget->Reserve("the second", 300, account);

  EXPECT_THAT(refused.status(), StatusIs(kExhausted, HasSubstr("200 are free of what one caller")));
  EXPECT_EQ(Reason(refused.status()), "OUT_OF_MEMORY");
  EXPECT_OK(budget->Reserve("another's", 700));
  EXPECT_EQ(account->used_bytes(), 300u);
  EXPECT_OK(first->Resize("the first", 500));
  EXPECT_THAT(first->Resize("the first", 501), StatusIs(kExhausted));
  first->Release();
  EXPECT_EQ(account->used_bytes(), 0u);
}

TEST(MemoryAccountTest, AShortShareEvictsOnlyWhatIsChargedToIt) {
  const auto budget = std::make_shared<MemoryBudget>(1'000);
  const auto account = std::make_shared<MemoryAccount>(500);
  auto old = budget->Reserve("the old", 400, account);
  ASSERT_OK(old);
  std::vector<MemoryShortage> shortages;
  budget->SetEvictor([&](const MemoryShortage& shortage) {
    shortages.push_back(shortage);
    old->Release();
    return true;
  });

  EXPECT_OK(budget->Reserve("the new", 300, account));

  ASSERT_EQ(shortages.size(), 1u);
  EXPECT_EQ(shortages[0].account, account);
  EXPECT_EQ(shortages[0].bytes, 200u);
  budget->SetEvictor(nullptr);
}

TEST(TokenThrottleTest, WaitsGrowPerAddress) {
  TokenThrottle throttle;
  absl::Time now = absl::FromUnixSeconds(1'000);
  for (int i = 0; i <= TokenThrottle::kFree; ++i) {
    EXPECT_EQ(throttle.NoteWrong("ipv4:10.0.0.1", now), absl::ZeroDuration()) << i;
  }
  EXPECT_EQ(throttle.NoteWrong("ipv4:10.0.0.1", now), absl::Milliseconds(100));
  EXPECT_EQ(throttle.NoteWrong("ipv4:10.0.0.2", now), absl::ZeroDuration());
  now += absl::Milliseconds(100);
  EXPECT_EQ(throttle.NoteWrong("ipv4:10.0.0.1", now), absl::ZeroDuration());
  EXPECT_EQ(throttle.NoteWrong("ipv4:10.0.0.1", now), absl::Milliseconds(200));
  for (int i = 0; i < 20; ++i) {
    now += TokenThrottle::kLongest;
    EXPECT_EQ(throttle.NoteWrong("ipv4:10.0.0.1", now), absl::ZeroDuration());
  }
  EXPECT_EQ(throttle.NoteWrong("ipv4:10.0.0.1", now), TokenThrottle::kLongest);

  now += TokenThrottle::kForgotten + absl::Seconds(1);
  throttle.Forget(now);
  EXPECT_EQ(throttle.NoteWrong("ipv4:10.0.0.1", now), absl::ZeroDuration());
  EXPECT_EQ(throttle.NoteWrong("ipv4:10.0.0.1", now), absl::ZeroDuration());
}

// A server of two callers, each with half of the limits.
class TwoCallersTest : public SceneFixture {
 protected:
  const Metadata kEd{{"authorization", "Bearer token-e"}};
  const Metadata kMallory{{"authorization", "Bearer token-m"}};

  void SetUp() override { Start({}); }
  void Start(Options options) {
    folder_.Write("tokens", fmt::format("{} edit ed\n{} edit mallory\n", Sha256Hex("token-e"),
                                        Sha256Hex("token-m")));
    options.token_file = folder_.Path("tokens");
    options.caller_share = 0.5;
    ServerTest::StartServer(std::move(options));
    v1::Mesh mesh;
    ASSERT_OK(ServerTest::Upload(ObjHeader(kGridObj), kGridObj, &mesh, kEd));
    mesh_ = mesh.id();
  }
  absl::Status CreateAs(const Metadata& who, const std::string& id) {
    return Call(&Scenes::CreateScene, SceneRequest(id), nullptr, who);
  }
  absl::Status BeginAs(const Metadata& who, uint64_t bytes, std::string* id = nullptr) {
    v1::BeginUploadRequest request;
    *request.mutable_header() = ObjHeader("");
    request.mutable_header()->set_total_bytes(bytes);
    v1::BeginUploadResponse response;
    const absl::Status status = Call(&Meshes::BeginUpload, request, &response, who);
    if (id != nullptr) *id = response.upload_id();
    return status;
  }

  TemporaryFolder folder_;
};

TEST_F(TwoCallersTest, AnnouncedUploadsTakePlacesButNoMemory) {
  for (int i = 0; i < limits::kMaxUploads / 2; ++i) ASSERT_OK(BeginAs(kMallory, 1 << 30)) << i;

  ExpectRefused(BeginAs(kMallory, 1), kExhausted, "LIMIT_EXCEEDED");

  std::string id;
  ASSERT_OK(BeginAs(kEd, 1 << 20, &id));
  v1::AppendUploadRequest append;
  append.set_upload_id(id);
  append.set_data(std::string(1'000, 'x'));
  EXPECT_OK(Call(&Meshes::AppendUpload, append, nullptr, kEd));
}

TEST_F(TwoCallersTest, BytesThatCameAreChargedToTheirCaller) {
  Start({.memory_bytes = uint64_t{32} << 20});
  std::string id;
  ASSERT_OK(BeginAs(kMallory, 16 << 20, &id));
  ExpectRefused(BeginAs(kMallory, (16 << 20) + 1), kExhausted, "OUT_OF_MEMORY");
  const auto append = [&](const Metadata& who, const std::string& upload, int part) {
    v1::AppendUploadRequest request;
    request.set_upload_id(upload);
    request.set_data(std::string(700'000, 'x'));
    request.set_offset(uint64_t{700'000} * static_cast<uint64_t>(part));
    return Call(&Meshes::AppendUpload, request, nullptr, who);
  };
  for (int i = 0; i < 20; ++i) ASSERT_OK(append(kMallory, id, i));
  std::string second, eds;
  ASSERT_OK(BeginAs(kMallory, 16 << 20, &second));
  for (int i = 0; i < 3; ++i) ASSERT_OK(append(kMallory, second, i));

  EXPECT_THAT(append(kMallory, second, 3),
              StatusIs(kExhausted, HasSubstr("are free of what one caller may use")));
  ASSERT_OK(BeginAs(kEd, 16 << 20, &eds));
  for (int i = 0; i < 20; ++i) ASSERT_OK(append(kEd, eds, i));
  EXPECT_THAT(append(kMallory, second, 3), StatusIs(kExhausted)) << "a refusal changed nothing";
}

TEST_F(TwoCallersTest, ScenesAndWatches) {
  Start({.max_scenes = 4, .max_watchers = 4});
  ASSERT_OK(CreateAs(kMallory, "mallory-1"));
  ASSERT_OK(CreateAs(kMallory, "mallory-2"));
  ExpectRefused(CreateAs(kMallory, "mallory-3"), kExhausted, "LIMIT_EXCEEDED");
  EXPECT_OK(CreateAs(kMallory, "mallory-2")) << "the same again is no other scene";
  ASSERT_OK(CreateAs(kEd, kScene));

  std::vector<std::unique_ptr<WatchClient>> watches;
  for (int i = 0; i < 2; ++i) {
    watches.push_back(std::make_unique<WatchClient>(*scenes_, For<v1::WatchRequest>(), kMallory));
    ASSERT_TRUE(watches.back()->Read());
  }
  ExpectRefused(ReadAll(&Scenes::Watch, For<v1::WatchRequest>(), nullptr, kMallory), kExhausted,
                "LIMIT_EXCEEDED");
  WatchClient ed(*scenes_, For<v1::WatchRequest>(), kEd);
  EXPECT_TRUE(ed.Read());
}

TEST_F(TwoCallersTest, TooManyWrongTokensWaitAndRightOnesPass) {
  const auto call = [&](const char* token) {
    return Call(&Infos::GetServerInfo, {}, nullptr,
                {{"authorization", std::string("Bearer ") + token}});
  };
  for (int i = 0; i <= TokenThrottle::kFree; ++i) {
    ExpectRefused(call("wrong"), absl::StatusCode::kUnauthenticated, "UNAUTHENTICATED");
  }

  const absl::Status throttled = call("wrong");

  ExpectRefused(throttled, kExhausted, "LIMIT_EXCEEDED");
  EXPECT_GT(error::DetailsOf(throttled).retry_after_ms, 0u);
  EXPECT_OK(call("token-e"));
}

TEST_F(TwoCallersTest, WhatNobodyCanParseIsInvalidInEveryRpc) {
  for (const char* rpc :
       {"MeshService/UploadMesh",      "MeshService/BeginUpload",   "MeshService/AppendUpload",
        "MeshService/FinishUpload",    "MeshService/GetMesh",       "MeshService/ListMeshes",
        "MeshService/DeleteMesh",      "MeshService/DownloadMesh",  "SceneService/CreateScene",
        "SceneService/GetScene",       "SceneService/ListScenes",   "SceneService/DeleteScene",
        "SceneService/GetLattice",     "SceneService/GetTopology",  "SceneService/GetPatchPlan",
        "SceneService/ApplyEdits",     "SceneService/Deform",       "SceneService/Watch",
        "SceneService/GetUpdate",      "SceneService/ControlWatch", "SceneService/Export",
        "SceneService/EvaluatePoints", "SceneService/Pick",         "SceneService/CertifyFolds",
        "ServerService/GetServerInfo", "BackupService/Backup",      "BackupService/Restore",
        "ShareService/CreateShare",    "ShareService/ListShares",   "ShareService/RevokeShare"}) {
    const std::string method = std::string("/latticed.v1.") + rpc;
    const grpc::Status status =
        RawCall(server_->channel(), method, "\xff\xff\xff", nullptr, "Bearer token-e");

    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT)
        << rpc << " " << status.error_message();
    EXPECT_THAT(status.error_message(), HasSubstr("cannot be parsed")) << rpc;
    EXPECT_EQ(RawCall(server_->channel(), method, "\xff\xff\xff").error_code(),
              grpc::StatusCode::UNAUTHENTICATED)
        << rpc << ": strangers' bytes are not parsed";
  }
}

}  // namespace
}  // namespace latticed::testing
