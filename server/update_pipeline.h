// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The threads that evaluate and encode: round robin over the scenes that have work, one update of a
// view at a time, so that a heavy scene delays the others by one update and no more. Two stages of
// one view overlap where two threads take them up (scene_view.h). Nothing is queued but
// the names of scenes: what to do is decided when a worker comes, so edits that arrive meanwhile
// merge.
//
// Threads  safe; work runs with no lock held. The destructor finishes what runs and drops the rest.
#ifndef LATTICED_SERVER_UPDATE_PIPELINE_H_
#define LATTICED_SERVER_UPDATE_PIPELINE_H_

#include <deque>
#include <memory>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "server/mutex.h"

namespace latticed {

class Scene;

class UpdatePipeline {
 public:
  explicit UpdatePipeline(int workers);
  ~UpdatePipeline();
  UpdatePipeline(const UpdatePipeline&) = delete;  // its threads hold its address
  UpdatePipeline& operator=(const UpdatePipeline&) = delete;

  // Has a worker look at the scene; a scene waits at most once.
  void Schedule(const std::shared_ptr<Scene>& scene) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);

  Mutex mutex_;
  std::deque<std::weak_ptr<Scene>> waiting_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_UPDATE_PIPELINE_H_
