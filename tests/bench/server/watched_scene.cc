// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/server/watched_scene.h"

#include <cmath>
#include <utility>
#include <variant>

#include "absl/time/clock.h"
#include "core/base/mutex.h"
#include "fmt/format.h"
#include "server/backends.h"

namespace latticed::bench {
namespace {

constexpr absl::Duration kEditEvery = absl::Milliseconds(1);
constexpr double kGoldenAngle = 2.399963229728653, kStep = 0.01;

}  // namespace

const std::vector<std::unique_ptr<Backend>>& AllBackends() {
  static const auto* backends =
      new std::vector<std::unique_ptr<Backend>>(Checked(MakeBackends({})));
  return *backends;
}

SceneConfig ConfigOf(const Scenario& scenario, Encoding encoding) {
  SceneConfig config;
  config.id = scenario.name;
  config.mesh_id = scenario.name;
  config.mesh = scenario.plan->mesh;
  config.lattices = {
      {.structure = scenario.plan->structure, .control_points = scenario.control_points[0]}};
  config.default_view.key.encoding = encoding;
  config.default_view.key.spec.format = FormatOf(encoding);
  config.pipeline = Pipeline::kFused;
  return config;
}

Circling::Circling(std::shared_ptr<Scene> scene) : scene_(std::move(scene)) {
  // An editor's sequence numbers must ascend, so each Circling is another editor.
  static std::atomic<int> editors = 0;
  batch_.editor_id = fmt::format("editor-{}", ++editors);
  batch_.structure_id = scene_->State()->structure_id;
  for (size_t i = 0; i < scene_->State()->control_points->size(); ++i) {
    move_.indices.push_back(static_cast<uint32_t>(i));
  }
}

uint64_t Circling::Move() {
  ++batch_.sequence;
  angle_ += kGoldenAngle;
  move_.offset = {kStep * std::cos(angle_), kStep * std::sin(angle_), 0};
  batch_.edits = {move_};
  return Checked(scene_->ApplyEdits(batch_)).revision;
}

void Editor::Run() {
  while (!stopping_) {
    moves_.Move();
    absl::SleepFor(kEditEvery);
  }
}

class Reader::Bell : public SceneListener {
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

Reader::Reader(std::shared_ptr<Scene> scene) : bell_(std::make_shared<Bell>()) {
  scene->AddListener(bell_);
  const WatchView view = scene->config().default_view;
  watcher_ = Checked(Watcher::Create(
      std::move(scene), {.evaluator = "bench", .view = view, .max_unacked_updates = 0}));
}

UpdateEnds Reader::NextUpdate() {
  while (true) {
    auto event = Checked(watcher_->Next(absl::Now()));
    if (!event.has_value()) {
      bell_->Wait();
    } else if (auto* end = std::get_if<UpdateEnds>(&*event)) {
      return *end;
    }
  }
}

}  // namespace latticed::bench
