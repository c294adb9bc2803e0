// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The metrics that Prometheus reads, compared with what clients did through their stubs.
#include <map>
#include <memory>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/cpu/cpu_backend.h"
#include "fmt/format.h"
#include "server/store/memory_store.h"
#include "tests/server/support/server_test.h"
#include "tests/support/becomes.h"
#include "tests/support/temporary_folder.h"

namespace latticed::testing {
namespace {

// One scrape: the values by series, "name{label="value",…}". Fails the test when a line is not in the
// text format, a series comes twice, or a sample has no type.
class Scrape {
 public:
  explicit Scrape(const InProcessServer& server) : text(server.metrics()) {
    static const std::regex kComment(R"(# (HELP|TYPE) ([a-z_]+) (.+))");
    static const std::regex kSample(
        R"re(([a-z_]+)((\{[a-z_]+="[^"\\]*"(,[a-z_]+="[^"\\]*")*\})?) ([-+.0-9a-zA-Z]+)( \d+)?)re");
    for (const std::string& line : std::vector<std::string>(absl::StrSplit(text, '\n'))) {
      std::smatch match;
      if (line.empty()) continue;
      if (std::regex_match(line, match, kComment)) {
        if (match[1] == "TYPE") types[match[2]] = match[3];
      } else if (std::regex_match(line, match, kSample)) {
        double value = 0;
        EXPECT_TRUE(absl::SimpleAtod(match[5].str(), &value)) << line;
        EXPECT_TRUE(values.emplace(match[1].str() + match[2].str(), value).second) << line;
        static const std::regex kPart("_(bucket|sum|count)$");
        const std::string family = std::regex_replace(match[1].str(), kPart, "");
        EXPECT_TRUE(types.contains(match[1]) || types[family] == "histogram") << line;
      } else {
        ADD_FAILURE() << "not of the text format: " << line;
      }
    }
  }

  // 0 for a series that does not exist.
  double operator[](const std::string& series) const {
    const auto found = values.find(series);
    return found == values.end() ? 0 : found->second;
  }

  std::string text;
  std::map<std::string, std::string> types;
  std::map<std::string, double> values;
};

using MetricsTest = SceneStreamTest;
using EmptyServerMetricsTest = StreamTest;

class StoreMetricsTest : public SceneFixture {
 protected:
  void SetUp() override {
    StartServerOn(MakeCpuBackend({.threads = 1}), TestOptions(), store_);
    mesh_ = Upload(kGridObj);
    ASSERT_OK(Create(SceneRequest()));
  }

  const std::shared_ptr<MemoryStore> store_ = std::make_shared<MemoryStore>();
};

TEST_F(MetricsTest, TypesAndNamesFollowTheConventions) {
  const Scrape scrape(*server_);

  EXPECT_GE(scrape.types.size(), 30u);
  for (const auto& [name, type] : scrape.types) {
    EXPECT_TRUE(name.starts_with("latticed_") || name.starts_with("process_")) << name;
    EXPECT_EQ(type == "counter", name.ends_with("_total")) << name;
  }
}

TEST_F(MetricsTest, StoresMemoryAndProcessAreThoseOfTheScrape) {
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);

  const v1::ServerInfo info = Info();
  const Scrape scrape(*server_);

