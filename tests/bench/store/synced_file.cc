// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/synced_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>

namespace latticed::bench {

SyncedFile::SyncedFile(const std::string& path)
    : file_(open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600)),
      thread_([this] { Run(); }) {}

SyncedFile::~SyncedFile() {
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.join();
  close(file_);
}

void SyncedFile::Append(std::string bytes, std::function<void()> done) {
  MutexLock lock(&mutex_);
  waiting_.emplace_back(std::move(bytes), std::move(done));
}

void SyncedFile::Run() {
  while (true) {
    decltype(waiting_) taken;
    {
      MutexLock lock(&mutex_);
      mutex_.Await([this] { return !waiting_.empty() || stopping_; });
      if (waiting_.empty()) return;
      std::swap(taken, waiting_);
    }
    std::string bytes;
    for (const auto& [record, done] : taken) bytes += record;
    if (write(file_, bytes.data(), bytes.size()) < 0 || fdatasync(file_) != 0) std::abort();
    for (const auto& [record, done] : taken) done();
  }
}

}  // namespace latticed::bench
