// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of 1,000 patches beside one of 1,000,000 whose editor never pauses. Measures the time
// from an edit of the small scene to the complete update, alone and beside the huge one,
// alternating in one run.
//
//   bound = 2 updates of the small scene (median alone) + one batch of chunks of the huge scene,
//           evaluated and encoded (the batch's share of the huge scene's median update)
#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "fmt/format.h"
#include "server/stores/scene_registry.h"
#include "tests/bench/benches.h"
#include "tests/bench/server/watched_scene.h"

namespace latticed::bench {
namespace {

constexpr int kWorkers = 3;  // as in a server
constexpr int kRounds = 8;
constexpr int kAlonePerRound = 40, kBesidePerRound = 100;

// The names give the number of patches, to within 3 %.
const Scenario& Small() {
  static const auto* scenario =
      new Scenario(MakeScenario("torus-1k", MakeTorus(24, 12), {7, 7, 7}, {2, 2, 2}));
  return *scenario;
}
const Scenario& Huge() {
  static const auto* scenario =
      new Scenario(MakeScenario("torus-1m", MakeTorus(1000, 463), {7, 7, 7}, {2, 2, 2}));
  return *scenario;
}

double Quantile(std::vector<double> values, double q) {
  std::ranges::sort(values);
  return values[static_cast<size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

// Edits a scene without pause and reads all of its updates.
class BusyScene {
 public:
  explicit BusyScene(const std::shared_ptr<Scene>& scene)
      : reader_(scene), editor_(std::in_place, scene), thread_([this] { Run(); }) {}
  ~BusyScene() { Stop(); }
  // Stops at the end of an update. Returns the time of each update to evaluate and encode.
  const std::vector<absl::Duration>& Stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
    return updates_;
  }

 private:
  void Run() {
    while (!stopping_) {
      const UpdateEnds end = reader_.NextUpdate();
      updates_.push_back(end.evaluate_time + end.encode_time);
    }
    editor_.reset();
  }

  Reader reader_;
  std::optional<Editor> editor_;
  std::atomic<bool> stopping_ = false;
  std::vector<absl::Duration> updates_;
  std::thread thread_;  // last, because it uses all members above
};

void Measure(Reader& reader, Circling& moves, int count, std::vector<double>& into) {
  for (int i = 0; i < count; ++i) {
    const absl::Time start = absl::Now();
    const uint64_t revision = moves.Move();
    while (reader.NextUpdate().revision < revision) continue;
    into.push_back(absl::ToDoubleMilliseconds(absl::Now() - start));
  }
}

double BatchOf(const Scene& scene) {
  const auto target = Checked(scene.Head().target->Get());
  return static_cast<double>(target->Traits(scene.config().default_view.key.spec).encode_batch);
}

void SmallBesideHuge(benchmark::State& state, Backend* backend) {
  SceneRegistry registry(backend, kWorkers);
  const auto small = Checked(registry.Create(ConfigOf(Small(), Encoding::kDracoPoints)));
  const auto huge = Checked(registry.Create(ConfigOf(Huge(), Encoding::kDracoPoints)));
  Reader reader(small);
  Circling moves(small);
  std::vector<double> alone, beside, huge_ms;
  Measure(reader, moves, kAlonePerRound, alone);
  BusyScene(huge).Stop();
  alone.clear();
  for (int round = 0; round < kRounds; ++round) {
    Measure(reader, moves, kAlonePerRound, alone);
    BusyScene busy(huge);
    Measure(reader, moves, kBesidePerRound, beside);
    for (const absl::Duration d : busy.Stop()) huge_ms.push_back(absl::ToDoubleMilliseconds(d));
  }
  const double chunks = static_cast<double>(huge->State()->plan->chunk_count());
  const double batch_ms = Quantile(huge_ms, 0.5) * std::min(BatchOf(*huge) / chunks, 1.0);
  const double bound_ms = 2 * Quantile(alone, 0.5) + batch_ms, p99_ms = Quantile(beside, 0.99);
  for (auto _ : state) state.SetIterationTime(p99_ms * 1e-3);
  state.counters["alone_ms"] = Quantile(alone, 0.5);
  state.counters["median_ms"] = Quantile(beside, 0.5);
  state.counters["batch_ms"] = batch_ms;
  state.counters["huge_ms"] = Quantile(huge_ms, 0.5);
  state.counters["bound_ms"] = bound_ms;
  state.counters["of_bound"] = p99_ms / bound_ms;
}

}  // namespace

void RegisterFairnessBenches() {
  for (const auto& backend : AllBackends()) {
    RegisterOnce(
        fmt::format("fairness/{}", backend->name()),
        [backend = backend.get()](benchmark::State& state) { SmallBesideHuge(state, backend); });
  }
}

}  // namespace latticed::bench
