// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/store/sqlite/checkpointer.h"

#include <sqlite3.h>

#include <string>
#include <utility>

#include "server/base/telemetry.h"

namespace latticed {

Checkpointer::Checkpointer(SqliteConnection database)
    : database_(std::move(database)), thread_([this] { Run(); }) {}

Checkpointer::~Checkpointer() {
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.join();
}

void Checkpointer::Wake() {
  MutexLock lock(&mutex_);
  due_ = true;
}

void Checkpointer::Run() {
  bool failed = false;
  while (true) {
    {
      MutexLock lock(&mutex_);
      mutex_.Await([this] { return due_ || stopping_; });
      if (stopping_) return;
      due_ = false;
    }
    const int code = sqlite3_wal_checkpoint_v2(database_.get(), nullptr, SQLITE_CHECKPOINT_PASSIVE,
                                               nullptr, nullptr);
    const absl::Status status = code == SQLITE_BUSY ? absl::OkStatus() : database_.Status(code);
    if (!status.ok() && !failed) {
      LogEvent(spdlog::level::warn, "checkpoint of the store failed",
               {{"error", std::string(status.message())}});
    }
    failed = !status.ok();
  }
}

}  // namespace latticed
