// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How the latencies follow from the times of edits and updates.
#include "client/cpp/load/load_report.h"

#include <cmath>
#include <string>
#include <vector>

#include "client/cpp/latticectl/commands/load_plan.h"
#include "client/cpp/load/load_edit.h"
#include "client/cpp/load/report_output.h"
#include "fmt/format.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Adds an update of that revision, with one chunk of 100 bytes, to the log.
void TakeUpdate(uint64_t revision, bool restart, UpdateLog* log) {
  v1::SceneEvent event;
  event.mutable_update_begin()->set_revision(revision);
  event.mutable_update_begin()->set_restart(restart);
  log->Take(event);
  event.mutable_chunks()->add_chunks()->set_data(std::string(100, 'x'));
  log->Take(event);
  event.mutable_update_end()->set_revision(revision);
  event.mutable_update_end()->mutable_timings()->set_queue_us(3000);
  event.mutable_update_end()->mutable_timings()->set_encode_us(1500);
  log->Take(event);
}

TEST(LatencyRecorder, TakesTheNearestRank) {
  LatencyRecorder recorder;
  for (int ms = 200; ms >= 1; --ms) recorder.Add(absl::Milliseconds(ms));
  const LatencySummary summary = recorder.Summarise();
  EXPECT_EQ(summary.count, 200u);
  EXPECT_EQ(summary.p50, 100);
  EXPECT_EQ(summary.p90, 180);
  EXPECT_EQ(summary.p99, 198);
  EXPECT_EQ(summary.max, 200);
  EXPECT_EQ(LatencyRecorder().Summarise().max, 0);
}

TEST(StreamGroup, AnUpdateAnswersAllEditsThatItHolds) {
  UpdateLog log;
  TakeUpdate(2, true, &log);  // of the warm-up
  TakeUpdate(4, false, &log);
  TakeUpdate(5, true, &log);
  TakeUpdate(6, false, &log);  // answers no counted edit
  const absl::Time end = log.updates()[1].end;
  const std::vector<TimedEdit> edits{{end - absl::Milliseconds(9), 3},
                                     {end - absl::Milliseconds(5), 4},
                                     {end - absl::Milliseconds(8), 4},
                                     {end - absl::Milliseconds(1), 5},
                                     {end, 7}};
  StreamGroup group;
  group.Add(log, edits, /*first_revision=*/2);

  EXPECT_EQ(group.updates, 3u);
  EXPECT_EQ(group.bytes, 300u);
  EXPECT_EQ(group.merged, 2u);
  EXPECT_EQ(group.restarted, 1u);
  EXPECT_EQ(group.unseen, 1u);
  EXPECT_EQ(group.update_end.count(), 4u);
  EXPECT_EQ(group.first_chunk.count(), 4u);
  EXPECT_EQ(group.decoded.count(), 0u);
  EXPECT_NEAR(group.update_end.Summarise().p50, 5, 1e-6);  // of 9, 5, 8 and a little more than 1 ms
  ServerStages stages;
  stages.Add(log, {}, 2);
  EXPECT_EQ(stages.encode.count(), 3u);
  EXPECT_EQ(stages.encode.Summarise().p50, 1.5);
}

TEST(ServerStages, AddsTheEditThatMadeAnUpdatesRevisionToTheUpdate) {
  UpdateLog log;
  TakeUpdate(2, false, &log);  // of the warm-up
  for (const uint64_t revision : {4u, 5u, 5u, 6u}) TakeUpdate(revision, false, &log);
  const std::vector<AppliedBatch> batches{
      {.revision = 3, .apply_time = absl::Milliseconds(90)},  // merged into revision 4
      {.revision = 4, .apply_time = absl::Milliseconds(10)},
      {.revision = 5, .apply_time = absl::Milliseconds(20)}};
  ServerStages stages;
  stages.Add(log, batches, /*first_revision=*/2);

  EXPECT_EQ(stages.apply.count(), 3u);
  EXPECT_EQ(stages.arrival_to_bytes.count(), 2u)
      << "revision 5 once, and 6 is nobody's that is counted";
  EXPECT_NEAR(stages.arrival_to_bytes.Summarise().p50, 10 + 3, 1e-9);
  EXPECT_NEAR(stages.arrival_to_bytes.Summarise().max, 20 + 3, 1e-9);
}

TEST(TimeShares, AreWhatEveryStageTakesTheLongestFirst) {
  LoadReport report;
  EXPECT_TRUE(TimeShares(report).empty());
  const auto add = [](LatencyRecorder& recorder, int ms) { recorder.Add(absl::Milliseconds(ms)); };
  add(report.stages.apply, 1);
  add(report.stages.queue, 12);
  add(report.stages.evaluate, 4);
  add(report.stages.encode, 6);
  add(report.stages.send, 3);
  add(report.editors.update_end, 21);
  const auto texts = [&report] {
    std::vector<std::string> texts;
    for (const auto& [key, name, ms] : TimeShares(report))
      texts.push_back(fmt::format("{} {}", key, ms));
    return texts;
  };

  EXPECT_THAT(texts(),
              ElementsAre("encode 6", "way 5", "evaluate 4", "send 3", "wait 2", "apply 1"));
  add(report.editors.decoded, 100);
  EXPECT_EQ(texts().front(), "decode 79");
  EXPECT_THAT(
      LoadMarkdown({}, report),
      HasSubstr("* where the time goes: decoding 79.00 ms, encoding 6.00 ms, on the way 5.00 "
                "ms, evaluating 4.00 ms, sending 3.00 ms, waiting for a turn 2.00 ms, "
                "applying 1.00 ms, the median of each\n"
                "* next bottleneck: decoding, 79 % of these 100.00 ms\n"));
}

TEST(MakeLoadEdit, ComesBackToWhereItBegan) {
  v1::LatticeState lattice;
  lattice.mutable_lattice()->mutable_frame()->mutable_u()->set_x(2);
  for (int i = 0; i < 3 * 5; ++i) lattice.mutable_lattice()->add_control_points(0);
  for (const bool all_points : {true, false}) {
    std::vector<double> moved(5);
    for (uint64_t step = 0; step < 10; ++step) {
      const v1::EditBatch batch = MakeLoadEdit(lattice, all_points, step);
      const auto& move = batch.edits(0).move_control_points();
      EXPECT_NEAR(std::abs(move.offset().z()), 0.2, 1e-12);
      for (const uint32_t i : move.indices()) moved[i] += move.offset().z();
    }
    for (const double z : moved) EXPECT_NEAR(z, 0, 1e-12) << all_points;
  }
}

}  // namespace
}  // namespace latticed::client
