// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// --quota-file: what tenants may have, what they are told when it is used up, and where operators see it.
#include <future>
#include <memory>
#include <utility>

#include <gmock/gmock.h>

#include "absl/time/clock.h"
#include "core/base/sha256.h"
#include "core/cpu/cpu_backend.h"
#include "fmt/format.h"
#include "server/base/quotas/tenant_quotas.h"
#include "tests/server/points/point_set_client.h"
#include "tests/server/support/server_test.h"
#include "tests/server/support/slow_mesh_store.h"
#include "tests/support/becomes.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

using ::testing::HasSubstr;

constexpr int kManyLooks = 6'000;  // a minute
constexpr char kAcme[] = "of-acme", kBeta[] = "of-beta";

Metadata As(const std::string& token) { return {{"authorization", "Bearer " + token}}; }

void ExpectQuota(const absl::Status& status, const std::string& what, uint64_t quota, uint64_t used,
                 uint64_t asked) {
  const error::Details details = error::DetailsOf(status);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted));
  EXPECT_EQ(details.reason, "QUOTA_EXCEEDED");
  auto of = details.metadata;
  EXPECT_EQ(of["what"], what);
  EXPECT_EQ(of["allowed"], fmt::to_string(quota));
  EXPECT_EQ(of["used"], fmt::to_string(used));
  EXPECT_EQ(of["asked"], fmt::to_string(asked));
}

TEST(QuotaTableTest, TenantsHaveTheirEntryOrThatOfAll) {
  const auto table =
      QuotaTable::FromText(R"({"acme": {"scenes": 3}, "": {"scenes": 0}, "*": {"watchers": 7}})");
  ASSERT_OK(table);

  EXPECT_EQ(table->Of("acme").Of(QuotaKind::kScenes), 3);
  EXPECT_EQ(table->Of("acme").Of(QuotaKind::kWatchers), std::nullopt);
  EXPECT_EQ(table->Of("").Of(QuotaKind::kScenes), 0);
  EXPECT_EQ(table->Of("beta").Of(QuotaKind::kWatchers), 7);
  EXPECT_EQ(QuotaTable().Of("acme").Of(QuotaKind::kScenes), std::nullopt);
}

TEST(QuotaTableTest, RefusesWhatItDoesNotKnow) {
  for (const auto& [text, problem] :
       {std::pair("rubbish", "no JSON object"),
        {"[]", "no JSON object"},
        {R"({"Acme": {}})", "'Acme' is no tenant"},
        {R"({"acme": 3})", "entry of 'acme'"},
        {R"({"acme": {"scene": 3}})", "'scene' of 'acme' is not one of scenes, mesh_bytes"},
        {R"({"acme": {"scenes": -1}})", "'scenes' of 'acme'"},
        {R"({"acme": {"scenes": 1.5}})", "'scenes' of 'acme'"},
        {R"({"acme": {"scenes": "3"}})", "'scenes' of 'acme'"}}) {
    EXPECT_THAT(QuotaTable::FromText(text),
                StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr(problem)))
        << text;
  }
}

