// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The threads that evaluate and encode: round robin over the scenes that have work, one update of a
// view at a time. Two stages of one view overlap where two threads take them up (scene_view.h).
// Nothing is queued but the names of scenes: what to do is decided when a worker comes, so edits
// that arrive meanwhile merge.
//
//   worker   | huge, a part | small | huge, a part | huge, a part | medium | huge, a part | huge …
//
// A long update lets shorter ones ahead: after each of its parts, some milliseconds, its worker runs
// those of other scenes that are no longer than what it has done since it last let one ahead. So,
// beside any number of larger ones, an update waits for no more than another of its own size, and
// one part; and the long one has half of the worker's time or more.
//
// Threads  safe; work runs with no lock held. The destructor finishes what runs and drops the rest.
#ifndef LATTICED_SERVER_ENGINE_RENDER_UPDATE_PIPELINE_H_
#define LATTICED_SERVER_ENGINE_RENDER_UPDATE_PIPELINE_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace latticed {

class Scene;
struct ViewWork;

class UpdatePipeline {
 public:
  explicit UpdatePipeline(int workers);
  ~UpdatePipeline();
  UpdatePipeline(const UpdatePipeline&) = delete;  // its threads hold its address
  UpdatePipeline& operator=(const UpdatePipeline&) = delete;

  // Has a worker look at the scene; a scene waits at most once.
  void Schedule(const std::shared_ptr<Scene>& scene) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // An update that runs.
  struct Turn {
    const Scene* scene = nullptr;
    uint64_t points = 0;  // of all of it
    uint64_t credit = 0;  // of what is done, those that others have not had yet
  };

  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  void RunWork(const std::shared_ptr<Scene>& scene, ViewWork work) ABSL_LOCKS_EXCLUDED(mutex_);
  void LetOthersAhead(Turn& turn) ABSL_LOCKS_EXCLUDED(mutex_);
  // Those that wait, in order; none when it is time to stop.
  std::vector<std::weak_ptr<Scene>> Waiting() ABSL_LOCKS_EXCLUDED(mutex_);
  // Does nothing where another worker was first.
  void TakeOut(const std::shared_ptr<Scene>& scene) ABSL_LOCKS_EXCLUDED(mutex_);

  Mutex mutex_;
  std::deque<std::weak_ptr<Scene>> waiting_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_UPDATE_PIPELINE_H_
