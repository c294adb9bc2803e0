// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a Prometheus reads, beside what clients did through their stubs.
#include <map>
#include <memory>
#include <regex>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "fmt/format.h"
#include "latticed/v1/server.grpc.pb.h"
#include "tests/server/watch_client.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

// A scrape: values by series, "name{label="value",…}". Fails the test where a line is not of the
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

  // 0 for a series that is not there.
  double operator[](const std::string& series) const {
    const auto found = values.find(series);
    return found == values.end() ? 0 : found->second;
  }

  std::string text;
  std::map<std::string, std::string> types;
  std::map<std::string, double> values;
};

class MetricsTest : public StreamTest {};

TEST_F(MetricsTest, TypesAndNamesFollowTheConventions) {
  CreateScene();

  const Scrape scrape(*server_);

  EXPECT_GE(scrape.types.size(), 30u);
  for (const auto& [name, type] : scrape.types) {
    EXPECT_TRUE(name.starts_with("latticed_") || name.starts_with("process_")) << name;
    EXPECT_EQ(type == "counter", name.ends_with("_total")) << name;
  }
}

TEST_F(MetricsTest, StoresMemoryAndProcessAreThoseOfTheScrape) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);

  const v1::ServerInfo info = Info();
  const Scrape scrape(*server_);

  EXPECT_EQ(scrape["latticed_scenes"], 1);
  EXPECT_EQ(scrape["latticed_watchers"], 1);
  EXPECT_EQ(scrape["latticed_meshes"], 1);
  EXPECT_EQ(scrape["latticed_uploads"], 0);
  EXPECT_EQ(scrape["latticed_device_healthy"], 1);
  EXPECT_EQ(scrape["latticed_draining"], 0);
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
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);
  v1::EditBatch stale = Move(3, 62, 0.1);
  stale.set_structure_id(structure_id_ + 1);

  ASSERT_TRUE(client.Send(Move(1, 62, 0.1)));
  client.ReadUntilRevision(1);
  ASSERT_TRUE(client.Send(Move(2, 62, 0.1)));
  client.ReadUntilRevision(2);
  ASSERT_TRUE(client.Send(Move(2, 62, 0.1)));  // once more
  ASSERT_TRUE(client.Send(stale));
  client.ReadUntil([&] { return client.log.results.size() == 4; });
  client.HalfClose();
  ASSERT_TRUE(client.Finish().ok());
  const Scrape scrape(*server_);

  EXPECT_EQ(scrape[R"(latticed_edits_total{result="applied"})"], 2);
  EXPECT_EQ(scrape[R"(latticed_edits_total{result="refused"})"], 1);
  EXPECT_EQ(scrape[R"(latticed_edits_total{result="repeated"})"], 1);
  EXPECT_EQ(scrape[R"(latticed_refusals_total{reason="STRUCTURE_CHANGED"})"], 1);
  EXPECT_EQ(scrape["latticed_revisions_merged_total"], 0) << "every one was waited for";
  EXPECT_EQ(scrape["latticed_evaluations_total"], 3) << "of revisions 0, 1 and 2";
  EXPECT_EQ(scrape["latticed_updates_begun_total"], static_cast<double>(client.log.begins.size()));
  EXPECT_EQ(scrape["latticed_updates_finished_total"], static_cast<double>(client.log.ends.size()));
  EXPECT_EQ(scrape["latticed_updates_restarted_total"], 0);
  EXPECT_EQ(scrape["latticed_updates_superseded_total"], 0);
  EXPECT_EQ(scrape["latticed_snapshots_retired_total"], 0);
  EXPECT_EQ(scrape["latticed_undo_steps_forgotten_total"], 0);
  double bytes = 0;
  for (const v1::SceneEvent& event : client.log.events) {
    for (const v1::Chunk& chunk : event.chunks().chunks()) {
      bytes += static_cast<double>(chunk.data().size());
    }
  }
  EXPECT_EQ(scrape["latticed_chunk_bytes_total"], bytes);
}

TEST_F(MetricsTest, RevisionsThatAViewSkippedAreMerged) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);
  v1::DeformRequest pause;
  pause.mutable_control()->set_pause(true);
  ASSERT_TRUE(client.Send(pause));

  for (uint64_t sequence = 1; sequence <= 3; ++sequence) {
    ASSERT_TRUE(client.Send(Move(sequence, 62, 0.1)));
  }
  client.ReadUntil([&] { return client.log.results.size() == 3; });
  pause.mutable_control()->set_pause(false);
  ASSERT_TRUE(client.Send(pause));
  client.ReadUntilRevision(3);

  EXPECT_EQ(Scrape(*server_)["latticed_revisions_merged_total"], 2);
}

