// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scene of the engine with an editor and a watcher, without a transport.
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

// All backends of this machine, made once.
[[nodiscard]] const std::vector<std::unique_ptr<Backend>>& AllBackends();

// A scene of the scenario's mesh and lattice whose default view has `encoding`.
[[nodiscard]] SceneConfig ConfigOf(const Scenario& scenario, Encoding encoding);

// Moves all control points around a circle, by the golden angle each time. However many moves an
// update merges, the points end up somewhere else. Threads: one at a time.
class Circling {
 public:
  explicit Circling(std::shared_ptr<Scene> scene);
  // Returns the revision that the move made.
  uint64_t Move();

 private:
  const std::shared_ptr<Scene> scene_;
  EditBatch batch_;
  MoveControlPoints move_;
  double angle_ = 0;
};

// Moves the control points every millisecond until it is destroyed.
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

// Takes every update of the default view as soon as it comes.
class Reader {
 public:
  explicit Reader(std::shared_ptr<Scene> scene);
  // Waits for the next update to be complete.
  UpdateEnds NextUpdate();

 private:
  class Bell;

  std::shared_ptr<Bell> bell_;
  std::unique_ptr<Watcher> watcher_;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_SERVER_WATCHED_SCENE_H_
