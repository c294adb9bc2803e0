// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scene engine under an editor that never rests: the time from one whole update to the next,
// and how old an update is when it is whole. Without a transport; the stages of the view in turn
// and overlapped, whatever the backend asks for: on the host's own cores that does not pay.
#include <memory>
#include <string>
#include <utility>

#include "core/base/status_macros.h"
#include "server/stores/scene_registry.h"
#include "tests/bench/benches.h"
#include "tests/bench/server/watched_scene.h"

namespace latticed::bench {
namespace {

// A target that says what it is told about overlapping.
class SwitchedTarget : public DeformTarget {
 public:
  SwitchedTarget(std::shared_ptr<DeformTarget> inner, bool overlap)
      : inner_(std::move(inner)), overlap_(overlap) {}
  const DeformPlan& plan() const override { return inner_->plan(); }
  Pipeline pipeline() const override { return inner_->pipeline(); }
  bool evaluates_on_device() const override { return overlap_; }
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override {
    return inner_->CreateView(spec);
  }
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override {
    return inner_->ControlNets(control_points, first, last);
  }
  MemoryUse memory() const override { return inner_->memory(); }

 private:
  const std::shared_ptr<DeformTarget> inner_;
  const bool overlap_;
};

class SwitchedBackend : public Backend {
 public:
  SwitchedBackend(Backend* inner, bool overlap) : inner_(inner), overlap_(overlap) {}
  std::string_view name() const override { return inner_->name(); }
  std::string description() const override { return inner_->description(); }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override {
    LATTICED_ASSIGN_OR_RETURN(auto target, inner_->Prepare(std::move(plan), pipeline));
    return std::make_shared<SwitchedTarget>(std::move(target), overlap_);
  }

 private:
  Backend* const inner_;
  const bool overlap_;
};

void Updates(benchmark::State& state, Backend* inner, Encoding encoding, bool overlap) {
  SwitchedBackend backend(inner, overlap);
  SceneRegistry registry(&backend, 2);
  const auto scene = registry.Create(ConfigOf(SmallScenario(2), encoding));
  CheckOk(scene.status());
  Reader reader(*scene);
  const Editor editor(*scene);
  for (int warm_up = 0; warm_up < 3; ++warm_up) reader.NextUpdate();

  // Of the update when it is whole.
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
      for (const bool overlap : {false, true}) {
        benchmark::RegisterBenchmark(
            ("engine/" + std::string(backend->name()) + "/" + name +
             (overlap ? "/overlapped" : "/in-turn"))
                .c_str(),
            [backend = backend.get(), encoding = encoding, overlap](benchmark::State& state) {
              Updates(state, backend, encoding, overlap);
            })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime()
            ->MinTime(1)
            ->Repetitions(5);
      }
    }
  }
}

}  // namespace latticed::bench
