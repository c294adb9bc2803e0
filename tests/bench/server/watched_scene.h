// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of the engine under an editor and a watcher, without a transport.
#ifndef LATTICED_TESTS_BENCH_SERVER_WATCHED_SCENE_H_
#define LATTICED_TESTS_BENCH_SERVER_WATCHED_SCENE_H_

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/time/time.h"
#include "server/engine/watcher.h"
#include "server/stores/scene_registry.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

// All that this machine has, made once.
[[nodiscard]] const std::vector<std::unique_ptr<Backend>>& AllBackends();

// A scene of the scenario's mesh and lattice whose default view has `encoding`.
[[nodiscard]] SceneConfig ConfigOf(const Scenario& scenario, Encoding encoding);

// Moves all control points round a circle, each time by the golden angle: however many moves an
// update merges, they never leave the points where they were. Threads: one at a time.
class Circling {
 public:
  explicit Circling(std::shared_ptr<Scene> scene);
  // The revision that it made.
  uint64_t Move();

 private:
  const std::shared_ptr<Scene> scene_;
  EditBatch batch_;
  MoveControlPoints move_;
  double angle_ = 0;
};

// Moves them every millisecond until it is destroyed.
class Editor {
 public:
  explicit Editor(std::shared_ptr<Scene> scene)
      : moves_(std::move(scene)), thread_([this] { Run(); }) {}
  ~Editor() {
    stopping_ = true;
    thread_.join();
  }

 private:
  void Run();

  Circling moves_;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

// Takes every update of the default view at once.
class Reader {
 public:
  explicit Reader(std::shared_ptr<Scene> scene);
  // The next one, when it is whole.
  UpdateEnds NextUpdate();

 private:
  class Bell;

  std::shared_ptr<Bell> bell_;
  std::unique_ptr<Watcher> watcher_;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_SERVER_WATCHED_SCENE_H_
