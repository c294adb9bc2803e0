// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scene engine under an editor that never pauses, without a transport: the time from one
// complete update to the next, and age_ms, the time from an update's edit until it is complete.
#include <string>
#include <utility>

#include "server/stores/scene_registry.h"
#include "tests/bench/benches.h"
#include "tests/bench/server/watched_scene.h"

namespace latticed::bench {
namespace {

void Updates(benchmark::State& state, Backend* backend, Encoding encoding) {
  SceneRegistry registry(backend, 3);
  const auto scene = Checked(registry.Create(ConfigOf(SmallScenario(2), encoding)));
  Reader reader(scene);
  const Editor editor(scene);
  for (int warm_up = 0; warm_up < 3; ++warm_up) reader.NextUpdate();

  // Sum of the ages of updates at their completion.
  absl::Duration age;
  for (auto _ : state) {
    const UpdateEnds end = reader.NextUpdate();
    age += end.queue_time + end.send_time;
  }
  state.counters["age_ms"] =
      absl::ToDoubleMilliseconds(age) / static_cast<double>(state.iterations());
}

}  // namespace

void RegisterEngineBenches() {
  for (const auto& backend : AllBackends()) {
    for (const auto& [name, encoding] : {std::pair("draco", Encoding::kDracoPoints),
                                         std::pair("quantised", Encoding::kQuantised)}) {
      benchmark::RegisterBenchmark(
          ("engine/" + std::string(backend->name()) + "/" + name).c_str(),
          [backend = backend.get(), encoding = encoding](benchmark::State& state) {
            Updates(state, backend, encoding);
          })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime()
          ->MinTime(1)
          ->Repetitions(5);
    }
  }
}

}  // namespace latticed::bench
