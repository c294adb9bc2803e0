// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The least that durability costs: a file to which one thread appends all that waits, and then calls fdatasync.
//
// Threads  safe
#ifndef LATTICED_TESTS_BENCH_STORE_SYNCED_FILE_H_
#define LATTICED_TESTS_BENCH_STORE_SYNCED_FILE_H_

#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace latticed::bench {

class SyncedFile {
 public:
  explicit SyncedFile(const std::string& path);
  // Writes what waits.
  ~SyncedFile();
  SyncedFile(const SyncedFile&) = delete;  // one file
  SyncedFile& operator=(const SyncedFile&) = delete;

  void Append(std::string bytes, std::function<void()> done) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);

  const int file_;
  Mutex mutex_;
  std::vector<std::pair<std::string, std::function<void()>>> waiting_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // last: it uses the rest
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_STORE_SYNCED_FILE_H_