  EXPECT_EQ(scrape["latticed_scenes"], 1);
  EXPECT_EQ(scrape["latticed_watchers"], 1);
  EXPECT_EQ(scrape["latticed_meshes"], 1);
  EXPECT_EQ(scrape["latticed_uploads"], 0);
  EXPECT_EQ(scrape["latticed_device_healthy"], 1);
  EXPECT_EQ(scrape["latticed_draining"], 0);
  EXPECT_EQ(scrape["latticed_log_lines_dropped_total"], 0);
  EXPECT_EQ(scrape[fmt::format(R"(latticed_build_info{{version="{}",commit="{}",backend="cpu"}})",
                               info.version(), info.commit())],
            1);
  ASSERT_TRUE(info.host_bytes().contains("plan"));
  for (const auto& [purpose, bytes] : info.host_bytes()) {
    EXPECT_EQ(scrape[fmt::format(R"(latticed_host_memory_bytes{{purpose="{}"}})", purpose)],
              static_cast<double>(bytes))
        << purpose;
  }
  EXPECT_EQ(scrape["latticed_host_memory_free_bytes"],
            static_cast<double>(info.limits().max_host_bytes() - info.reserved_host_bytes()));
  EXPECT_GT(scrape["process_resident_memory_bytes"], 1 << 20);
  EXPECT_GT(scrape["process_virtual_memory_bytes"], scrape["process_resident_memory_bytes"]);
  EXPECT_GT(scrape["process_cpu_seconds_total"], 0);
  EXPECT_GT(scrape["process_threads"], 2);
  EXPECT_GE(scrape["process_open_fds"], 3);
  EXPECT_GT(scrape["process_max_fds"], scrape["process_open_fds"]);
  const double now = absl::ToDoubleSeconds(absl::Now() - absl::UnixEpoch());
  EXPECT_NEAR(scrape["process_start_time_seconds"], now, 3'600);
}

TEST_F(MetricsTest, EditsAndUpdatesAreCountedByWhatBecameOfThem) {
  DeformClient client(*scenes_, Watch());
  client.ReadUntilRevision(0);
  v1::EditBatch stale = Move(3, 62, 0.1);
  stale.set_structure_id(structure_id_ + 1);

  ASSERT_TRUE(client.Send(Move(1, 62, 0.1)));
  client.ReadUntilRevision(1);
  ASSERT_TRUE(client.Send(Move(2, 62, 0.1)));
  client.ReadUntilRevision(2);
  ASSERT_TRUE(client.Send(Move(2, 62, 0.1)));  // sequence 2 again
  ASSERT_TRUE(client.Send(stale));
  client.ReadUntil([&] { return client.log.results.size() == 4; });
  client.HalfClose();
  ASSERT_TRUE(client.Finish().ok());
  const Scrape scrape(*server_);

  EXPECT_EQ(scrape[R"(latticed_edits_total{result="applied"})"], 2);
  EXPECT_EQ(scrape[R"(latticed_edits_total{result="refused"})"], 1);
  EXPECT_EQ(scrape[R"(latticed_edits_total{result="repeated"})"], 1);
  EXPECT_EQ(scrape[R"(latticed_refusals_total{reason="STRUCTURE_CHANGED"})"], 1);
  EXPECT_EQ(scrape["latticed_updates_begun_total"], static_cast<double>(client.log.begins.size()));
  EXPECT_EQ(scrape["latticed_updates_finished_total"], static_cast<double>(client.log.ends.size()));
  double bytes = 0;
  for (const v1::SceneEvent& event : client.log.events) {
    for (const v1::Chunk& chunk : event.chunks().chunks()) {
      bytes += static_cast<double>(chunk.data().size());
    }
  }
  EXPECT_EQ(scrape["latticed_chunk_bytes_total"], bytes);
}

TEST_F(MetricsTest, CallsAreCountedByRpcAndCode) {
  for (const char* id : {kScene, "no-such-scene"}) {
    (void)Call(&Scenes::GetScene, For<v1::GetSceneRequest>(id));
  }
  ASSERT_OK(Apply(Move(1, 62, 0.1)));

  const Scrape scrape(*server_);

  EXPECT_EQ(scrape[R"(latticed_rpc_started_total{method="SceneService/GetScene"})"], 2);
  EXPECT_TRUE(scrape.values.contains(R"(latticed_rpc_started_total{method="SceneService/Watch"})"))
      << "as 0, before its first call";
  EXPECT_EQ(scrape[R"(latticed_rpc_finished_total{method="SceneService/GetScene",code="OK"})"], 1);
  EXPECT_EQ(
      scrape[R"(latticed_rpc_finished_total{method="SceneService/GetScene",code="NOT_FOUND"})"], 1);
  EXPECT_EQ(scrape[R"(latticed_rpc_finished_total{method="SceneService/ApplyEdits",code="OK"})"],
            1);
  EXPECT_EQ(scrape[R"(latticed_rpc_duration_seconds_count{method="SceneService/GetScene"})"], 2);
  EXPECT_EQ(scrape[R"(latticed_refusals_total{reason="NOT_FOUND"})"], 1);
  EXPECT_EQ(scrape[R"(latticed_refusals_total{reason="OUT_OF_MEMORY"})"], 0);
}

TEST_F(EmptyServerMetricsTest, WhatTheBudgetRefusesIsCounted) {
  ServerTest::StartServer({.memory_bytes = 1'000'000});
  v1::BeginUploadRequest request;
  request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
  request.mutable_header()->set_total_bytes(1'000'000);
  v1::BeginUploadResponse upload;
  ASSERT_OK(Call(&Meshes::BeginUpload, request, &upload));
  v1::AppendUploadRequest append;
  append.set_upload_id(upload.upload_id());
  append.set_data(std::string(50'000, 'v'));
  ASSERT_OK(Call(&Meshes::AppendUpload, append));
  request.mutable_header()->set_total_bytes(1'000'001);
  for (int i = 0; i < 2; ++i) {
    EXPECT_THAT(Call(&Meshes::BeginUpload, request),
                StatusIs(absl::StatusCode::kResourceExhausted));
  }

  const Scrape scrape(*server_);

  EXPECT_EQ(scrape[R"(latticed_refusals_total{reason="OUT_OF_MEMORY"})"], 2);
  EXPECT_EQ(scrape["latticed_uploads"], 1);
  EXPECT_EQ(scrape["latticed_host_memory_reserved_bytes"], 50'000);
  EXPECT_EQ(scrape["latticed_host_memory_budget_bytes"], 1'000'000);
}

TEST_F(MetricsTest, AServerWithoutAStoreSaysSo) {
  const Scrape scrape(*server_);

  EXPECT_TRUE(scrape.values.contains("latticed_durable"));
  EXPECT_EQ(scrape["latticed_durable"], 0);
  EXPECT_FALSE(scrape.types.contains("latticed_store_writable"));
}

TEST_F(StoreMetricsTest, WhatTheStoreTookAndRefusedIsCounted) {
  ASSERT_OK(Apply(Move("ann", 1, 5, 0.1)));
  ASSERT_OK(Apply(Move("ann", 2, 5, 0.1)));
  store_->Flush();
  const Scrape before(*server_);
  store_->Pause();
  std::thread edit([this] {
    EXPECT_THAT(Apply(Move("ann", 3, 5, 0.1)), StatusIs(absl::StatusCode::kUnavailable));
  });
  EXPECT_TRUE(Becomes(500, [&] { return Scrape(*server_)["latticed_store_waiting_bytes"] > 0; }));
  store_->SetFailure(absl::UnavailableError("a cable was pulled"));
  store_->Resume();
  edit.join();
  const Scrape after(*server_);

  EXPECT_EQ(before["latticed_durable"], 1);
  EXPECT_EQ(before["latticed_store_writable"], 1);
  EXPECT_EQ(before[R"(latticed_store_appends_total{result="stored"})"], 2);
  EXPECT_EQ(before[R"(latticed_store_appends_total{result="refused"})"], 0);
  EXPECT_GT(before[R"(latticed_store_bytes_total{kind="record"})"], 40);
  EXPECT_EQ(after[R"(latticed_store_appends_total{result="stored"})"], 2);
  EXPECT_EQ(after[R"(latticed_store_appends_total{result="refused"})"], 1);
  EXPECT_EQ(after["latticed_store_scenes_broken_total"], 1);
  EXPECT_EQ(after["latticed_store_writable"], 0);
  EXPECT_EQ(before["latticed_store_failures_total"], 0);
  EXPECT_EQ(after["latticed_store_failures_total"], 1);
}

TEST_F(EmptyServerMetricsTest, AFolderShowsWhatItWritesAndWhatSleeps) {
  const TemporaryFolder folder;
  Options options = TestOptions();
  options.data_dir = folder.Path("data");
  const auto start = [&] {
    server_.reset();
    ServerTest::StartServer(options);
    mesh_ = Upload(kGridObj);
  };
  start();
  ASSERT_OK(Create(SceneRequest()));
  const Scrape before(*server_);
  for (uint64_t n = 1; n <= 3; ++n) ASSERT_OK(Apply(MoveOne("ann", n, 5, {0.1, 0, 0})));
  EXPECT_TRUE(Becomes(500, [&] { return Metric("latticed_store_waiting_writes") == 0; }));
  const Scrape after(*server_);
  start();
  const Scrape restarted(*server_);

  const auto grown = [&](const std::string& series) { return after[series] - before[series]; };
  EXPECT_EQ(after["latticed_durable"], 1);
  EXPECT_EQ(grown(R"(latticed_store_appends_total{result="stored"})"), 3);
  EXPECT_EQ(grown("latticed_store_commit_duration_seconds_count"), 3);
  const double records = grown(R"(latticed_store_bytes_total{kind="record"})");
  EXPECT_GT(records, 3 * 20);
  EXPECT_LT(records, 3 * 200);
  EXPECT_GE(grown("latticed_store_log_bytes_total"), 3 * 4'120) << "a page for each commit";
  EXPECT_LE(grown("latticed_store_log_bytes_total"), 3 * 3 * 4'120);
  EXPECT_EQ(after["latticed_store_waiting_bytes"], 0);
  EXPECT_EQ(after["latticed_scenes"], 1);
  EXPECT_EQ(after["latticed_scenes_asleep"], 0);
  EXPECT_EQ(restarted["latticed_scenes"], 0);
  EXPECT_EQ(restarted["latticed_scenes_asleep"], 1);
}

TEST_F(MetricsTest, WordsOfClientsAreInNoLabel) {
  DeformClient client(*scenes_, Watch("an-editor"));
  client.ReadUntilRevision(0);

  const Scrape scrape(*server_);

  for (const std::string& word : {std::string(kScene), mesh_, std::string("an-editor")}) {
    EXPECT_EQ(scrape.text.find(word), std::string::npos) << word;
  }
}

}  // namespace
}  // namespace latticed::testing
