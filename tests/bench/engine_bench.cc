// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scene engine under an editor that never rests: the time from one whole update to the next,
// and how old an update is when it is whole. Without a transport; the stages of the view in turn
// and overlapped, whatever the backend asks for: on the host's own cores that does not pay.
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include "absl/time/clock.h"
#include "server/backends.h"
#include "server/scene_registry.h"
#include "server/watcher.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

constexpr absl::Duration kEditEvery = absl::Milliseconds(1);

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
    auto target = inner_->Prepare(std::move(plan), pipeline);
    if (!target.ok()) return target.status();
    return std::make_shared<SwitchedTarget>(*std::move(target), overlap_);
  }

 private:
  Backend* const inner_;
  const bool overlap_;
};

SceneConfig TorusConfig(Encoding encoding) {
  const DeformPlan& plan = *SmallScenario(2).plan;
  SceneConfig config;
  config.id = "torus";
  config.mesh_id = "torus";
  config.mesh = plan.mesh;
  config.lattice = {.structure = plan.structure,
                    .control_points = SmallScenario(2).control_points[0]};
  config.default_view.key.encoding = encoding;
  config.default_view.key.spec.format = FormatOf(encoding);
  config.pipeline = Pipeline::kFused;
  return config;
}

// Moves all control points to and fro until it is destroyed.
class Editor {
 public:
  explicit Editor(std::shared_ptr<Scene> scene)
      : scene_(std::move(scene)), thread_([this] { Run(); }) {}
  ~Editor() {
    stopping_ = true;
    thread_.join();
  }

 private:
  void Run() {
    EditBatch batch;
    batch.editor_id = "editor";
    batch.structure_id = scene_->State()->structure_id;
    MoveControlPoints move;
    for (size_t i = 0; i < scene_->State()->control_points->size(); ++i) {
      move.indices.push_back(static_cast<uint32_t>(i));
    }
    for (move.offset = {0.01, 0, 0}; !stopping_; move.offset.x = -move.offset.x) {
      ++batch.sequence;
      batch.edits = {move};
      CheckOk(scene_->ApplyEdits(batch).status());
      absl::SleepFor(kEditEvery);
    }
  }

  const std::shared_ptr<Scene> scene_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

class Bell : public SceneListener {
 public:
  void OnSceneChanged() override {
    const MutexLock lock(&mutex_);
    rung_ = true;
  }
  void Wait() {
    const MutexLock lock(&mutex_);
    mutex_.AwaitFor([this] { return rung_; }, absl::Seconds(1));
    rung_ = false;
  }

 private:
  Mutex mutex_;
  bool rung_ = false;
};

// The age of the next update when it is whole.
absl::Duration NextUpdate(Watcher& watcher, Bell& bell) {
  while (true) {
    const auto event = watcher.Next(absl::Now());
    CheckOk(event.status());
    if (!event->has_value()) {
      bell.Wait();
    } else if (const auto* end = std::get_if<UpdateEnds>(&**event)) {
      return end->queue_time + end->send_time;
    }
  }
}

void Updates(benchmark::State& state, Backend* inner, Encoding encoding, bool overlap) {
  SwitchedBackend backend(inner, overlap);
  SceneRegistry registry(&backend, 2);
  const SceneConfig config = TorusConfig(encoding);
  const auto scene = registry.Create(config);
  CheckOk(scene.status());
  const auto bell = std::make_shared<Bell>();
  (*scene)->AddListener(bell);
  const auto watcher = Watcher::Create(
      *scene, {.boot_id = "bench", .view = config.default_view, .max_unacked_updates = 0});
  CheckOk(watcher.status());
  const Editor editor(*scene);
  for (int warm_up = 0; warm_up < 3; ++warm_up) NextUpdate(**watcher, *bell);

  absl::Duration age;
  for (auto _ : state) age += NextUpdate(**watcher, *bell);
  state.counters["age_ms"] =
      absl::ToDoubleMilliseconds(age) / static_cast<double>(state.iterations());
}

const std::vector<std::unique_ptr<Backend>>& AllBackends() {
  static const auto* backends = [] {
    auto made = MakeBackends({});
    CheckOk(made.status());
    return new std::vector<std::unique_ptr<Backend>>(*std::move(made));
  }();
  return *backends;
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