TEST_F(MetricsTest, StagesAreHistogramsInTheBucketsOfGrpc) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch());
  client.ReadUntilRevision(0);
  ASSERT_TRUE(client.Send(Move(1, 62, 0.1)));
  client.ReadUntilRevision(1);

  const Scrape scrape(*server_);

  const std::map<std::string, double> counts = {
      {"queue", 1}, {"evaluate", 2}, {"encode", 2}, {"send", 2}};
  for (const auto& [stage, count] : counts) {
    const auto series = [&stage](const char* part, const std::string& bound) {
      const std::string le = bound.empty() ? "" : fmt::format(R"(,le="{}")", bound);
      return fmt::format(R"(latticed_stage_duration_seconds_{}{{stage="{}"{}}})", part, stage, le);
    };
    EXPECT_EQ(scrape[series("count", "")], count) << stage;
    EXPECT_EQ(scrape[series("bucket", "+Inf")], count) << stage;
    EXPECT_EQ(scrape[series("bucket", "100")], count) << stage;
    EXPECT_LE(scrape[series("bucket", "0.001")], scrape[series("bucket", "0.002")]) << stage;
    EXPECT_GT(scrape[series("sum", "")], 0) << stage;
    EXPECT_LT(scrape[series("sum", "")], 60) << stage;
  }
}

TEST_F(MetricsTest, AnEditIsEncodedOnceForAllWatchersOfAView) {
  constexpr uint64_t kEdits = 4;
  CreateScene();
  v1::WatchRequest watch = Watch();
  std::vector<std::unique_ptr<WatchClient>> watchers;
  uint64_t revision = 0;
  for (const int segments : {4, 2}) {  // of one view, then of two
    const double views = segments == 4 ? 1 : 2;
    SCOPED_TRACE(views);
    watch.mutable_view()->set_segments(segments);
    for (int i = 0; i < 20; ++i) {
      watchers.push_back(std::make_unique<WatchClient>(*scenes_, watch));
      watchers.back()->ReadUpdates(1);
    }

    for (uint64_t edit = 0; edit < kEdits; ++edit) {
      const Scrape before(*server_);
      ++revision;
      ASSERT_TRUE(Apply(Move(revision, 62, 0.1)).ok());
      for (const auto& watcher : watchers) {
        watcher->ReadUntil([&] { return watcher->log.ends.back().revision() == revision; });
      }
      const Scrape after(*server_);

      const auto rise = [&](const std::string& series) { return after[series] - before[series]; };
      for (const char* stage : {"evaluate", "encode"}) {
        const std::string count =
            fmt::format(R"(latticed_stage_duration_seconds_count{{stage="{}"}})", stage);
        EXPECT_EQ(rise(count), views) << stage << " at revision " << revision;
      }
      EXPECT_EQ(rise("latticed_updates_finished_total"), static_cast<double>(watchers.size()));
    }
  }
  for (const auto& watcher : watchers) {
    EXPECT_GT(watcher->log.begins.back().chunk_count(), 0u) << "the edit shows";
  }
}

TEST_F(MetricsTest, CallsAreCountedByRpcAndCode) {
  CreateScene();
  v1::GetSceneRequest request;
  v1::Scene scene;
  for (const char* id : {kScene, "no-such-scene"}) {
    grpc::ClientContext context;
    request.set_scene(id);
    (void)scenes_->GetScene(&context, request, &scene);
  }
  ASSERT_TRUE(Apply(Move(1, 62, 0.1)).ok());

  const Scrape scrape(*server_);

  EXPECT_EQ(scrape[R"(latticed_rpc_started_total{method="SceneService/GetScene"})"], 2);
  EXPECT_EQ(scrape[R"(latticed_rpc_finished_total{method="SceneService/GetScene",code="OK"})"], 1);
  EXPECT_EQ(
      scrape[R"(latticed_rpc_finished_total{method="SceneService/GetScene",code="NOT_FOUND"})"], 1);
  EXPECT_EQ(scrape[R"(latticed_rpc_finished_total{method="SceneService/ApplyEdits",code="OK"})"],
            1);
  EXPECT_EQ(scrape[R"(latticed_rpc_duration_seconds_count{method="SceneService/GetScene"})"], 2);
  EXPECT_EQ(scrape[R"(latticed_refusals_total{reason="NOT_FOUND"})"], 1);
  EXPECT_EQ(scrape[R"(latticed_refusals_total{reason="OUT_OF_MEMORY"})"], 0);
}

TEST_F(MetricsTest, WhatTheBudgetRefusesIsCounted) {
  v1::BeginUploadRequest request;
  request.mutable_header()->set_format(v1::MESH_FORMAT_OBJ);
  request.mutable_header()->set_total_bytes(Info().limits().max_mesh_bytes());
  uint64_t refused = 0;
  for (int i = 0; i < 6; ++i) {  // a GiB each, of 4
    grpc::ClientContext context;
    v1::BeginUploadResponse response;
    if (!meshes_->BeginUpload(&context, request, &response).ok()) ++refused;
  }

  const Scrape scrape(*server_);

  EXPECT_EQ(refused, 2u);
  EXPECT_EQ(scrape[R"(latticed_refusals_total{reason="OUT_OF_MEMORY"})"], 2);
  EXPECT_EQ(scrape["latticed_uploads"], 4);
  EXPECT_EQ(scrape["latticed_host_memory_reserved_bytes"],
            scrape["latticed_host_memory_budget_bytes"]);
}

TEST_F(MetricsTest, WordsOfClientsAreInNoLabel) {
  CreateScene();
  DeformClient client(*scenes_);
  client.Open(Watch("an-editor"));
  client.ReadUntilRevision(0);

  const Scrape scrape(*server_);

  for (const std::string& word : {std::string(kScene), mesh_id_, std::string("an-editor")}) {
    EXPECT_EQ(scrape.text.find(word), std::string::npos) << word;
  }
}

}  // namespace
}  // namespace latticed::testing