TEST(TenantQuotasTest, ARateIsFilledAgainInASecond) {
  TenantQuotas quotas;
  quotas.SetTable(*QuotaTable::FromText(
      R"({"acme": {"edits_per_second": 4, "bytes_per_second": 1000, "watchers": 1}})"));
  const absl::Time start = absl::FromUnixSeconds(1'700'000'000);
  for (int i = 0; i < 4; ++i) EXPECT_OK(quotas.TakeEdit("acme", start));
  const absl::Status refused = quotas.TakeEdit("acme", start);
  ExpectQuota(refused, "edits_per_second", 4, 4, 1);
  EXPECT_EQ(error::DetailsOf(refused).retry_after_ms, 250u);
  EXPECT_OK(quotas.TakeEdit("beta", start)) << "no quota";
  EXPECT_OK(quotas.TakeEdit("acme", start + absl::Milliseconds(250)));
  EXPECT_FALSE(quotas.TakeEdit("acme", start + absl::Milliseconds(250)).ok());
  EXPECT_OK(quotas.TakeEdit("acme", start + absl::Hours(1)));
  EXPECT_EQ(quotas.Refused("acme", QuotaKind::kEditsPerSecond), 2u);

  EXPECT_EQ(quotas.TakeBytes("acme", 1'000, start), start);
  EXPECT_EQ(quotas.TakeBytes("acme", 500, start), start + absl::Milliseconds(500));
  EXPECT_OK(quotas.OpenStream("acme", false, start)) << "it has to wait, but not long";
  EXPECT_EQ(quotas.TakeBytes("acme", 1'500, start), start + absl::Seconds(2));
  const auto stream = quotas.OpenStream("acme", false, start).status();
  ExpectQuota(stream, "bytes_per_second", 1'000, 3'000, 1);
  EXPECT_EQ(error::DetailsOf(stream).retry_after_ms, 2'000u);
  EXPECT_OK(quotas.OpenStream("acme", false, start + absl::Seconds(1)));

  const absl::Time later = start + absl::Minutes(1);
  auto place = quotas.OpenStream("acme", true, later);
  ASSERT_OK(place);
  ExpectQuota(quotas.OpenStream("acme", true, later).status(), "watchers", 1, 1, 1);
  EXPECT_EQ(quotas.Used("acme", QuotaKind::kWatchers, later), 1u);
  *place = nullptr;
  EXPECT_OK(quotas.OpenStream("acme", true, later));
}

class QuotaTest : public ServerTest {
 protected:
  void Start(const std::string& quotas, std::shared_ptr<Store> store = nullptr) {
    options_ = TestOptions();
    options_.caller_share = 1;
    options_.heartbeat_interval = absl::Seconds(1);  // a watcher that sends none is paused after 3
    options_.token_file = folder_.Write(
        "tokens",
        fmt::format("{} admin ada acme\n{} edit bob beta\n", Sha256Hex(kAcme), Sha256Hex(kBeta)));
    options_.quota_file = folder_.Write("quotas", quotas);
    if (store == nullptr) return StartServer(options_);
    StartServerOn(MakeCpuBackend({.threads = 1}), options_, std::move(store));
  }
  // Of CubeObj(1); also uploads it.
  size_t UploadCube(const char* token = kAcme) {
    v1::Mesh mesh;
    EXPECT_OK(UploadCube(1, token, &mesh));
    mesh_ = mesh.id();
    return CubeObj(1).size();
  }
  absl::Status UploadCube(double edge, const char* token, v1::Mesh* mesh = nullptr) {
    const std::string obj = CubeObj(edge);
    return Upload(ObjHeader(obj), obj, mesh, As(token));
  }
  absl::Status CreateAs(const char* token, const std::string& id) {
    return Call(&Scenes::CreateScene, SceneRequest(id), nullptr, As(token));
  }
  v1::ServerInfo InfoOf(const char* token) {
    v1::ServerInfo info;
    EXPECT_OK(Call(&Infos::GetServerInfo, {}, &info, As(token)));
    return info;
  }

  TemporaryFolder folder_;
  Options options_;
};

TEST_F(QuotaTest, Scenes) {
  Start(R"({"acme": {"scenes": 2}})");
  UploadCube(kBeta);
  UploadCube();
  ASSERT_OK(CreateAs(kAcme, "scene-a"));
  ASSERT_OK(CreateAs(kAcme, "scene-b"));

  ExpectQuota(CreateAs(kAcme, "scene-c"), "scenes", 2, 2, 1);
  EXPECT_OK(CreateAs(kAcme, "scene-b")) << "it is there already";
  for (const char* id : {"scene-a", "scene-b", "scene-c"}) EXPECT_OK(CreateAs(kBeta, id));
  EXPECT_OK(Call(&Scenes::DeleteScene, For<v1::DeleteSceneRequest>("scene-a"), nullptr, As(kAcme)));
  EXPECT_OK(CreateAs(kAcme, "scene-c"));
}

TEST_F(QuotaTest, PointSetBytes) {
  Start(R"({"acme": {"point_set_bytes": 3000}})");
  UploadCube(kBeta);
  UploadCube();
  ASSERT_OK(CreateAs(kAcme, kScene));
  ASSERT_OK(CreateAs(kBeta, kScene));
  PointSetClient acme(server_->channel(), As(kAcme)), beta(server_->channel(), As(kBeta));
  const std::vector<Vec3d> points(100);
  const auto set = acme.CreateWorld(points);
  ASSERT_OK(set);

  ExpectQuota(acme.CreateWorld(points).status(), "point_set_bytes", 3000, set->bytes(), 2800);
  EXPECT_OK(beta.CreateWorld(points));
  ASSERT_OK(acme.Delete(set->id()));
  EXPECT_OK(acme.CreateWorld(points));
}

TEST_F(QuotaTest, MeshBytes) {
  const size_t bytes = CubeObj(1).size(), most = 2 * bytes;
  ASSERT_EQ(CubeObj(2).size(), bytes);
  ASSERT_EQ(CubeObj(3).size(), bytes);
  Start(fmt::format(R"({{"acme": {{"mesh_bytes": {}}}}})", most));
  UploadCube();
  v1::Mesh second;
  ASSERT_OK(UploadCube(2, kAcme, &second));

  ExpectQuota(UploadCube(3, kAcme), "mesh_bytes", most, most, bytes);
  EXPECT_OK(UploadCube(2, kAcme)) << "it is there already";
  EXPECT_OK(UploadCube(3, kBeta));
  v1::BeginUploadRequest begin;
  *begin.mutable_header() = ObjHeader(std::string(most + 1, ' '));
  ExpectQuota(Call(&Meshes::BeginUpload, begin, nullptr, As(kAcme)), "mesh_bytes", most, 0,
              most + 1);
  v1::DeleteMeshRequest remove;
  remove.set_mesh(second.id());
  ASSERT_OK(Call(&Meshes::DeleteMesh, remove, nullptr, As(kAcme)));
  EXPECT_OK(UploadCube(3, kAcme));
}

TEST_F(QuotaTest, AMeshThatIsBeingStoredCountsAndDelaysNoOther) {
  const size_t bytes = CubeObj(1).size(), most = 2 * bytes;
  const auto store = std::make_shared<SlowMeshStore>();
  Start(fmt::format(R"({{"acme": {{"mesh_bytes": {}}}}})", most), store);
  auto first = std::async(std::launch::async, [&] { return UploadCube(1, kAcme); });
  store->AwaitCall();

  v1::Mesh second;
  EXPECT_OK(UploadCube(2, kAcme, &second));
  ExpectQuota(UploadCube(3, kAcme), "mesh_bytes", most, most, bytes);
  EXPECT_OK(UploadCube(3, kBeta));
  v1::DeleteMeshRequest remove;
  remove.set_mesh(second.id());
  EXPECT_OK(Call(&Meshes::DeleteMesh, remove, nullptr, As(kAcme)));

  auto same = std::async(std::launch::async, [&] { return UploadCube(1, kAcme); });
  store->LetGo();
  EXPECT_OK(first.get());
  EXPECT_OK(same.get());
  EXPECT_EQ(InfoOf(kAcme).quotas(0).used(), bytes);
}

TEST_F(QuotaTest, EditsOfCallsAndOfStreams) {
  Start(R"({"acme": {"edits_per_second": 2}})");
  UploadCube();
  ASSERT_OK(CreateAs(kAcme, kScene));
  const auto edit = [&](uint64_t sequence) {
    return Call(&Scenes::ApplyEdits, MoveOne("ed", sequence, 3, {1, 0, 0}), nullptr, As(kAcme));
  };
  // Two a second: of ten that come faster, some are refused.
  absl::Status refused;
  for (uint64_t i = 1; i <= 10 && refused.ok(); ++i) refused = edit(i);
  EXPECT_EQ(Reason(refused), "QUOTA_EXCEEDED");
  EXPECT_GT(error::DetailsOf(refused).retry_after_ms, 0u);

  DeformClient deform(*scenes_, For<v1::WatchRequest>(), As(kAcme));
  for (uint64_t i = 1; i <= 10; ++i) ASSERT_TRUE(deform.Send(MoveOne("eve", i, 3, {1, 0, 0})));
  deform.ReadUntil([&] { return deform.log.results.size() == 10; });
  const auto& last = deform.log.results.back();
  EXPECT_EQ(last.status().code(), static_cast<int>(absl::StatusCode::kResourceExhausted));
  EXPECT_THAT(last.status().message(), HasSubstr("quota of edits_per_second is 2"));
}

TEST_F(QuotaTest, Watchers) {
  Start(R"({"acme": {"watchers": 1}})");
  UploadCube();
  ASSERT_OK(CreateAs(kAcme, kScene));
  {
    WatchClient first(*scenes_, For<v1::WatchRequest>(), As(kAcme));
    first.ReadUpdates(1);
    WatchClient second(*scenes_, For<v1::WatchRequest>(), As(kAcme));
    ExpectQuota(second.Finish(), "watchers", 1, 1, 1);
    EXPECT_OK(ReadAll(&Scenes::GetUpdate, For<v1::GetUpdateRequest>(), nullptr, As(kAcme)));
    EXPECT_EQ(InfoOf(kAcme).quotas(0).used(), 1u);
  }
  // The place is free when the call is done.
  EXPECT_TRUE(Becomes(kManyLooks, [&] {
    WatchClient again(*scenes_, For<v1::WatchRequest>(), As(kAcme));
    return again.Read();
  }));
}

TEST_F(QuotaTest, BytesAreSentInTimeOrNotBegun) {
  constexpr uint64_t kRate = 500'000;
  Start(fmt::format(R"({{"acme": {{"bytes_per_second": {}}}}})", kRate));
  std::string obj = WavyGridObj(8);
  obj.resize(2 * limits::kMaxPartBytes, '\n');  // two parts
  v1::Mesh mesh;
  ASSERT_OK(Upload(ObjHeader(obj), obj, &mesh, As(kAcme)));
  v1::DownloadMeshRequest request;
  request.set_mesh(mesh.id());
  const absl::Time start = absl::Now();
  std::vector<v1::DownloadMeshResponse> parts;
  EXPECT_OK(ReadAll(&Meshes::DownloadMesh, request, &parts, As(kAcme)));
  const double seconds = absl::ToDoubleSeconds(absl::Now() - start);

  std::string bytes;
  for (const auto& part : parts) bytes += part.data();
  EXPECT_EQ(bytes, obj);
  // The second part waits until what the first one took beyond a second's worth is filled again.
  EXPECT_GE(seconds, static_cast<double>(limits::kMaxPartBytes) / kRate - 1);
  // A machine that stalls for a second fills it, too.
  absl::Status refused;
  for (int i = 0; i < 10 && refused.ok(); ++i) {
    refused = ReadAll(&Meshes::DownloadMesh, request, nullptr, As(kAcme));
  }
  EXPECT_EQ(Reason(refused), "QUOTA_EXCEEDED") << refused;
  EXPECT_GT(error::DetailsOf(refused).retry_after_ms, 0u);
  EXPECT_OK(Call(&Infos::GetServerInfo, {}, nullptr, As(kAcme))) << "small replies always go";
}

// A client takes silence for a cut, and would ask for all again.
TEST_F(QuotaTest, HeartbeatsDoNotWaitForBytes) {
  Start(R"({"acme": {"bytes_per_second": 60000}})");
  UploadCube();
  ASSERT_OK(CreateAs(kAcme, kScene));
  auto request = For<v1::WatchRequest>();
  request.mutable_view()->set_encoding(v1::ENCODING_RAW);
  request.mutable_view()->set_segments(16);
  const absl::Duration kMostSilence = absl::Seconds(1.8);  // there is a heartbeat a second
  // The least of several attempts, because the machine may stall in one.
  absl::Duration least = absl::InfiniteDuration();
  for (int i = 0; i < 5 && least >= kMostSilence; ++i) {
    WatchClient watcher(*scenes_, request, As(kAcme));
    absl::Duration silence, all;
    while (watcher.log.ends.empty()) {
      const absl::Time before = absl::Now();
      ASSERT_TRUE(watcher.Read());
      silence = std::max(silence, absl::Now() - before);
      all += absl::Now() - before;
    }
    EXPECT_GT(all, absl::Seconds(1.5)) << "the quota holds the end of the update back";
    EXPECT_GT(watcher.log.heartbeats, 0u);
    least = std::min(least, silence);
  }
  EXPECT_LT(least, kMostSilence);
}

TEST_F(QuotaTest, OperatorsAndTenantsSeeIt) {
  Start(R"({"acme": {"scenes": 5, "mesh_bytes": 100000}, "*": {"scenes": 1}})");
  const size_t bytes = UploadCube();
  ASSERT_OK(CreateAs(kAcme, kScene));

  const v1::ServerInfo info = InfoOf(kAcme);
  EXPECT_EQ(info.tenant(), "acme");
  ASSERT_EQ(info.quotas_size(), 2);
  EXPECT_EQ(info.quotas(0).what(), "scenes");
  EXPECT_EQ(info.quotas(0).quota(), 5u);
  EXPECT_EQ(info.quotas(0).used(), 1u);
  EXPECT_EQ(info.quotas(1).used(), bytes);
  EXPECT_EQ(InfoOf(kBeta).quotas_size(), 1);
  EXPECT_EQ(InfoOf(kBeta).quotas(0).used(), 0u);
  EXPECT_EQ(Metric(R"(latticed_tenant_quota{tenant="acme",what="scenes"})"), 5);
  EXPECT_EQ(Metric(R"(latticed_tenant_used{tenant="acme",what="scenes"})"), 1);
  EXPECT_EQ(Metric(R"(latticed_tenant_refused_total{tenant="acme",what="scenes"})"), 0);
}

TEST_F(QuotaTest, AReplacedFileCountsAndRubbishDoesNot) {
  Start(R"({"acme": {"scenes": 0}})");
  UploadCube();
  ASSERT_FALSE(CreateAs(kAcme, "scene-a").ok());
  folder_.Write("quotas", "rubbish");
  EXPECT_THAT(server_->Reload(options_),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--quota-file")));
  ExpectQuota(CreateAs(kAcme, "scene-a"), "scenes", 0, 0, 1);

  folder_.Write("quotas", R"({"acme": {"scenes": 1}})");
  EXPECT_OK(server_->Reload(options_));
  EXPECT_OK(CreateAs(kAcme, "scene-a"));
  ExpectQuota(CreateAs(kAcme, "scene-b"), "scenes", 1, 1, 1);
  folder_.Write("quotas", R"({"acme": {"scenes": 2, "watchers": 1}})");
  EXPECT_TRUE(Becomes(kManyLooks, [&] { return CreateAs(kAcme, "scene-b").ok(); }))
      << "it is looked at once a second";
}

TEST_F(QuotaTest, AServerDoesNotStartWithRubbish) {
  Options options = TestOptions();
  options.quota_file = folder_.Write("quotas", "{");
  EXPECT_THAT(InProcessServer::Start(options).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("--quota-file")));
}

}  // namespace
}  // namespace latticed::testing
